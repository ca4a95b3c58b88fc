// What a luminaire's luminance map looks like, and how it changes with everything that a simulation
// of it may have wrong.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/chamber/departure.hpp"
#include "host/gap/engine/forward_model.hpp"

namespace umov::gap {

struct MapOptions {
  std::size_t joined = 5;                   ///< pixels of the camera to one, each way
  std::uint64_t rays_per_pixel = 8000;      ///< of the simulated map, for a joined pixel
  std::uint64_t rays_per_signature = 2000;  ///< of each changed map and the one it is taken from
  std::uint64_t seed = 1;
  int threads = 0;
  std::function<void(double)> progress = {};  ///< share that is done; may throw to stop
};

/// Change of a map for one unit of each parameter of an effect, as columns.
struct MapEffect {
  Effect effect;
  Eigen::MatrixXd columns;
};

/// Made once for a luminaire and its camera; any number of measured maps can be held against it.
/// Derivatives are differences of maps that share their random numbers, smoothed as far as they are
/// smooth (smoothing.hpp).
struct MapSignatures {
  MapOptions options;
  /// Those used, of the joined map: they see the luminaire however it is changed, and so do their
  /// neighbours, so that no outline that moves falls on them.
  std::vector<std::size_t> pixels;
  chamber::Map map;          ///< as simulated, joined
  Eigen::VectorXd mean, se;  ///< of `pixels`
  /// Share of the strongest near-specular signature: 1 in the middle of a highlight.
  Eigen::VectorXd highlight;
  std::vector<MapEffect> effects;
  /// "effect: parameter" of the catalogue for which this luminaire and camera leave no room.
  std::vector<std::string> without_room;
};

/// Throws umov::Error for a map of which no pixel can be used.
MapSignatures map_signatures(const chamber::Described& luminaire, const MapOptions& options);

}  // namespace umov::gap
