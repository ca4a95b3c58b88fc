// Which discs are near a place, on a square that repeats.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/surface/particles.hpp"

namespace umov::surface {

/// Numbers of discs by place. `largest` is the radius of the largest disc that will be added.
class DiscLattice {
 public:
  DiscLattice(double size, double largest)
      : size_(size),
        largest_(largest),
        side_(std::clamp<long>(static_cast<long>(size / (2.0 * largest)), 1, 4096)),
        cells_(static_cast<std::size_t>(side_ * side_)) {}

  void add(std::size_t number, double x, double y) {
    cells_[index(place(x), place(y))].push_back(number);
  }
  void clear() {
    for (auto& cell : cells_) cell.clear();
  }

  /// Calls act(number) for every disc that may be nearer than `distance` to the rim of one at
  /// (x, y), until it returns false; whether it never did.
  template <class Act>
  bool each_near(double x, double y, double distance, const Act& act) const {
    const double width = size_ / static_cast<double>(side_);
    const long reach = static_cast<long>(std::ceil((distance + largest_) / width));
    // Over the whole square each cell once.
    const bool whole = 2 * reach + 1 >= side_;
    const long low = whole ? 0 : -reach;
    const long high = whole ? side_ - 1 : reach;
    for (long j = low; j <= high; ++j) {
      for (long i = low; i <= high; ++i) {
        for (const std::size_t n : cells_[index(place(x) + i, place(y) + j)]) {
          if (!act(n)) return false;
        }
      }
    }
    return true;
  }

 private:
  long place(double x) const { return static_cast<long>(x / size_ * static_cast<double>(side_)); }
  std::size_t index(long i, long j) const {
    const auto wrapped = [&](long k) { return ((k % side_) + side_) % side_; };
    return static_cast<std::size_t>(wrapped(j) * side_ + wrapped(i));
  }

  double size_, largest_;
  long side_;
  std::vector<std::vector<std::size_t>> cells_;
};

}  // namespace umov::surface
