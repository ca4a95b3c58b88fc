// umov model list | show | eval | dhr: the model library from the command line.
#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"
#include "host/brdf/model.hpp"
#include "host/cli/command.hpp"
#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::cli {
namespace {

using nlohmann::ordered_json;

struct Options {
  std::string name;
  std::vector<std::string> settings;
  double wavelength_nm = 632.8;
  double theta_i_deg = 0.0;
  double theta_r_deg = 0.0;
  double phi_r_deg = 0.0;
};

struct Prepared {
  brdf::Model model;
  std::vector<double> values;
};

double number(const std::string& setting, const std::string& text) {
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    throw Error("'" + text + "' in --set " + setting + " is not a number",
                "write for example --set n=1.5");
  }
  return value;
}

/// Choices are made first, since they decide which parameters there are.
Prepared prepare(const Options& options) {
  brdf::Model model = brdf::Model::by_name(options.name);
  std::vector<std::pair<std::string, std::string>> numbers;
  for (const std::string& setting : options.settings) {
    const auto equals = setting.find('=');
    if (equals == std::string::npos) {
      throw Error("--set " + setting + " has no value", "write --set NAME=VALUE");
    }
    const std::string name = setting.substr(0, equals);
    const std::string value = setting.substr(equals + 1);
    if (model.has_choice(name)) {
      model = model.with_choice(name, value);
    } else {
      numbers.emplace_back(name, value);
    }
  }
  std::vector<double> values = model.initial_values();
  for (const auto& [name, value] : numbers) {
    values[model.index_of(name)] = number(name + "=" + value, value);
  }
  model.check(values);
  return {std::move(model), std::move(values)};
}

double checked_wavelength_um(const Options& options) {
  if (options.wavelength_nm >= 100.0 && options.wavelength_nm <= 1e5)
    return options.wavelength_nm * 1e-3;
  throw Error("a wavelength of " + std::to_string(options.wavelength_nm) + " nm is out of range",
              "give --wavelength-nm from 100 to 100000");
}

double checked_incidence(const Options& options) {
  if (options.theta_i_deg >= 0.0 && options.theta_i_deg < 90.0)
    return optics::radians(options.theta_i_deg);
  throw Error("an incidence of " + std::to_string(options.theta_i_deg) + " degrees is out of range",
              "give --theta-i from 0 up to, not including, 90");
}

ordered_json description(const brdf::Model& model) {
  ordered_json parameters = ordered_json::array();
  for (const brdf::Parameter& p : model.parameters()) {
    parameters.push_back({{"name", p.name},
                          {"unit", p.unit},
                          {"min", p.min},
                          {"max", p.max},
                          {"default", p.initial},
                          {"meaning", p.meaning},
                          {"source", p.source},
                          {"spectral", p.spectral}});
  }
  ordered_json choices = ordered_json::array();
  for (const brdf::Choice& c : model.choices()) {
    choices.push_back(
        {{"name", c.name}, {"values", c.values}, {"value", c.value}, {"meaning", c.meaning}});
  }
  return {{"name", model.name()}, {"parameters", parameters}, {"choices", choices}};
}

void list(const Common& common) {
  ordered_json all = ordered_json::array();
  for (const std::string& name : brdf::Model::names()) {
    const brdf::Model model = brdf::Model::by_name(name);
    ordered_json entry = description(model);
    entry["description"] = brdf::Model::description(name);
    all.push_back(entry);
    if (common.json) continue;
    std::cout << name << ": " << brdf::Model::description(name) << "\n   ";
    for (const brdf::Parameter& p : model.parameters()) std::cout << " " << p.name;
    for (const brdf::Choice& c : model.choices()) std::cout << " [" << c.name << "]";
    std::cout << "\n";
  }
  if (common.json) {
    std::cout << ordered_json{{"models", all}}.dump() << "\n";
  } else {
    std::cout << "Sums: microfacet+lambertian, with parameters 0.n, 1.rho and so on.\n";
  }
}

void show(const Options& options, const Common& common) {
  const Prepared p = prepare(options);
  if (common.json) {
    ordered_json out = description(p.model);
    for (std::size_t i = 0; i < p.values.size(); ++i) out["parameters"][i]["value"] = p.values[i];
    std::cout << out.dump() << "\n";
    return;
  }
  std::cout << p.model.name() << "\n";
  for (std::size_t i = 0; i < p.values.size(); ++i) {
    const brdf::Parameter& q = p.model.parameters()[i];
    std::cout << "  " << q.name << " = " << p.values[i] << (q.unit == "1" ? "" : " " + q.unit)
              << "  (" << q.min << " to " << q.max << ", default " << q.initial
              << (q.spectral ? ", one per wavelength" : "") << ")  " << q.meaning << " ["
              << q.source << "]\n";
  }
  for (const brdf::Choice& c : p.model.choices()) {
    std::cout << "  " << c.name << " = " << c.value << "  (";
    for (std::size_t i = 0; i < c.values.size(); ++i)
      std::cout << (i == 0 ? "" : " | ") << c.values[i];
    std::cout << ")  " << c.meaning << "\n";
  }
}

