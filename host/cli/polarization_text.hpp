// A polarisation calibration and Mueller tables for the terminal and for --json.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "host/calibrate/polarization.hpp"

namespace umov::cli {

/// A table of axes, extinction ratios and biases with their uncertainties, a line a wavelength.
std::string polarization_text(const calibrate::PolarizationCalibration& polarization);

nlohmann::json polarization_json(const calibrate::PolarizationCalibration& polarization);

}  // namespace umov::cli
