// The effects a case may carry: name, canonical parameters, and what they set in the plant.
//
// Names, parameters, units and signs of the catalogue's effects are those of the diagnosis. The
// generator has further effects that no catalogue knows.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "hil/blind/random.hpp"
#include "hil/blind/scan_rows.hpp"
#include "hil/plant/plant_config.hpp"

namespace umov::blind {

using Named = std::pair<std::string, double>;

/// An effect with its size. The first parameter is the principal one, which is scaled.
struct Effect {
  std::string name;
  bool in_catalogue = true;
  std::vector<Named> parameters;
  bool enlarged = false;          ///< in a crowded case
  double rho = 0.0;               ///< alone, see change.hpp
  double rho_given_others = 0.0;  ///< beside the case's other effects

  double size() const { return parameters.front().second; }
};

/// What an effect's meaning depends on beside its parameters.
struct EffectContext {
  double duration_s = 3600.0;  ///< of the case's own scan
  std::array<double, plant::laser_count> monitor_v{1.6, 1.5, 1.55};
  double slope_rms = 0.15;  ///< of the material
};

/// A kind of effect.
struct EffectKind {
  std::string name;
  bool in_catalogue;
  double smallest, largest;  ///< of the principal parameter's modulus: what a bench may have
  bool both_signs;
  std::string principal;  ///< its canonical name
  /// Further parameters, drawn.
  std::function<std::vector<Named>(Random&, const EffectContext&)> further;
  /// Plant parameters for the canonical ones, in their order.
  std::function<std::vector<Named>(const std::vector<Named>&, const EffectContext&)> settings;
  std::string about;
  /// Parameters that are scaled together, the first ones.
  std::size_t scaled_together = 1;
};

/// All kinds; the catalogue's first.
const std::vector<EffectKind>& effect_kinds();
/// Throws umov::Error for an unknown name.
const EffectKind& effect_kind(const std::string& name);

/// An effect of this kind with its principal parameter at `size` times a random sign.
Effect draw_effect(const EffectKind& kind, Random& random, const EffectContext& context,
                   double size);
/// The same effect with its size multiplied by `factor` > 0.
Effect scaled(const Effect& effect, double factor);
/// The plant with the effects in it. Throws umov::Error where a value is outside the plant's range.
void apply(const Effect& effect, const EffectContext& context, plant::PlantConfig& config);

}  // namespace umov::blind
