// An effect without a signature: it adds scatter. Its evidence is in the variance of what the whole
// catalogue leaves of a measurement, in proportion to the signal, beyond the noise that is known.
//
// Told from others by its ways:
//   fixed to the place, independent from place to place   the effect itself
//   new in every observation                              noise that nobody saw (fresh noise)
//   alike in neighbours in time                           slow noise: RelativeNoise::slow
//   alike in neighbours along a row                       a misfit of the mean
// The first two are the same thing where no place is measured twice: then they are rivals, told
// apart by a prior alone. A misfit is kept out by asking ordinary observations (large ones
// count little, so that a region of bad ones does not matter) how they differ from what a parabola
// through their neighbours foretells.
#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "host/gap/engine/forward_model.hpp"

namespace umov::gap {

struct ExcessVariance {
  /// Of the effect, and of fresh noise of the same size instead; both are in it where places repeat
  /// and show both.
  double probability = 0, fresh_probability = 0;
  /// Standard deviation over the signal, most likely value and where twice the log-likelihood is
  /// within 3.84 of it.
  double size = 0, lo = 0, hi = 0;
  RelativeNoise with;     ///< most likely noise with the effect in it
  RelativeNoise without;  ///< most likely noise if there is neither effect nor fresh noise
  /// What a parabola through neighbours leaves: variance over the squared signal, and one standard
  /// error of that. It should be size².
  double local = 0, local_u = 0;
  /// Of either.
  double joint_probability() const;
  /// The two within this of twice the log evidence.
  bool ambiguous(double within) const;
  /// True where neighbours confirm it.
  bool confirmed() const;
};

/// A residual and what is known of it.
struct Leftover {
  Eigen::VectorXd residual;  ///< of the mean, in its own units
  Eigen::VectorXd kept;      ///< share of each observation's variance that is left in it
  double noise_scale = 1;    ///< common factor of the known noise
};

/// Weighs `effect` (of the kind `scatter`) against fresh noise and against neither. `learned`: the
/// noise that explains the leftover best. `ln_odds`: of the effect before any data. Probability 0
/// where the excess is a misfit, or where the noise is known up to a factor only and no place
/// repeats.
ExcessVariance weigh_excess(const ForwardModel& model, const Effect& effect,
                            const NoiseShape& shape, const Leftover& leftover,
                            const RelativeNoise& learned, double ln_odds);

}  // namespace umov::gap
