#include "host/surface/scene_materials.hpp"

#include <fmt/format.h>

#include <utility>

#include "host/brdf/model.hpp"
#include "host/errors/error.hpp"
#include "host/optics/refractive_index.hpp"
#include "host/toml/spectrum.hpp"

namespace umov::surface {
namespace {

brdf::Model model_of(SceneTable& table) {
  const std::string name = table.text("model");
  try {
    const brdf::Model model = brdf::Model::by_name(name);
    if (model.needs_table()) table.fail("model", "needs a table of values", "use a formula here");
    return model;
  } catch (const Error& e) {
    if (!e.place().file.empty()) throw;
    table.fail("model", "is '" + name + "': " + e.problem(), e.remedy() + "; or fresnel");
  }
}

}  // namespace

trace::Medium read_index(SceneTable& table, const std::vector<double>& wavelengths_um,
                         const std::string& preset) {
  trace::Medium medium;
  if (table.has("n")) {
    medium.n = table.spectrum("n", wavelengths_um, 1e-3, 1e3);
    medium.kappa = table.has("kappa") ? table.spectrum("kappa", wavelengths_um, 0.0, 1e9)
                                      : std::vector<double>(wavelengths_um.size(), 0.0);
    return medium;
  }
  const std::string name = table.has("index") || preset.empty() ? table.text("index") : preset;
  try {
    const auto index = optics::IndexTable::embedded(name);
    for (const double w : wavelengths_um) {
      medium.n.push_back(index.n(w));
      medium.kappa.push_back(index.kappa(w));
    }
  } catch (const Error& e) {
    table.fail("index", "is '" + name + "': " + e.problem(), e.remedy());
  }
  return medium;
}

trace::Medium read_liquid(SceneTable& table, const std::vector<double>& wavelengths_um) {
  trace::Medium medium = read_index(table, wavelengths_um, "H2O_Hale");
  for (const double n : medium.n) {
    if (n < 1.0) {
      table.fail(table.has("n") ? "n" : "index", fmt::format("gives n = {}", n),
                 "a liquid has an index of at least 1");
    }
  }
  return medium;
}

trace::Material read_material(SceneTable& table, const std::vector<double>& wavelengths_um,
                              const trace::Material* prepared) {
  const std::size_t count = wavelengths_um.size();
  if (table.text("model") == "fresnel") {
    const trace::Medium body = read_index(table, wavelengths_um);
    return trace::Conductor{body.n, body.kappa};
  }
  const brdf::Model model = model_of(table);
  if (model.name() == "lambertian") {
    return trace::Lambertian{table.spectrum("rho", wavelengths_um, 0.0, 1.0)};
  }
  std::vector<std::vector<double>> spectra;
  for (const brdf::Parameter& p : model.parameters()) {
    spectra.push_back(table.has(p.name) ? table.spectrum(p.name, wavelengths_um, p.min, p.max)
                                        : std::vector<double>(count, p.initial));
    table.know(p.name);
  }
  if (prepared != nullptr && std::holds_alternative<trace::Modelled>(*prepared)) return *prepared;
  std::vector<brdf::SpectralValues> values;
  for (std::size_t w = 0; w < count; ++w) {
    values.push_back({{}, wavelengths_um[w]});
    for (const auto& spectrum : spectra) values.back().values.push_back(spectrum[w]);
  }
  return trace::Modelled{brdf::Sampler(model, std::move(values))};
}

std::vector<std::string> known_soils() {
  return {"dry_soil", "wet_soil"};
}

trace::Material soil(const std::string& name, const std::vector<double>& wavelengths_um) {
  const Spectrum known = parse_spectrum(embedded_soils, "soil_reflectance.csv", name);
  trace::Lambertian material;
  for (const double w : wavelengths_um) material.albedo.push_back(known.at(w, name));
  return material;
}

}  // namespace umov::surface
