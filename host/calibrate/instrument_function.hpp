// The instrument function IF(θr): smooth, one at the reference angle (P5).
#pragma once

#include <vector>

#include <Eigen/Core>

namespace umov::calibrate {

/// ln IF(θ) = -Σ c_k [P_n(k)(x) - P_n(k)(x0)], x = θ/90°, P Legendre polynomials, x0 the reference
/// angle. A measured BRDF is multiplied by IF.
struct InstrumentFunction {
  std::vector<int> degrees;  ///< n(k) > 0, ascending; empty: IF = 1
  std::vector<double> coefficients;
  double reference_deg = 0;            ///< IF = 1 here
  double min_deg = -85, max_deg = 85;  ///< range of θr that the standard covered

  /// IF at signed `theta_r_deg`; not checked against the range.
  double value(double theta_r_deg) const;
  /// -d ln IF / d c_k.
  Eigen::VectorXd basis(double theta_r_deg) const;
  bool covers(double theta_r_deg) const;
};

/// One basis function, P_n(θ/90°) - P_n(θ0/90°).
double instrument_basis(int degree, double theta_r_deg, double reference_deg);

}  // namespace umov::calibrate
