#include "host/brdf/height_series.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace umov::brdf {
namespace {

constexpr int tabulated = 128;

/// log(m! m) for small m.
const std::array<double, tabulated>& log_weights() {
  static const std::array<double, tabulated> table = [] {
    std::array<double, tabulated> t{};
    double log_factorial = 0.0;
    for (int m = 1; m < tabulated; ++m) {
      log_factorial += std::log(static_cast<double>(m));
      t[static_cast<std::size_t>(m)] = log_factorial + std::log(static_cast<double>(m));
    }
    return t;
  }();
  return table;
}

/// Logarithm of the summand for integer m >= 1.
double log_term(double m, double g, double log_g, double u) {
  if (m < tabulated) return m * log_g - g - log_weights()[static_cast<std::size_t>(m)] - u / m;
  // Stirling, with the large parts m ln(g/m) + m - g combined before they can cancel.
  const double r = (g - m) / m;
  const double stirling = (1.0 / 12.0 - 1.0 / (360.0 * m * m)) / m;
  static const double half_log_two_pi = 0.5 * std::log(2.0 * std::numbers::pi);
  return m * (std::log1p(r) - r) - stirling - half_log_two_pi - 1.5 * std::log(m) - u / m;
}

/// Where the summand peaks: m² ln(m/g) = u, to the accuracy that centring a sum needs.
double peak(double g, double u) {
  const double w = u / (g * g);
  double x = w > 7.4 ? std::sqrt(w) : 1.0 + w;  // right of the root of the convex x² ln x - w
  for (int i = 0; i < 30; ++i) {
    const double log_x = std::log(x);
    const double step = (x * x * log_x - w) / (x * (2.0 * log_x + 1.0));
    x -= step;
    if (std::abs(step) < 1e-3 * x) break;
  }
  return g * x;
}

}  // namespace

HeightSeries height_series(double g, double u) {
  const double log_g = std::log(g);
  const double m_peak = std::max(1.0, std::round(peak(g, u)));
  // Far from m = 1 the summand is nearly Gaussian about its peak. Sampling it at every stride-th
  // integer is a trapezoidal rule, whose error falls as exp(-2π² (width/stride)²): 0.6 of the width
  // is beyond double precision. Nearer, where the sum ends at m = 1 on some e^-m of its mass, every
  // term is taken.
  const double width = 1.0 / std::sqrt(1.0 / m_peak + 2.0 * u / (m_peak * m_peak * m_peak));
  const double stride = m_peak < 45.0 ? 1.0 : std::max(1.0, std::floor(0.6 * width - 0.5));
  const double log_peak = log_term(m_peak, g, log_g, u);
  constexpr double negligible = -40.0;

  HeightSeries sum{0.0, 0.0, 0.0};
  const auto add = [&](double m) {
    const double log_relative = log_term(m, g, log_g, u) - log_peak;
    const double term = std::exp(log_relative);
    sum.value += term;
    sum.by_g += term * (m - g) / g;
    sum.by_u -= term / m;
    return log_relative > negligible;
  };
  for (double m = m_peak; add(m); m += stride) {
  }
  for (double m = m_peak - stride; m >= 1.0 && add(m); m -= stride) {
  }
  const double scale = stride * std::exp(log_peak);
  return {sum.value * scale, sum.by_g * scale, sum.by_u * scale};
}

}  // namespace umov::brdf
