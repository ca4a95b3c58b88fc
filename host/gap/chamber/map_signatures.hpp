// What a mixing chamber's luminance map looks like, and how it changes with everything that a
// simulation of it may have wrong.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/chamber/mixing_chamber.hpp"
#include "host/gap/engine/forward_model.hpp"

namespace umov::gap {

struct MapOptions {
  std::size_t coarser = 5;                  ///< than [M]'s pixels of 0.2 mm
  std::uint64_t rays_per_pixel = 8000;      ///< of the simulated map
  std::uint64_t rays_per_signature = 2000;  ///< of each changed map and the one it is taken from
  std::uint64_t seed = 1;
  int threads = 0;
  std::function<void(double)> progress = {};
};

/// Change of a map for one unit of each parameter of an effect, as columns.
struct MapEffect {
  Effect effect;
  Eigen::MatrixXd columns;
};

/// Made once for a chamber and a model of its wall; any number of measured maps can be held
/// against it. Derivatives are differences of maps that share their random numbers, smoothed as far
/// as they are smooth (smoothing.hpp).
struct MapSignatures {
  chamber::MixingChamber chamber;
  MapOptions options;
  std::vector<std::size_t> pixels;  ///< that see the inside whatever the angle of view is
  chamber::Map map;                 ///< as simulated
  Eigen::VectorXd mean, se;         ///< of these pixels
  /// Share of the strongest near-specular signature: 1 in the middle of a highlight.
  Eigen::VectorXd highlight;
  std::vector<MapEffect> effects;
};

MapSignatures map_signatures(const chamber::MixingChamber& chamber, const MapOptions& options);

}  // namespace umov::gap
