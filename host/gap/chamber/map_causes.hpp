// The catalogue of what a simulated luminance map may have wrong: for each effect its parameters
// and how the luminaire is built with a step of them.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "host/chamber/departure.hpp"
#include "host/gap/engine/forward_model.hpp"

namespace umov::gap {

/// One parameter of an effect.
struct MapChange {
  Parameter parameter;
  double step;  ///< enough to show above the noise, little enough to be near linear
  /// The luminaire with this much of it; throws umov::Error where there is no room for it.
  std::function<chamber::View(double)> view;
};

struct MapCause {
  Effect effect;  ///< its parameters are those of `changes`
  std::vector<MapChange> changes;
  /// What the changes are taken from (number in MapCauses::origins), where that is not the
  /// luminaire as described.
  std::optional<std::size_t> origin = {};
};

struct MapCauses {
  std::vector<MapCause> causes;
  /// The luminaire with each of its surfaces matt in turn, of the reflectance it has: changes of a
  /// surface then do not depend on what the simulation takes it for. And with one source alone:
  /// maps of single sources show what each does with far less noise than maps of all with a little
  /// more of one.
  std::vector<std::function<chamber::View()>> origins;
};

/// `size_mm`: of what the camera sees; mechanical tolerances are in proportion to it. What is
/// returned refers to `luminaire`.
MapCauses map_causes(const chamber::Described& luminaire, double size_mm);

/// The window's larger side.
double size_of(const chamber::Camera& camera);

/// The catalogue for a luminaire, in the order of map_causes(); nothing is simulated.
std::vector<Effect> map_effects(const chamber::Described& luminaire);

}  // namespace umov::gap
