// Evenly spread numbers without chance.
#pragma once

#include <cstddef>

namespace umov::formats {

/// Member `index` of the van der Corput sequence of `base`: evenly spread over [0, 1). Sequences of
/// different primes together fill a square, a cube, … evenly (Halton).
inline double spread(std::size_t index, std::size_t base) {
  double value = 0.0, step = 1.0;
  for (; index > 0; index /= base) {
    step /= static_cast<double>(base);
    value += step * static_cast<double>(index % base);
  }
  return value;
}

}  // namespace umov::formats
