#include "host/calibrate/instrument_function.hpp"

#include <cmath>

namespace umov::calibrate {

namespace {

/// Legendre polynomial P_n(x).
double legendre(int n, double x) {
  double before = 1.0, now = x;
  if (n == 0) return before;
  for (int k = 1; k < n; ++k) {
    const double next = ((2.0 * k + 1.0) * x * now - k * before) / (k + 1.0);
    before = now;
    now = next;
  }
  return now;
}

/// The fit covers angles to the last millidegree.
constexpr double edge_deg = 1e-3;

}  // namespace

double instrument_basis(int degree, double theta_r_deg, double reference_deg) {
  return legendre(degree, theta_r_deg / 90.0) - legendre(degree, reference_deg / 90.0);
}

double InstrumentFunction::value(double theta_r_deg) const {
  double sum = 0;
  for (std::size_t k = 0; k < degrees.size(); ++k)
    sum += coefficients[k] * instrument_basis(degrees[k], theta_r_deg, reference_deg);
  return std::exp(-sum);
}

Eigen::VectorXd InstrumentFunction::basis(double theta_r_deg) const {
  Eigen::VectorXd result(static_cast<Eigen::Index>(degrees.size()));
  for (std::size_t k = 0; k < degrees.size(); ++k)
    result(static_cast<Eigen::Index>(k)) = instrument_basis(degrees[k], theta_r_deg, reference_deg);
  return result;
}

bool InstrumentFunction::covers(double theta_r_deg) const {
  return theta_r_deg >= min_deg - edge_deg && theta_r_deg <= max_deg + edge_deg;
}

}  // namespace umov::calibrate
