// What discs cover together, counted on a lattice of points.
#pragma once

#include <cstddef>
#include <vector>

#include "host/surface/particles.hpp"

namespace umov::surface {

class Coverage {
 public:
  explicit Coverage(double size);
  void add(const Disc& disc);
  double share() const;

 private:
  double size_;
  std::vector<char> covered_;
  std::size_t count_ = 0;
};

}  // namespace umov::surface
