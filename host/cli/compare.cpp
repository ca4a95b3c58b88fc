#include "host/cli/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/cli/output_file.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/sha256.hpp"
#include "host/invert/comparison.hpp"

namespace umov::cli {
namespace {

std::vector<std::string> names_of(const std::string& text) {
  std::vector<std::string> out;
  for (std::size_t first = 0; first <= text.size();) {
    const std::size_t comma = std::min(text.find(',', first), text.size());
    const std::string name = text.substr(first, comma - first);
    first = comma + 1;
    if (name.empty()) continue;
    if (name == "all") {
      for (std::string& model : invert::library_models()) out.push_back(std::move(model));
    } else {
      out.push_back(name);
    }
  }
  if (out.empty())
    throw Error("--compare names no model", "write all, or names such as ggx+nef,nef");
  return out;
}

std::string comparison_path(const std::string& output) {
  const std::string ending = ".json";
  return (output.ends_with(ending) ? output.substr(0, output.size() - ending.size()) : output) +
         ".compare.json";
}

nlohmann::ordered_json comparison_json(const CompareArguments& arguments,
                                       const invert::Comparison& comparison, const Common& common) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const invert::Contender& c : comparison.contenders) {
    nlohmann::ordered_json row{{"model", c.model}};
    if (!c.failure.empty()) {
      row["failure"] = c.failure;
    } else {
      row["log_predictive_density"] = c.log_density;
      row["chi2_per_point"] = c.chi2_per_point;
      row["median_abs_relative"] = c.median_relative;
      row["p90_abs_relative"] = c.p90_relative;
      row["parameters"] = c.parameters;
      row["bic"] = c.bic ? nlohmann::ordered_json(*c.bic) : nlohmann::ordered_json(nullptr);
      row["training_scale"] = c.scale;
      row["converged"] = !c.fit || c.fit->converged;
    }
    row["seconds"] = c.seconds;
    list.push_back(std::move(row));
  }
  return {{"data_file", arguments.input},
          {"data_sha256", formats::sha256_of_file(arguments.input)},
          {"program", std::string("umov ") + UMOV_VERSION},
          {"command", common.command_line},
          {"fitted_rows", arguments.rows},
          {"training_points", comparison.training_points},
          {"held_out_points", comparison.held_out_points},
          {"models", list}};
}

void print_comparison(const invert::Comparison& comparison) {
  fmt::print("{} points fitted, {} held out; best first\n", comparison.training_points,
             comparison.held_out_points);
  fmt::print("  {:<34} {:>12} {:>11} {:>9} {:>9} {:>5} {:>12} {:>8}\n", "model", "log density",
             "chi2/point", "median %", "90th %", "free", "BIC", "s");
  for (const invert::Contender& c : comparison.contenders) {
    if (!c.failure.empty()) {
      fmt::print("  {:<34} {}\n", c.model, c.failure);
      continue;
    }
    fmt::print("  {:<34} {:>12.5g} {:>11.4g} {:>9.3g} {:>9.3g} {:>5} {:>12} {:>8.2f}\n", c.model,
               c.log_density, c.chi2_per_point, 100 * c.median_relative, 100 * c.p90_relative,
               c.parameters, c.bic ? fmt::format("{:.1f}", *c.bic) : "none", c.seconds);
  }
}

}  // namespace

void compare_command(const CompareArguments& arguments, const formats::BrdfTable& table,
                     const formats::BrdfTable* training, const invert::Options& options,
                     const Common& common, Progress& progress) {
  const std::string path = comparison_path(arguments.output);
  require_product_output({arguments.input, arguments.output}, path);
  std::vector<bool> held_out;
  if (training == nullptr) {
    held_out = invert::every_fifth_row(table);
  } else {
    for (std::size_t i = 0; i < table.points.size(); ++i) {
      held_out.push_back(table.points.used[i] != 0 && training->points.used[i] == 0);
    }
  }
  const invert::Comparison comparison =
      invert::compare_models(table, held_out, names_of(arguments.models), options);
  progress.finish();
  const std::string text = comparison_json(arguments, comparison, common).dump(1) + "\n";
  formats::replace_file(path, text);
  for (const invert::Contender& contender : comparison.contenders) {
    if (!contender.fit || !contender.failure.empty()) continue;
    formats::FitResult fit = *contender.fit;
    fit.data_file = arguments.input;
    fit.data_sha256 = formats::sha256_of_file(arguments.input);
    fit.program = std::string("umov ") + UMOV_VERSION;
    fit.command = common.command_line;
    formats::write_fit(arguments.output, fit);
    break;
  }
  if (common.json) {
    fmt::print("{}", text);
  } else if (!common.quiet) {
    print_comparison(comparison);
  }
}

}  // namespace umov::cli