/// Row by row, with -0 written as 0.
std::vector<double> rows_of(const optics::Mueller<double>& m) {
  std::vector<double> rows;
  for (int i = 0; i < 16; ++i) rows.push_back(optics::element(m, i / 4, i % 4) + 0.0);
  return rows;
}

void print_matrix(const std::vector<double>& rows) {
  std::cout.precision(10);
  for (std::size_t i = 0; i < 16; ++i) std::cout << rows[i] << (i % 4 == 3 ? "\n" : "  ");
}

void eval(const Options& options, const Common& common) {
  const Prepared p = prepare(options);
  const double wavelength_um = checked_wavelength_um(options);
  const double theta_i = checked_incidence(options);
  if (!(std::abs(options.theta_r_deg) < 90.0) || !std::isfinite(options.phi_r_deg)) {
    throw Error("the exit direction lies outside the hemisphere",
                "give --theta-r between -90 and 90 (negative: retro side) and a finite --phi-r");
  }
  const brdf::Geometry<double> geometry{theta_i, optics::radians(options.theta_r_deg),
                                        optics::radians(options.phi_r_deg)};
  const auto m = rows_of(brdf::evaluate<double>(p.model, p.values, wavelength_um, geometry));
  const auto mirror =
      rows_of(brdf::mirror_reflectance<double>(p.model, p.values, wavelength_um, theta_i));
  if (common.json) {
    ordered_json out{{"mueller", m}, {"brdf", m[0]}};
    if (mirror[0] > 0.0) out["mirror_mueller"] = mirror;
    std::cout << out.dump() << "\n";
    return;
  }
  std::cout << "Mueller BRDF, 1/sr (row: outgoing, column: incoming I Q U V)\n";
  print_matrix(m);
  if (mirror[0] > 0.0) {
    std::cout << "Mirror part in the direction theta_r = theta_i, reflectance\n";
    print_matrix(mirror);
  }
}

void dhr(const Options& options, const Common& common) {
  const Prepared p = prepare(options);
  const double wavelength_um = checked_wavelength_um(options);
  const double theta_i = checked_incidence(options);
  const brdf::Dhr diffuse = brdf::dhr(p.model, p.values, wavelength_um, theta_i);
  const brdf::Dhr mirror = brdf::mirror_dhr(p.model, p.values, wavelength_um, theta_i);
  if (common.json) {
    ordered_json out{{"dhr", diffuse.unpolarized}, {"dhr_s", diffuse.s}, {"dhr_p", diffuse.p}};
    if (mirror.unpolarized > 0.0) {
      out["mirror"] = mirror.unpolarized;
      out["mirror_s"] = mirror.s;
      out["mirror_p"] = mirror.p;
    }
    out["total"] = diffuse.unpolarized + mirror.unpolarized;
    std::cout << out.dump() << "\n";
    return;
  }
  std::cout.precision(8);
  std::cout << "DHR " << diffuse.unpolarized << "  (s " << diffuse.s << ", p " << diffuse.p
            << ")\n";
  if (mirror.unpolarized > 0.0) {
    std::cout << "and in the mirror direction " << mirror.unpolarized << "  (s " << mirror.s
              << ", p " << mirror.p << ")\n";
  }
}

void add_model_options(CLI::App& command, Options& options) {
  command.add_option("name", options.name, "model, or sum such as microfacet+nef")->required();
  command
      .add_option("--set", options.settings,
                  "parameter or choice, NAME=VALUE; repeatable (umov model show NAME lists them)")
      ->allow_extra_args(false);
}

void add_beam_options(CLI::App& command, Options& options) {
  command.add_option("--wavelength-nm", options.wavelength_nm, "vacuum wavelength, nm")
      ->capture_default_str();
  command.add_option("--theta-i", options.theta_i_deg, "incidence, degrees")->capture_default_str();
}

}  // namespace

void add_model_command(CLI::App& root, const Common& common) {
  CLI::App* model = root.add_subcommand("model", "the library of reflectance models");
  model->require_subcommand(1);
  model->fallthrough();
  const auto options = std::make_shared<Options>();

  CLI::App* list_command = model->add_subcommand("list", "all models and their parameters");
  list_command->callback([&common] { list(common); });

  CLI::App* show_command =
      model->add_subcommand("show", "a model's parameters, units, ranges and choices");
  add_model_options(*show_command, *options);
  show_command->callback([options, &common] { show(*options, common); });

  CLI::App* eval_command = model->add_subcommand("eval", "the Mueller BRDF in one geometry");
  add_model_options(*eval_command, *options);
  add_beam_options(*eval_command, *options);
  eval_command
      ->add_option("--theta-r", options->theta_r_deg,
                   "exit polar angle, degrees; negative: retro side")
      ->capture_default_str();
  eval_command
      ->add_option("--phi-r", options->phi_r_deg, "exit azimuth, degrees; 0: forward half plane")
      ->capture_default_str();
  eval_command->callback([options, &common] { eval(*options, common); });

  CLI::App* dhr_command = model->add_subcommand("dhr", "the directional-hemispherical reflectance");
  add_model_options(*dhr_command, *options);
  add_beam_options(*dhr_command, *options);
  dhr_command->callback([options, &common] { dhr(*options, common); });

  for (CLI::App* command : {list_command, show_command, eval_command, dhr_command})
    command->fallthrough();
}

}  // namespace umov::cli
