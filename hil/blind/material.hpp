// Materials of the cases, drawn at random and written as sample files of the plant.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hil/blind/random.hpp"
#include "hil/plant/sample.hpp"

namespace umov::blind {

struct Material {
  std::string family;              ///< "gaussian_facets", "ggx", "two_roughnesses", …
  bool one_gaussian_lobe = false;  ///< one lobe of Gaussian facets over ρ_d1 + ρ_d2/(cos cos)
  std::string kind;                ///< of the sample file
  std::vector<std::pair<std::string, std::string>> texts;
  /// One value, or one a laser.
  std::vector<std::pair<std::string, std::vector<double>>> numbers;

  std::string toml() const;
  std::shared_ptr<const plant::Sample> sample() const;
  double slope_rms() const { return sample()->slope_rms(); }
};

/// Six of ten are one Gaussian lobe; the others belong to a family drawn evenly.
Material draw_material(Random& random);
/// Of one family. Throws umov::Error for an unknown one.
Material draw_material(Random& random, const std::string& family);
std::vector<std::string> material_families();

/// The material with one value (of parameter i, entry j) changed by its derivative's step; the step
/// is returned.
struct Perturbed {
  Material material;
  double step;
};
std::vector<Perturbed> perturbed(const Material& material);

}  // namespace umov::blind
