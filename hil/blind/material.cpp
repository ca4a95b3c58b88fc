#include "hil/blind/material.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>

#include "hil/plant/plant_config.hpp"
#include "hil/plant/sample_catalog.hpp"
#include "host/errors/error.hpp"

namespace umov::blind {
namespace {

using Values = std::vector<double>;

std::string number_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.10g", value);
  return buffer;
}

/// A spectrum with one value a laser, all within a factor of `spread` of a common level.
Values spectrum(Random& random, double low, double high, double spread) {
  const double level = random.log_between(low, high);
  Values values;
  for (int i = 0; i < plant::laser_count; ++i) {
    values.push_back(std::clamp(level * random.log_between(1.0 / spread, spread), low, high));
  }
  return values;
}

/// Diffuse part of facet materials: from black to light grey, with some of it rising to grazing.
void add_diffuse(Material& m, Random& random) {
  const Values level = spectrum(random, 0.004, 0.22, 3.0);
  const double share = random.chance(0.5) ? random.between(0.01, 0.08) : 0.0;
  Values grazing;
  for (const double v : level) grazing.push_back(share * v);
  m.numbers.emplace_back("rho_d1", level);
  if (share > 0.0) m.numbers.emplace_back("rho_d2", grazing);
}

Material facets(Random& random, const std::string& family) {
  Material m;
  m.family = family;
  m.kind = "facets";
  m.numbers = {{"n", {random.between(1.42, 1.62)}}, {"slope", {random.log_between(0.07, 0.33)}}};
  return m;
}

Material gaussian_facets(Random& random) {
  Material m = facets(random, "gaussian_facets");
  m.one_gaussian_lobe = true;
  add_diffuse(m, random);
  return m;
}

Material ggx(Random& random) {
  Material m = facets(random, "ggx");
  m.texts.emplace_back("distribution", "ggx");
  add_diffuse(m, random);
  return m;
}

Material two_roughnesses(Random& random) {
  Material m = facets(random, "two_roughnesses");
  const double share = random.between(0.15, 0.6);
  const double slope = m.numbers[1].second[0];
  m.numbers.push_back({"weight", {1.0 - share}});
  m.numbers.push_back({"weight_2", {share}});
  m.numbers.push_back({"slope_2", {std::min(0.6, slope * random.between(1.6, 3.5))}});
  add_diffuse(m, random);
  return m;
}

Material anisotropic(Random& random) {
  Material m = facets(random, "anisotropic");
  const double slope = m.numbers[1].second[0];
  m.numbers.push_back({"slope_y", {slope * random.log_between(0.35, 3.0)}});
  add_diffuse(m, random);
  return m;
}

Material humped(Random& random) {
  Material m = facets(random, "humped");
  const double share = random.between(0.1, 0.4);
  m.texts.emplace_back("distribution_2", "ring");
  m.numbers.push_back({"weight", {1.0 - share}});
  m.numbers.push_back({"weight_2", {share}});
  m.numbers.push_back({"slope_2", {random.between(0.03, 0.08)}});
  m.numbers.push_back({"steepness_2", {random.between(0.18, 0.45)}});
  add_diffuse(m, random);
  return m;
}

Material forward_lobe(Random& random) {
  Material m = facets(random, "forward_lobe");
  const double width_deg = random.between(12.0, 35.0);
  m.numbers.push_back({"forward_per_sr", spectrum(random, 0.004, 0.1, 1.6)});
  m.numbers.push_back({"forward_width_deg", {width_deg}});
  add_diffuse(m, random);
  return m;
}

Material he_torrance(Random& random) {
  Material m;
  m.family = "he_torrance";
  m.kind = "paint";
  const double sigma = random.log_between(0.8, 3.0);
  const double slope_2d = random.log_between(0.06, 0.4);
  m.numbers = {{"n", {random.between(1.45, 1.58)}},
               {"sigma_um", {sigma}},
               {"tau_um", {2.0 * sigma / slope_2d}},
               {"k_udf", spectrum(random, 0.0005, 0.02, 2.0)},
               {"k_uds", spectrum(random, 0.005, 0.5, 4.0)}};
  return m;
}

Material volume_diffuser(Random& random) {
  Material m;
  m.family = "volume_diffuser";
  m.kind = "diffuser";
  m.numbers = {
      {"dhr", spectrum(random, 0.15, 0.6, 1.3)},  {"roll_off", {random.between(0.15, 0.6)}},
      {"kept", {random.between(0.03, 0.2)}},      {"surface", {random.between(0.3, 1.0)}},
      {"surface_n", {random.between(1.4, 1.58)}}, {"surface_slope", {random.between(0.08, 0.35)}}};
  return m;
}

using Draw = Material (*)(Random&);
struct Family {
  const char* name;
  Draw draw;
};
constexpr Family families[] = {
    {"gaussian_facets", gaussian_facets}, {"he_torrance", he_torrance},        {"ggx", ggx},
    {"two_roughnesses", two_roughnesses}, {"anisotropic", anisotropic},        {"humped", humped},
    {"forward_lobe", forward_lobe},       {"volume_diffuser", volume_diffuser}};

}  // namespace

std::string Material::toml() const {
  std::string text = "name = \"coupon\"\ntitle = \"coupon\"\nkind = \"" + kind +
                     "\"\nwavelengths_nm = [532, 633, 814]\n";
  for (const auto& [key, value] : texts) text += key + " = \"" + value + "\"\n";
  for (const auto& [key, values] : numbers) {
    text += key + " = ";
    if (values.size() == 1) {
      text += number_text(values[0]) + "\n";
      continue;
    }
    text += "[";
    for (std::size_t i = 0; i < values.size(); ++i)
      text += (i == 0 ? "" : ", ") + number_text(values[i]);
    text += "]\n";
  }
  return text;
}

std::shared_ptr<const plant::Sample> Material::sample() const {
  return plant::sample_from_toml(toml(), "coupon.toml");
}

Material draw_material(Random& random) {
  if (random.chance(0.6)) return gaussian_facets(random);
  const auto others = std::size(families) - 1;
  return families[1 + random.below(others)].draw(random);
}

Material draw_material(Random& random, const std::string& family) {
  std::string names;
  for (const Family& f : families) {
    if (family == f.name) return f.draw(random);
    names += (names.empty() ? "" : ", ") + std::string(f.name);
  }
  throw Error("no family of materials is called \"" + family + "\"", "there are " + names);
}

std::vector<std::string> material_families() {
  std::vector<std::string> names;
  for (const Family& f : families) names.emplace_back(f.name);
  return names;
}

std::vector<Perturbed> perturbed(const Material& material) {
  std::vector<Perturbed> all;
  for (std::size_t i = 0; i < material.numbers.size(); ++i) {
    for (std::size_t j = 0; j < material.numbers[i].second.size(); ++j) {
      // Derivatives of smooth functions: a thousandth of the value, downwards, where no limit is.
      const double step = -1e-3 * std::max(1e-3, material.numbers[i].second[j]);
      Perturbed p{material, step};
      p.material.numbers[i].second[j] += step;
      all.push_back(std::move(p));
    }
  }
  return all;
}

}  // namespace umov::blind
