// A light chopper with a drive of its own: edges of its photo-interrupter, light that it lets pass.
#pragma once

#include <cstdint>

#include "hil/plant/plant_config.hpp"

namespace umov::plant {

/// Its phase is f (t + w P / 2π (1 - cos(2π t / P))): a frequency f that swings by w in the period
/// P. The light follows that phase; the edges jitter about it, each by the number of its turn.
class Chopper {
 public:
  Chopper(const ChopperConfig& config, std::uint64_t key) : config_(config), key_(key) {}

  /// Whether it is in the beam.
  bool present() const { return config_.frequency_hz > 0; }
  /// Turns since the instrument was switched on, of the edges without jitter.
  double turns(double time_s) const;
  /// The first rising edge after `after_s`, seconds; infinite when none comes.
  double next_edge_s(double after_s) const;
  /// -1 (blocked) to 1 (open), `ahead` turns after the moment: a trapezium, whose slopes are the
  /// blade's edge crossing the beam.
  double opening(double time_s, double ahead = 0.0) const;
  /// Fundamental of opening() over that of a square wave.
  double fundamental() const;

 private:
  double moment_of(double turns) const;
  double edge_s(std::uint64_t number) const;

  ChopperConfig config_;
  std::uint64_t key_;
};

}  // namespace umov::plant
