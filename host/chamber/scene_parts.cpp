#include "host/chamber/scene_parts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>

#include "host/brdf/model.hpp"
#include "host/errors/error.hpp"
#include "host/formats/table_file.hpp"

namespace umov::chamber {

std::filesystem::path SceneMaterials::path_of(const std::string& name) const {
  const std::filesystem::path beside = file_.parent_path() / name;
  return std::filesystem::exists(beside) ? beside : std::filesystem::path(name);
}

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
  // `kind` is what a surface is made of, or makes that.
  const auto made = [&](auto&& kind) {
    try {
      if constexpr (std::is_invocable_v<decltype(kind)>) {
        return std::make_shared<const Surface>(name, kind());
      } else {
        return std::make_shared<const Surface>(name, std::forward<decltype(kind)>(kind));
      }
    } catch (const Error& error) {
      throw Error(Place{file_.string(), line}, name + " " + error.problem(), error.remedy());
    }
  };
  const double nm = table.number("wavelength_nm", 100.0, 1e5, 555.0);
  if (table.has("file")) {
    if (table.has("model")) table.text("model", {"tabulated"});
    const std::filesystem::path path = path_of(table.text("file"));
    std::optional<double> total;
    if (table.has("total")) total = table.number("total", 1e-6, 1.0);
    table.refuse_unknown();
    const formats::TablePtr data = formats::read_table(path);
    if (const auto* planes = dynamic_cast<const brdf::PlanesTable*>(data.get())) {
      std::size_t nearest = 0;
      const auto& known = planes->wavelengths_um();
      for (std::size_t i = 1; i < known.size(); ++i) {
        if (std::abs(known[i] - 1e-3 * nm) < std::abs(known[nearest] - 1e-3 * nm)) nearest = i;
      }
      return made([&] { return PlanesSurface(*planes, nearest, total); });
    }
    if (total) {
      table.fail("total", "goes with a table of two planes", "leave it out: others are whole");
    }
    const brdf::Model model = brdf::Model::by_name("tabulated").with_table(data);
    return made(Modelled{brdf::Sampler(model, {}, 1e-3 * nm)});
  }
  const std::string kind = table.text("model");
  if (kind == "lambertian") {
    // Beyond 1 it is the surface that refuses, with its own words.
    const double rho = table.number("rho", -1e9, 1e9);
    table.refuse_unknown();
    return made(Lambertian{rho});
  }
  if (kind == "diffuse+specular") {
    DiffuseSpecular two{table.number("total", -1e9, 1e9), table.numbers("theta_i_deg", 0.0, 90.0),
                        table.numbers("specular", 0.0, 1e9)};
    table.refuse_unknown();
    return made(std::move(two));
  }
  const brdf::Model model = brdf::Model::by_name(kind);
  std::vector<double> values;
  for (const brdf::Parameter& p : model.parameters()) {
    values.push_back(table.number(p.name, p.min, p.max, p.initial));
  }
  table.refuse_unknown();
  return made(Modelled{brdf::Sampler(model, std::move(values), 1e-3 * nm)});
}

}  // namespace umov::chamber
