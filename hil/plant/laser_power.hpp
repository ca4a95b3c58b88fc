// A laser's power over time, split into what the monitor sees and what it misses.
#pragma once

#include <array>
#include <cstdint>

#include "hil/plant/plant_config.hpp"

namespace umov::plant {

/// Noise with a 1/f spectrum from 1e-4 to 20 Hz and rms 1, as a function of time alone: it does not
/// depend on which moments are asked for. Equal tones, evenly spaced in log frequency and jittered
/// within their interval.
class SlowNoise {
 public:
  explicit SlowNoise(std::uint64_t seed);
  double at(double time_s) const;

 private:
  static constexpr int tones = 18;
  std::array<double, tones> frequency_hz_{}, phase_{};
};

class LaserPower {
 public:
  LaserPower(const LaserConfig& config, std::uint64_t seed);

  /// Relative power that both monitor and sample receive; 1 where nothing drifts.
  double seen(double time_s) const;
  /// Further factor on the sample's light only. Warm-up runs from time 0, when the supplies are
  /// switched on (the board's enables only gate the light).
  double unseen(double time_s) const;

 private:
  LaserConfig config_;
  SlowNoise power_, pointing_;
};

}  // namespace umov::plant
