#include "hil/plant/noise.hpp"

#include <cmath>

#include "host/optics/angles.hpp"

namespace umov::plant {
namespace {

/// z > 0 with P(|Z| > z) = p, by Newton on log P, which is concave: two-sided tail p in (0, 1].
double two_sided_quantile(double p) {
  if (p >= 1.0) return 0.0;
  double z = std::sqrt(std::max(0.0, -1.5 * std::log(p)));
  for (int i = 0; i < 60; ++i) {
    const double tail = std::erfc(z / std::sqrt(2.0));
    const double density = std::sqrt(2.0 / optics::pi) * std::exp(-0.5 * z * z);
    const double step = (std::log(tail) - std::log(p)) * tail / density;
    z += step;
    if (z < 0.0) z = 0.0;
    if (std::abs(step) < 1e-14 * (1.0 + z)) break;
  }
  return z;
}

}  // namespace

GaussianTable::GaussianTable() {
  for (std::uint32_t i = 0; i < cells; ++i) {
    edge_[i] = two_sided_quantile(1.0 - static_cast<double>(i) / cells);
  }
}

double GaussianTable::tail(std::uint32_t magnitude) {
  return two_sided_quantile((static_cast<double>(0x80000000u - magnitude) - 0.5) * 0x1p-31);
}

const GaussianTable& GaussianTable::instance() {
  static const GaussianTable table;
  return table;
}

double gaussian_of(std::uint64_t key, std::uint64_t counter) {
  return GaussianTable::instance()(static_cast<std::uint32_t>(random_bits(key, counter) >> 32));
}

}  // namespace umov::plant
