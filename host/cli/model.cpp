// umov model list | show | eval | dhr | check: the model library from the command line.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"
#include "host/brdf/model.hpp"
#include "host/cli/command.hpp"
#include "host/cli/model_check.hpp"
#include "host/cli/model_values.hpp"
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

ModelValues prepare(const Options& options) {
  return model_values(options.name, options.settings);
}

constexpr const char* table_meaning = "file of BRDF values; its kind is told by its content";

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
  ordered_json out{{"name", model.name()}, {"parameters", parameters}, {"choices", choices}};
  if (!model.table_slots().empty()) {
    ordered_json tables = ordered_json::array();
    for (const brdf::TableSlot& slot : model.table_slots()) {
      ordered_json entry{{"name", slot.name}, {"meaning", table_meaning}};
      if (slot.filled) entry["table"] = model.components()[slot.part].table->description();
      tables.push_back(entry);
    }
    out["tables"] = tables;
  }
  return out;
}

/// Names of a model's parts without their choices, each once.
std::vector<std::string> part_names(const brdf::Model& model) {
  std::vector<std::string> names;
  std::istringstream parts(model.name());
  for (std::string part; std::getline(parts, part, '+');) {
    part = part.substr(0, part.find(':'));
    if (std::find(names.begin(), names.end(), part) == names.end()) names.push_back(part);
  }
  return names;
}

void list(const Common& common) {
  ordered_json all = ordered_json::array();
  for (const std::string& name : brdf::Model::names()) {
    const brdf::Model model = brdf::Model::by_name(name);
    ordered_json entry = description(model);
    entry["description"] = brdf::Model::description(name);
    entry["formula"] = brdf::Model::formula(name);
    entry["remarks"] = brdf::Model::remarks(name);
    all.push_back(entry);
    if (common.json) continue;
    std::cout << name << ": " << brdf::Model::description(name) << "\n   ";
    for (const brdf::Parameter& p : model.parameters()) std::cout << " " << p.name;
    for (const brdf::TableSlot& slot : model.table_slots()) std::cout << " " << slot.name;
    for (const brdf::Choice& c : model.choices()) {
      std::cout << " [" << c.name << " =";
      for (const std::string& value : c.values) std::cout << " " << value;
      std::cout << "]";
    }
    std::cout << "\n";
  }
  ordered_json aliases = ordered_json::array();
  for (const brdf::Alias& alias : brdf::Model::aliases()) {
    aliases.push_back({{"name", alias.name}, {"model", alias.model}, {"meaning", alias.meaning}});
  }
  if (common.json) {
    std::cout << ordered_json{{"models", all}, {"aliases", aliases}}.dump() << "\n";
  } else {
    std::cout << "Known under other names:\n";
    for (const brdf::Alias& alias : brdf::Model::aliases()) {
      std::cout << "    " << alias.name << " = " << alias.model << ": " << alias.meaning << "\n";
    }
    std::cout << "Sums: microfacet+lambertian, with parameters 0.n, 1.rho and so on.\n";
  }
}

void show(const Options& options, const Common& common) {
  const ModelValues p = prepare(options);
  if (common.json) {
    ordered_json out = description(p.model);
    for (std::size_t i = 0; i < p.values.size(); ++i) out["parameters"][i]["value"] = p.values[i];
    out["parts"] = ordered_json::array();
    for (const std::string& part : part_names(p.model)) {
      out["parts"].push_back({{"name", part},
                              {"description", brdf::Model::description(part)},
                              {"formula", brdf::Model::formula(part)},
                              {"remarks", brdf::Model::remarks(part)}});
    }
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
  for (const brdf::TableSlot& slot : p.model.table_slots()) {
    std::cout << "  " << slot.name << "  " << table_meaning;
    if (slot.filled) std::cout << ": " << p.model.components()[slot.part].table->description();
    std::cout << "\n";
  }
  for (const std::string& part : part_names(p.model)) {
    std::cout << part << ": " << brdf::Model::description(part) << "\n"
              << "  formula: " << brdf::Model::formula(part) << "\n"
              << "  energy and reciprocity: " << brdf::Model::remarks(part) << "\n";
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
  const ModelValues p = prepare(options);
  const double wavelength_um = checked_wavelength_um(options.wavelength_nm);
  const double theta_i = checked_incidence(options.theta_i_deg);
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
  const ModelValues p = prepare(options);
  const double wavelength_um = checked_wavelength_um(options.wavelength_nm);
  const double theta_i = checked_incidence(options.theta_i_deg);
  const brdf::Dhr diffuse = brdf::dhr(p.model, p.values, wavelength_um, theta_i);
  const brdf::Dhr mirror = brdf::mirror_dhr(p.model, p.values, wavelength_um, theta_i);
  const bool tabulated = !p.model.table_slots().empty();
  if (common.json) {
    ordered_json out{{"dhr", diffuse.unpolarized}, {"dhr_s", diffuse.s}, {"dhr_p", diffuse.p}};
    if (mirror.unpolarized > 0.0) {
      out["mirror"] = mirror.unpolarized;
      out["mirror_s"] = mirror.s;
      out["mirror_p"] = mirror.p;
    }
    out["total"] = diffuse.unpolarized + mirror.unpolarized;
    out["accuracy"] = diffuse.accuracy;
    std::cout << out.dump() << "\n";
    return;
  }
  std::cout.precision(8);
  std::cout << "DHR " << diffuse.unpolarized << "  (s " << diffuse.s << ", p " << diffuse.p
            << ")\n";
  if (tabulated) std::cout << "integrated to " << diffuse.accuracy << "\n";
  if (mirror.unpolarized > 0.0) {
    std::cout << "and in the mirror direction " << mirror.unpolarized << "  (s " << mirror.s
              << ", p " << mirror.p << ")\n";
  }
}

void add_model_options(CLI::App& command, Options& options) {
  command.add_option("name", options.name, "model, or sum such as microfacet+nef")->required();
  command
      .add_option("--set", options.settings,
                  "parameter, choice or file, NAME=VALUE; repeatable (umov model show NAME lists "
                  "them)")
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

  CLI::App* show_command = model->add_subcommand(
      "show", "a model's formula, parameters, units, ranges, choices, limits");
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

  add_model_check(*model, common);
  for (CLI::App* command : {list_command, show_command, eval_command, dhr_command})
    command->fallthrough();
}

}  // namespace umov::cli
