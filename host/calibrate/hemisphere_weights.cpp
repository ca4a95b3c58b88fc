// Product quadrature over the hemisphere: the weight cosθ |sinθ| is integrated exactly (Gauss), the
// profile is the interpolant through its nodes.
#include <algorithm>
#include <array>
#include <cmath>

#include "host/calibrate/dhr.hpp"

namespace umov::calibrate {

namespace {

constexpr std::array<double, 5> gauss_node = {0.0, 0.5384693101056831, -0.5384693101056831,
                                              0.9061798459386640, -0.9061798459386640};
constexpr std::array<double, 5> gauss_weight = {0.5688888888888889, 0.4786286704993665,
                                                0.4786286704993665, 0.2369268850561891,
                                                0.2369268850561891};

/// Solves the symmetric tridiagonal system of a natural spline's curvatures.
std::vector<double> solve_tridiagonal(const std::vector<double>& diagonal,
                                      const std::vector<double>& off, std::vector<double> right) {
  const std::size_t n = diagonal.size();
  std::vector<double> d = diagonal;
  for (std::size_t k = 1; k < n; ++k) {
    const double factor = off[k - 1] / d[k - 1];
    d[k] -= factor * off[k - 1];
    right[k] -= factor * right[k - 1];
  }
  for (std::size_t k = n; k-- > 0;) {
    if (k + 1 < n) right[k] -= off[k] * right[k + 1];
    right[k] /= d[k];
  }
  return right;
}

}  // namespace

std::vector<double> hemisphere_weights(const std::vector<double>& theta_rad, bool straight) {
  const std::size_t n = theta_rad.size();
  std::vector<double> weight(n, 0.0), curvature_weight(n, 0.0);
  for (std::size_t j = 0; j + 1 < n; ++j) {
    const double a = theta_rad[j], b = theta_rad[j + 1], h = b - a;
    std::vector<double> cuts = {a};
    if (a < 0 && b > 0) cuts.push_back(0.0);  // |sinθ| has a corner there
    cuts.push_back(b);
    for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
      const double middle = 0.5 * (cuts[c] + cuts[c + 1]), half = 0.5 * (cuts[c + 1] - cuts[c]);
      for (std::size_t g = 0; g < gauss_node.size(); ++g) {
        const double t = middle + half * gauss_node[g];
        const double w = half * gauss_weight[g] * std::cos(t) * std::abs(std::sin(t));
        const double left = (b - t) / h, right = (t - a) / h;
        weight[j] += w * left;
        weight[j + 1] += w * right;
        curvature_weight[j] += w * (left * left * left - left) * h * h / 6.0;
        curvature_weight[j + 1] += w * (right * right * right - right) * h * h / 6.0;
      }
    }
  }
  if (straight || n < 3) return weight;
  // Curvatures M solve T M = R f, so their weights pass on to f through Rᵀ T⁻¹ (T is symmetric).
  std::vector<double> diagonal, off, right;
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const double before = theta_rad[k] - theta_rad[k - 1], after = theta_rad[k + 1] - theta_rad[k];
    diagonal.push_back((before + after) / 3.0);
    off.push_back(after / 6.0);
    right.push_back(curvature_weight[k]);
  }
  const std::vector<double> passed = solve_tridiagonal(diagonal, off, right);
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const double before = theta_rad[k] - theta_rad[k - 1], after = theta_rad[k + 1] - theta_rad[k];
    const double v = passed[k - 1];
    weight[k - 1] += v / before;
    weight[k] -= v * (1.0 / before + 1.0 / after);
    weight[k + 1] += v / after;
  }
  return weight;
}

}  // namespace umov::calibrate
