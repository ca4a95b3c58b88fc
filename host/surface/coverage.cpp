#include "host/surface/coverage.hpp"

#include <cmath>

namespace umov::surface {
namespace {

constexpr long side = 2048;

}  // namespace

Coverage::Coverage(double size) : size_(size), covered_(static_cast<std::size_t>(side * side), 0) {}

void Coverage::add(const Disc& disc) {
  const double step = size_ / static_cast<double>(side);
  const auto wrapped = [](long k) { return static_cast<std::size_t>(((k % side) + side) % side); };
  const long low = static_cast<long>(std::ceil((disc.y - disc.radius) / step - 0.5));
  const long high = static_cast<long>(std::floor((disc.y + disc.radius) / step - 0.5));
  for (long j = low; j <= high; ++j) {
    const double dy = (static_cast<double>(j) + 0.5) * step - disc.y;
    const double half = std::sqrt(std::max(0.0, disc.radius * disc.radius - dy * dy));
    const long first = static_cast<long>(std::ceil((disc.x - half) / step - 0.5));
    const long last = static_cast<long>(std::floor((disc.x + half) / step - 0.5));
    for (long i = first; i <= last; ++i) {
      char& point = covered_[wrapped(j) * static_cast<std::size_t>(side) + wrapped(i)];
      count_ += point == 0 ? 1 : 0;
      point = 1;
    }
  }
}

double Coverage::share() const {
  return static_cast<double>(count_) / static_cast<double>(side * side);
}

double covered_share(const std::vector<Disc>& discs, double size) {
  Coverage coverage(size);
  for (const Disc& disc : discs) coverage.add(disc);
  return coverage.share();
}

}  // namespace umov::surface
