#include "host/chamber/scene_parts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "host/brdf/model.hpp"
#include "host/errors/error.hpp"
#include "host/formats/table_file.hpp"

namespace umov::chamber {
namespace {

/// kind(value) of each value; one alone where all are the same.
template <class Kind>
std::vector<Surface::Kind> by_band(std::vector<double> values, const Kind& kind) {
  const auto differs = [&](double value) { return value != values.front(); };
  if (std::none_of(values.begin(), values.end(), differs)) values.resize(1);
  std::vector<Surface::Kind> bands;
  for (const double value : values) bands.emplace_back(kind(value));
  return bands;
}

std::vector<Surface::Kind> planes_by_band(const brdf::PlanesTable& table,
                                          const std::vector<double>& wavelengths_um,
                                          const std::optional<std::vector<double>>& total) {
  if (table.wavelengths_um().size() == 1 && total) {
    return by_band(*total, [&](double t) { return PlanesSurface(table, 0, t); });
  }
  std::vector<Surface::Kind> bands;
  for (std::size_t b = 0; b < wavelengths_um.size(); ++b) {
    const auto due = total ? std::optional<double>((*total)[b]) : std::nullopt;
    bands.emplace_back(PlanesSurface::at_wavelength(table, wavelengths_um[b], due));
    if (table.wavelengths_um().size() == 1) break;  // the same in all
  }
  return bands;
}

}  // namespace

void SceneMaterials::read_named(SceneTable& root) {
  if (!root.has("surfaces")) return;
  SceneTable all = root.table("surfaces");
  for (const auto& [key, value] : all.toml()) {
    const std::string name(key.str());
    named_[name] = from_table(all.table(name), name);
  }
}

std::shared_ptr<const Surface> SceneMaterials::surface(SceneTable& table, std::string_view key) {
  const toml::node* node = table.toml().get(key);
  if (node != nullptr && node->is_table()) return from_table(table.table(key), std::string(key));
  const std::string name = table.text(key);
  if (name == "black") return black_;
  const auto found = named_.find(name);
  if (found != named_.end()) return found->second;
  std::vector<std::string> names{"black"};
  for (const auto& [known, unused] : named_) names.push_back(known);
  table.fail(key, "is '" + name + "'",
             fmt::format("add [surfaces.{}]; there are: {}", name, fmt::join(names, ", ")));
}

std::shared_ptr<const Surface> SceneMaterials::from_table(SceneTable table,
                                                          const std::string& name) const {
  const auto line = table.toml().source().begin.line;
  // `kind()` is what the surface is made of.
  const auto made = [&](const auto& kind) {
    try {
      return std::make_shared<const Surface>(name, kind());
    } catch (const Error& error) {
      throw Error(Place{file_.string(), line}, name + " " + error.problem(), error.remedy());
    }
  };
  const std::vector<double> um =
      wavelengths_um_.empty()
          ? std::vector<double>{1e-3 * table.number("wavelength_nm", 100.0, 1e5, 555.0)}
          : wavelengths_um_;
  if (table.has("file")) {
    if (table.has("model")) table.text("model", {"tabulated"});
    const std::filesystem::path path = table.file("file");
    std::optional<std::vector<double>> total;
    if (table.has("total")) total = table.spectrum("total", um, 1e-6, 1.0);
    table.refuse_unknown();
    const formats::TablePtr data = formats::read_table(path);
    if (const auto* planes = dynamic_cast<const brdf::PlanesTable*>(data.get())) {
      return made([&] { return planes_by_band(*planes, um, total); });
    }
    if (total) {
      table.fail("total", "goes with a table of two planes", "leave it out: others are whole");
    }
    std::vector<brdf::SpectralValues> values;
    for (const double w : um) values.push_back({{}, w});
    const brdf::Model model = brdf::Model::by_name("tabulated").with_table(data);
    return made([&] { return Modelled{brdf::Sampler(model, values)}; });
  }
  const std::string kind = table.text("model");
  // A reflectance beyond 1 is refused by the surface, with its own words.
  if (kind == "lambertian") {
    const std::vector<double> rho = table.spectrum("rho", um, -1e9, 1e9);
    table.refuse_unknown();
    return made([&] { return by_band(rho, [](double r) { return Lambertian{r}; }); });
  }
  if (kind == "diffuse+specular") {
    const std::vector<double> total = table.spectrum("total", um, -1e9, 1e9);
    const std::vector<double> theta = table.numbers("theta_i_deg", 0.0, 90.0);
    const std::vector<double> specular = table.numbers("specular", 0.0, 1e9);
    table.refuse_unknown();
    return made([&] {
      return by_band(total, [&](double t) { return DiffuseSpecular(t, theta, specular); });
    });
  }
  const brdf::Model model = brdf::Model::by_name(kind);
  std::vector<brdf::SpectralValues> values;
  for (const double w : um) values.push_back({{}, w});
  for (const brdf::Parameter& p : model.parameters()) {
    table.know(p.name);
    const std::vector<double> spectrum = table.has(p.name)
                                             ? table.spectrum(p.name, um, p.min, p.max)
                                             : std::vector<double>(um.size(), p.initial);
    for (std::size_t b = 0; b < um.size(); ++b) values[b].values.push_back(spectrum[b]);
  }
  table.refuse_unknown();
  return made([&] { return Modelled{brdf::Sampler(model, values)}; });
}

}  // namespace umov::chamber
