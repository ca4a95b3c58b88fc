// umov invert: from a reduced measurement to a model with intervals, and what they leave open.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/command.hpp"
#include "host/cli/compare.hpp"
#include "host/cli/fit_text.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/progress.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/sha256.hpp"
#include "host/invert/directions.hpp"
#include "host/invert/invert.hpp"
#include "host/invert/prediction.hpp"
#include "host/invert/prior.hpp"
#include "host/invert/row_selection.hpp"

namespace umov::cli {
namespace {

struct Arguments {
  std::string input;
  std::string output = "fit.json";
  std::vector<std::string> fix, start, bound, rows, prior;
  std::string compare;
  std::string predict, predict_output = "prediction.csv";
  std::string objective = "noise";
  bool no_held_out = false;
  bool list_start = false;
  bool residuals = false;
  std::string hemisphere;
  std::vector<double> theta_i_deg;
  double theta_step_deg = 2, phi_step_deg = 5;
  invert::Options options;
};

double number(const std::string& option, const std::string& text) {
  double value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    throw Error("'" + text + "' in " + option + " is not a number",
                "write for example --fix n=1.5, --fix kappa@532=0.3 or --bound n=1.3:1.7");
  }
  return value;
}

/// "name=rest" or "name@532=rest".
struct Assignment {
  std::string name;
  std::optional<double> wavelength_nm;
  std::string rest;
};

Assignment assignment(const std::string& option, const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw Error(option + " " + text + " has no value", "write " + option + " NAME=VALUE");
  }
  Assignment out{text.substr(0, equals), std::nullopt, text.substr(equals + 1)};
  if (const auto at = out.name.find('@'); at != std::string::npos) {
    out.wavelength_nm = number(option, out.name.substr(at + 1));
    out.name.resize(at);
  }
  return out;
}

std::vector<invert::Setting> settings(const std::string& option,
                                      const std::vector<std::string>& texts) {
  std::vector<invert::Setting> out;
  for (const std::string& text : texts) {
    const Assignment a = assignment(option, text);
    out.push_back({a.name, a.wavelength_nm, number(option + " " + text, a.rest)});
  }
  return out;
}

std::vector<invert::Limits> limits(const std::vector<std::string>& texts) {
  std::vector<invert::Limits> out;
  for (const std::string& text : texts) {
    const Assignment a = assignment("--bound", text);
    const auto colon = a.rest.find(':');
    if (colon == std::string::npos) {
      throw Error("--bound " + text + " has one limit only", "write --bound NAME=LO:HI");
    }
    out.push_back({a.name, a.wavelength_nm, number("--bound " + text, a.rest.substr(0, colon)),
                   number("--bound " + text, a.rest.substr(colon + 1))});
  }
  return out;
}

void list_start(const Arguments& arguments, const formats::BrdfTable& table, const Common& common) {
  const auto values = invert::starting_values(table, arguments.options);
  if (common.json) {
    nlohmann::ordered_json out = nlohmann::ordered_json::array();
    for (const auto& v : values) {
      out.push_back({{"name", v.name},
                     {"unit", v.unit},
                     {"shared", v.shared},
                     {"fixed", v.fixed},
                     {"lo", v.lo},
                     {"hi", v.hi},
                     {"values", v.values}});
    }
    fmt::print("{}\n", out.dump());
    return;
  }
  for (const auto& v : values) {
    fmt::print("  {:<20} {:>6}  {:.4g} … {:.4g}  ", v.name, v.unit, v.lo, v.hi);
    for (const double value : v.values) fmt::print(" {:.5g}", value);
    fmt::print("  {}{}\n", v.fixed ? "held; " : "", v.meaning);
  }
}

/// The user's incidences, else those of the data.
std::vector<double> incidences(const Arguments& arguments, const formats::BrdfTable& table) {
  std::vector<double> angles = arguments.theta_i_deg;
  if (angles.empty()) {
    for (std::size_t i = 0; i < table.points.size(); ++i) {
      if (table.points.used[i] != 0) angles.push_back(std::abs(table.points.theta_i_deg[i]));
    }
    std::sort(angles.begin(), angles.end());
    angles.erase(std::unique(angles.begin(), angles.end()), angles.end());
  }
  return angles;
}

void write_prediction(const Arguments& arguments, const formats::FitResult& fit,
                      const formats::BrdfTable& table, int threads) {
  const std::vector<invert::Direction> directions =
      arguments.predict.ends_with(".csv")
          ? invert::read_directions(arguments.predict, fit.wavelengths_nm)
          : invert::direction_grid(arguments.predict, fit.wavelengths_nm,
                                   incidences(arguments, table));
  formats::replace_file(arguments.predict_output,
                        invert::directions_csv(invert::predict_directions(invert::FittedModel(fit),
                                                                          directions, threads)));
}

