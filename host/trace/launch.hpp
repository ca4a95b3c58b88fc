// Where light enters a periodic scene.
#pragma once

#include <array>
#include <cstdint>

#include "host/trace/random_stream.hpp"

namespace umov::trace {

/// A point of the unit square, uniform for uniform `along`, `u`, `v` in [0, 1): cell number
/// ⌊along·4¹²⌋ of a Hilbert curve through 4096² cells, at `u`, `v` within it. Points whose `along`
/// is near each other are near each other.
std::array<double, 2> on_hilbert_curve(double along, double u, double v);

/// Launch `number` of a block of `launches`, as shares of the period. The launches of a block have
/// a stretch of the curve each, so that all parts of the scene get their share of the block, and
/// paths that are traced one after the other meet the same faces: with many of them, they are still
/// in the processor's caches. `u` are the sample's numbers of event 0.
inline std::array<double, 2> launch_point(std::uint64_t number, std::uint64_t launches,
                                          const std::array<double, 4>& u) {
  const double along = (static_cast<double>(number) + u[0]) / static_cast<double>(launches);
  return on_hilbert_curve(along, u[1], u[2]);
}

}  // namespace umov::trace
