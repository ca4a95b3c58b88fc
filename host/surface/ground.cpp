#include "host/surface/ground.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace umov::surface {

Ground::Ground(std::vector<double> heights, std::size_t side, double size)
    : heights_(std::move(heights)), side_(side), size_(size) {}

// Calls act(height, squared distance in plan) for the heights below a disc, and for the nearest
// one.
template <class Act>
void Ground::each_below(double x, double y, double radius, const Act& act) const {
  const double step = size_ / static_cast<double>(side_);
  const long side = static_cast<long>(side_);
  const auto wrapped = [&](long k) { return static_cast<std::size_t>(((k % side) + side) % side); };
  const auto at = [&](long i, long j) { return heights_[wrapped(j) * side_ + wrapped(i)]; };
  const long middle_i = std::lround(x / step);
  const long middle_j = std::lround(y / step);
  act(at(middle_i, middle_j), 0.0);
  const long reach = static_cast<long>(std::ceil(radius / step));
  for (long j = middle_j - reach; j <= middle_j + reach; ++j) {
    for (long i = middle_i - reach; i <= middle_i + reach; ++i) {
      const double dx = static_cast<double>(i) * step - x;
      const double dy = static_cast<double>(j) * step - y;
      const double d2 = dx * dx + dy * dy;
      if (d2 < radius * radius) act(at(i, j), d2);
    }
  }
}

double Ground::rest(double x, double y, double radius) const {
  if (!rough()) return flat_ + radius;
  double centre = -std::numeric_limits<double>::infinity();
  each_below(x, y, radius, [&](double z, double d2) {
    centre = std::max(centre, z + std::sqrt(radius * radius - d2));
  });
  return centre;
}

double Ground::level(double x, double y, double radius) const {
  if (!rough()) return flat_;
  double sum = 0.0;
  double count = 0.0;
  each_below(x, y, radius, [&](double z, double) {
    sum += z;
    ++count;
  });
  return sum / count;
}

}  // namespace umov::surface
