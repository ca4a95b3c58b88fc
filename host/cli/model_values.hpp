// A model with its parameters, as --set options name them, and the light that --wavelength-nm and
// --theta-i shine on it.
#pragma once

#include <string>
#include <vector>

#include "host/brdf/model.hpp"

namespace umov::cli {

struct ModelValues {
  brdf::Model model;
  std::vector<double> values;  ///< within their ranges
};

/// `settings` are NAME=VALUE: parameters, choices, files of tables. Throws umov::Error for what
/// does not exist or is out of range.
ModelValues model_values(const std::string& name, const std::vector<std::string>& settings);

/// `wavelength_nm` in µm. Throws umov::Error outside 100 nm to 100 µm.
double checked_wavelength_um(double wavelength_nm);

/// `theta_i_deg` in radians. Throws umov::Error outside [0, 90).
double checked_incidence(double theta_i_deg);

}  // namespace umov::cli
