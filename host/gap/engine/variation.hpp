// What is left of a measurement, read as something known that is not as constant as it should be: a
// zero that changes with the polariser's setting, a gain that steps in mid-scan. Causes that no
// catalogue has are often of this kind.
#pragma once

#include <string>

#include <Eigen/Core>

#include "host/gap/engine/forward_model.hpp"
#include "host/gap/engine/refit.hpp"

namespace umov::gap {

/// The strongest sign of something that varies with a circumstance of the measurement.
struct Variation {
  std::string what;        ///< effect or base parameter; "signal": the scale of everything
  std::string with, unit;  ///< the circumstance, as its axis is named
  enum class Kind { level, trend, step, swing, wander } kind = Kind::level;
  /// level: its value; step: where; swing: period; trend: order; wander: relative size
  double at = 0;
  std::string at_name;  ///< of a level that is no number
  double gain = 0;      ///< decrease of χ², all fitted parameters free to follow
  double p_global = 1;  ///< that noise alone shows as much anywhere it was looked for (Bonferroni)
  Eigen::MatrixXd signature;  ///< whitened, one or two columns; empty: nothing to look at
};

const char* to_string(Variation::Kind kind);

/// The wander of the signal that the whitening takes for slow noise, judged against white noise
/// alone: a source or an amplifier whose output nobody watches.
Variation slow_wander(const ForwardModel& model, const Refit& fit, const Whitening& whitening,
                      double noise_scale);

/// Looks at each effect (structure apart), each base parameter and the signal itself, switched on
/// and off with each of the observations' circumstances. `fit` must be a minimum. `known_gain`: Δχ²
/// from which a known effect, constant as it should be, counts as a rival.
Variation strongest_variation(const ForwardModel& model, const Refit& fit,
                              const Whitening& whitening, double known_gain, int threads);

}  // namespace umov::gap
