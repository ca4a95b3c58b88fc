// How well a record is known: the variance of x_v and y_v that the instrument's noise gives.
#pragma once

#include "hil/blind/bench.hpp"

namespace umov::blind {

struct RecordVariance {
  double x_v2 = 0.0, y_v2 = 0.0;
};

/// White noise of amplifier, ADC and photodiode, jitter of the light and the monitor's noise. Slow
/// noise (1/f) is not in it.
class RecordNoise {
 public:
  RecordNoise(const plant::PlantConfig& config, const Acquisition& acquisition);
  RecordVariance of(int laser, const CleanRecord& record) const;
  /// Relative standard deviation of X for unit jitter of the light.
  double jitter_share() const;

 private:
  plant::PlantConfig config_;
  double samples_;
  /// Variance of X per squared signal for unit jitter of the light, and of Y for a radian of phase
  /// jitter.
  double jitter_share2_ = 0.0;
};

}  // namespace umov::blind
