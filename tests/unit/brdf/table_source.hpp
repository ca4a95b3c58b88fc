// What the tests of tables have in common: a model to tabulate, axes, and what an error says.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/brdf/evaluate.hpp"
#include "host/brdf/model.hpp"
#include "host/errors/error.hpp"

namespace umov::brdf {

inline std::vector<double> steps(double from, double to, double step) {
  std::vector<double> axis;
  for (int k = 0; from + k * step <= to + 1e-9; ++k) axis.push_back(from + k * step);
  return axis;
}

inline Geometry<double> degrees(double theta_i, double theta_r, double phi) {
  return {optics::radians(theta_i), optics::radians(theta_r), optics::radians(phi)};
}

inline std::string message(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

inline const Model source_model = Model::by_name("microfacet+lambertian");
inline const std::vector<double> source_values{1.5, 0.3, 0.2, 1.0, 0.3};

inline optics::Mueller<double> source(const Geometry<double>& g) {
  return evaluate<double>(source_model, source_values, 0.633, g);
}

}  // namespace umov::brdf
