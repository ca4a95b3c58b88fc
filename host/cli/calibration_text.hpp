// A calibration for the terminal and for --json.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/calibrate/calibration.hpp"

namespace umov::cli {

/// What is shown beside the calibration itself.
struct CalibrationView {
  bool campaign = false;  ///< with linearity, stray light and reciprocity
  std::vector<std::string> missing;
  /// Name of a standard -> row of the published table beside which it is laid.
  std::vector<std::pair<std::string, std::string>> compare;
  double reciprocity_target = 0.01;
  double slow_noise = 0;  ///< relative, of one record, as the linearity fit found it
};

void print_calibration(const calibrate::Calibration& calibration, const CalibrationView& view);

/// One line of JSON.
std::string calibration_json(const calibrate::Calibration& calibration, const CalibrationView& view,
                             const std::string& file);

}  // namespace umov::cli
