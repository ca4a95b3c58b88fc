#include "host/brdf/visible_slope.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

namespace umov::brdf {
namespace {

constexpr double root_pi_inverse = std::numbers::inv_sqrtpi;

/// F(x) = ½ erfc(-x) + tilt e^(-x²)/2√π, which rises until x = 1/tilt, where facets turn their
/// backs.
struct Visible {
  double tilt, last, total;

  explicit Visible(double tilt_of_beam)
      : tilt(tilt_of_beam),
        last(tilt > 0.0 ? 1.0 / tilt : std::numeric_limits<double>::infinity()),
        total(last > 6.0 ? 1.0 : cumulative(last, std::exp(-last * last) * root_pi_inverse)) {}

  double cumulative(double x, double bell) const { return 0.5 * std::erfc(-x) + 0.5 * tilt * bell; }

  /// Halley's method from `x` until a step is below `small`; what is left then is of the order of
  /// its cube.
  double solve(double target, double x, double small) const {
    for (int i = 0; i < 60; ++i) {
      const double bell = std::exp(-x * x) * root_pi_inverse;
      const double density = (1.0 - tilt * x) * bell;
      if (!(density > 0.0)) break;
      const double newton = (cumulative(x, bell) - target) / density;
      // F''/F' = -tilt/(1 - tilt x) - 2x.
      const double bend = -tilt / (1.0 - tilt * x) - 2.0 * x;
      const double next = x - newton / std::max(0.5, 1.0 - 0.5 * newton * bend);
      const double step = next - x;
      x = next < last ? next : 0.5 * (x + last);
      if (std::abs(step) < small * std::min(1.0, std::abs(x) + last)) break;
    }
    return x;
  }

  /// The density's maximum: Newton's method from there stays on one side of the root.
  double mode() const { return -tilt / (1.0 + std::sqrt(1.0 + 2.0 * tilt * tilt)); }
};

/// z with ½ erfc(-z) = u to some 2e-3 (Winitzki 2008).
double rough_gaussian(double u) {
  constexpr double a = 0.147, b = 2.0 / (std::numbers::pi * a);
  const double log_term = std::log(std::max(4.0 * u * (1.0 - u), 1e-300));
  const double half = b + 0.5 * log_term;
  const double z = std::sqrt(std::max(0.0, std::sqrt(half * half - log_term / a) - half));
  return u < 0.5 ? -z : z;
}

/// Solutions over tilt/(1 + tilt) and rough_gaussian(u), to start from.
class Starts {
 public:
  Starts() {
    for (std::size_t i = 0; i < tilts; ++i) {
      const double m = static_cast<double>(i) / tilts;
      const Visible visible(m / (1.0 - m));
      for (std::size_t j = 0; j < places; ++j) {
        const double z = reach * (2.0 * static_cast<double>(j) / (places - 1) - 1.0);
        start_[i * places + j] =
            visible.solve(0.5 * std::erfc(-z) * visible.total, visible.mode(), 1e-9);
      }
    }
  }

  double at(double tilt, double z) const {
    const double row = std::min(tilt / (1.0 + tilt) * tilts, tilts - 1.000001);
    const double column =
        std::clamp((z / reach + 1.0) * 0.5 * (places - 1), 0.0, places - 1.000001);
    const auto i = static_cast<std::size_t>(row), j = static_cast<std::size_t>(column);
    const double a = row - static_cast<double>(i), b = column - static_cast<double>(j);
    const double* x = start_.data() + i * places + j;
    return (1.0 - a) * ((1.0 - b) * x[0] + b * x[1]) +
           a * ((1.0 - b) * x[places] + b * x[places + 1]);
  }

 private:
  static constexpr std::size_t tilts = 64, places = 80;
  static constexpr double reach = 3.5;
  std::array<double, tilts * places> start_{};
};

}  // namespace

double visible_slope(double u, double tilt) {
  const double z = rough_gaussian(u);
  const Visible visible(tilt);
  const double target = u * visible.total;
  if (tilt == 0.0) return visible.solve(target, z, 2e-3);
  static const Starts starts;
  const double start = starts.at(tilt, z);
  return visible.solve(target, start < visible.last ? start : visible.mode(), 2e-3);
}

}  // namespace umov::brdf
