// Rows of tests/data/reference/brdf_reference_values.csv.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace umov::brdf::reference {

struct Row {
  std::string id, quantity, model, basis;
  std::map<std::string, std::string> parameters;
  double theta_i_deg = 0.0, theta_r_deg = 0.0, phi_r_deg = 0.0;
  std::optional<std::array<double, 16>> mueller;  ///< row by row
  std::optional<double> value;

  double number(const std::string& key) const;
  /// "(n,k)" under key "substrate".
  std::pair<double, double> substrate() const;
};

/// All data rows of the file.
std::vector<Row> read();

}  // namespace umov::brdf::reference
