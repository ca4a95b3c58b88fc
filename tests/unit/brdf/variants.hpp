// One instance of every model and choice, with values at which all its terms show.
#pragma once

#include <string>
#include <vector>

#include "host/brdf/model.hpp"

namespace umov::brdf {

struct Variant {
  const char* name;
  std::vector<double> values;
};

inline std::vector<Variant> all_variants() {
  return {
      {"lambertian", {0.4}},
      {"nef", {0.1, 0.03}},
      {"microfacet:shadowing=none", {1.5, 0.2, 0.2, 1.1}},
      {"microfacet:shadowing=vgroove", {1.5, 0.2, 0.2, 1.1}},
      {"microfacet", {0.958, 6.69, 0.3, 1.0}},
      {"microfacet:shadowing=smith-correlated", {1.5, 0.2, 0.3, 1.0}},
      {"microfacet:shadowing=maxwell-beard,slopes=exponential", {1.5, 0.2, 0.2, 1.0, 0.7, 0.25}},
      {"ggx", {5.39, 0.70, 0.3}},
      {"ggx:shadowing=smith-correlated", {1.5, 0.1, 0.2}},
      {"he-torrance", {1.5, 0.1, 0.18, 3.0}},
      {"he-torrance", {0.958, 6.69, 0.03, 2.0}},
      {"he-torrance", {1.6, 0.3, 5.0, 40.0}},
      {"li-torrance", {1.5, 0.05, 0.3, 3.0, 0.9, 0.02, 0.4, 0.1, 12.0, 0.6}},
      {"rayleigh-rice", {1.5, 0.2, 0.005, 0.8}},
      {"rayleigh-rice:psd=abc", {0.958, 6.69, 2e-3, 3.0, 2.5}},
      {"beard-maxwell", {1.5, 0.2, 0.2, 0.3, 0.7, 0.25, 0.05, 0.03}},
      {"beard-maxwell:shadowing=smith,slopes=gaussian", {1.5, 0.2, 0.2, 0.3, 0.05, 0.03}},
      {"subsurface", {1.5, 0.6}},
      {"single-scatter", {1.4, 0.7, 0.4}},
      {"phong", {0.2, 40.0}},
      {"ward", {0.2, 0.2, 0.3}},
      {"microfacet+ggx+nef", {1.5, 0.2, 0.2, 1.0, 1.4, 0.1, 0.5, 0.1, 0.02}}};
}

}  // namespace umov::brdf