void write_hemispheres(const Arguments& arguments, const formats::FitResult& fit,
                       const formats::BrdfTable& table) {
  const std::vector<double> angles = incidences(arguments, table);
  std::vector<invert::Hemisphere> parts;
  for (const double nm : fit.wavelengths_nm) {
    for (const double theta_i : angles) {
      parts.push_back(
          invert::hemisphere(fit, nm, theta_i, arguments.theta_step_deg, arguments.phi_step_deg));
    }
  }
  if (arguments.hemisphere.ends_with(".csv")) {
    invert::write_hemispheres_csv(arguments.hemisphere, parts);
  } else if (arguments.hemisphere.ends_with(".h5")) {
    formats::Provenance provenance;
    provenance.program = fit.program;
    provenance.command = fit.command;
    invert::write_hemispheres_hdf5(
        arguments.hemisphere, parts, provenance,
        {{"model", fit.model}, {"data_file", fit.data_file}, {"data_sha256", fit.data_sha256}});
  }
}

nlohmann::ordered_json prediction_json(const std::vector<std::string>& rows,
                                       const std::vector<invert::PredictionError>& errors) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& e : errors) {
    list.push_back({{"set", e.set},
                    {"wavelength_nm", e.wavelength_nm},
                    {"points", e.points},
                    {"median_abs_relative", e.median_abs},
                    {"p90_abs_relative", e.p90_abs},
                    {"mean_relative", e.mean}});
  }
  return {{"fitted_rows", rows}, {"errors", list}};
}

void run(Arguments& arguments, const Common& common) {
  if (!arguments.hemisphere.empty() && !arguments.hemisphere.ends_with(".csv") &&
      !arguments.hemisphere.ends_with(".h5")) {
    throw Error({arguments.hemisphere}, "has neither the ending .h5 nor .csv",
                "name the kind of file by its ending");
  }
  require_product_output({arguments.input}, arguments.output);
  if (!arguments.predict.empty()) {
    require_product_output({arguments.input, arguments.output, arguments.predict},
                           arguments.predict_output);
  }
  if (!arguments.hemisphere.empty()) {
    require_product_output({arguments.input, arguments.output}, arguments.hemisphere);
  }
  invert::Options& options = arguments.options;
  options.fix = settings("--fix", arguments.fix);
  options.start = settings("--start", arguments.start);
  options.bound = limits(arguments.bound);
  for (const std::string& text : arguments.prior) {
    options.priors.push_back(invert::parse_prior(text));
  }
  options.objective =
      arguments.objective == "paper" ? invert::Objective::paper : invert::Objective::noise_weighted;
  options.held_out = !arguments.no_held_out;
  options.dhr_theta_i_deg = arguments.theta_i_deg;
  options.seed = common.seed;
  options.threads = common.threads;

  const formats::BrdfFile file = formats::read_brdf_h5(arguments.input);
  if (arguments.list_start) {
    list_start(arguments, file.table, common);
    return;
  }
  Progress progress("invert", common.quiet || common.json);
  options.progress = [&](double share, const std::string& stage) {
    progress.update(share, 1.0, stage);
  };
  std::vector<invert::RowCondition> conditions;
  for (const std::string& text : arguments.rows)
    conditions.push_back(invert::parse_row_condition(text));
  const formats::BrdfTable selected =
      conditions.empty() ? file.table : invert::select_rows(file.table, conditions);
  if (!arguments.compare.empty()) {
    compare_command({arguments.input, arguments.output, arguments.compare, arguments.rows},
                    file.table, conditions.empty() ? nullptr : &selected, options, common,
                    progress);
    return;
  }
  formats::FitResult fit = invert::invert(selected, options);
  progress.finish();
  fit.data_file = arguments.input;
  fit.data_sha256 = formats::sha256_of_file(arguments.input);
  fit.program = std::string("umov ") + UMOV_VERSION;
  fit.command = common.command_line;

  std::string text = formats::fit_to_json(fit);
  std::vector<invert::PredictionError> errors;
  if (!conditions.empty()) {
    errors = invert::prediction_errors(fit, file.table, selected);
    auto json = nlohmann::ordered_json::parse(text);
    json["prediction"] = prediction_json(arguments.rows, errors);
    text = json.dump(1) + "\n";
  }
  if (arguments.residuals) {
    auto json = nlohmann::ordered_json::parse(text);
    const invert::Prediction prediction = invert::predict(fit, file.table);
    auto& rows = json["points_predicted"] = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < prediction.residual.size(); ++i) {
      rows.push_back({{"model_per_sr", prediction.brdf_per_sr[i]},
                      {"calibrated_per_sr", prediction.calibrated_per_sr[i]},
                      {"residual", prediction.residual[i]}});
    }
    text = json.dump(1) + "\n";
  }
  formats::replace_file(arguments.output, text);
  if (!arguments.hemisphere.empty()) write_hemispheres(arguments, fit, file.table);
  if (!arguments.predict.empty()) write_prediction(arguments, fit, file.table, common.threads);
  if (common.json) {
    fmt::print("{}", text);
  } else if (!common.quiet) {
    print_fit(fit, arguments.output);
    print_prediction(errors);
  }
}

}  // namespace

void add_invert_command(CLI::App& root, const Common& common) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command =
      root.add_subcommand("invert", "Fit a reflectance model to a reduced measurement");
  command->add_option("input", a->input, "brdf.h5")->required();
  command
      ->add_option("-m,--model", a->options.model,
                   "model, or sum such as microfacet+nef (umov model list)")
      ->capture_default_str();
  command->add_option("-o,--output", a->output, "fit.json to write")->capture_default_str();
  const auto repeat = [&](const char* flags, std::vector<std::string>& target, const char* text) {
    command->add_option(flags, target, text)->allow_extra_args(false);
  };
  repeat("--share", a->options.share, "one value of NAME for all wavelengths; repeatable");
  repeat("--spectral", a->options.spectral, "one value of NAME for each wavelength; repeatable");
  repeat("--free", a->options.free, "fit NAME although the model holds it; repeatable");
  repeat("--fix", a->fix, "hold NAME=VALUE, or NAME@NM=VALUE at one wavelength; repeatable");
  repeat("--bound", a->bound, "limits NAME=LO:HI, or NAME@NM=LO:HI; repeatable");
  repeat("--start", a->start, "start at NAME=VALUE, or NAME@NM=VALUE; repeatable");
  repeat(
      "--rows", a->rows,
      "fit only these points and tell how well the rest is foretold: in-plane, theta_i_deg=30,45, "
      "theta_r_deg=-60:60, wavelength_nm!=532; repeatable");
  repeat(
      "--prior", a->prior,
      "knowledge from elsewhere: NAME=VALUE±U (or +-), NAME@NM=VALUE±U, or kappa-order[@NM][=3]: "
      "extinction at NM (default: the shortest wavelength) at least so many times that at the "
      "others; repeatable");
  command
      ->add_option(
          "--compare", a->compare,
          "fit these models (MODEL,MODEL+MODEL,… or all; interpolation is one) to the same "
          "rows, rank them by the rows held out (those that --rows leaves, else every "
          "fifth), and write the winner to the output; FILE.compare.json holds the table")
      ->type_name("MODELS");
  command->add_option(
      "--predict", a->predict,
      "also predict BRDF and DOLP with intervals: in-plane, out-of-plane, or a .csv of "
      "[wavelength_nm,]theta_i_deg,theta_r_deg,phi_r_deg");
  command->add_option("--predict-output", a->predict_output, "where --predict writes")
      ->capture_default_str();
  command
      ->add_option("--objective", a->objective,
                   "noise: weighted by the uncertainties; paper: relative deviations by BFGS")
      ->check(CLI::IsMember({"noise", "paper"}))
      ->capture_default_str();
  command
      ->add_option("--robust", a->options.robust_sigma,
                   "sigma beyond which a residual counts linearly, 0: never")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      ->add_option("--floor", a->options.floor_relative,
                   "relative model discrepancy added to the noise, such as 0.02")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--starts", a->options.starts, "starting points")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_option("--iterations", a->options.max_iterations, "most iterations of a fit")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_flag("--no-held-out", a->no_held_out, "skip the second fit without every fifth row");
  command
      ->add_option("--theta-i", a->theta_i_deg,
                   "incidences for reflectance and hemisphere, degrees (default: the data's and 0)")
      ->delimiter(',')
      ->check(CLI::Range(0.0, 89.0));
  command->add_option("--hemisphere", a->hemisphere,
                      "also write the BRDF over the hemisphere to this .h5 or .csv");
  command
      ->add_option("--theta-step", a->theta_step_deg, "step of the hemisphere in theta_r, degrees")
      ->check(CLI::Range(0.05, 45.0))
      ->capture_default_str();
  command->add_option("--phi-step", a->phi_step_deg, "step of the hemisphere in phi_r, degrees")
      ->check(CLI::Range(0.05, 180.0))
      ->capture_default_str();
  command->add_flag("--list-start", a->list_start, "print the starting values and stop");
  command->add_flag("--residuals", a->residuals,
                    "add prediction and residual of each point to the file");
  command->callback([a, &common] { run(*a, common); });
}

}  // namespace umov::cli
