// A person at the emulated instrument, without the controller in between: sets axes, light and
// range for each row, and makes lock-in records from the ADC's codes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "hil/blind/scan_rows.hpp"
#include "hil/plant/plant.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::blind {

/// Timing and electronics of the acquisition. A period is 128 samples, so that the light's jitter,
/// which the plant holds over as many, is new in each.
struct Acquisition {
  int periods = 16;
  double sample_rate_hz = 100e3;
  double reference_hz = 781.25;
  int scatter_blocks = 8;  ///< of the integration, for standard errors; a divisor of the periods

  double dwell_s() const { return periods / reference_hz; }
  double samples() const { return dwell_s() * sample_rate_hz; }
  double arm_speed_deg_per_s = 40.0;
  double settle_s = 0.25;  ///< after every move, before integration
};

/// A record without noise and without the ADC.
struct CleanRecord {
  double x_v = 0.0, y_v = 0.0, monitor_v = 0.0;
  int range = 0;
};

/// Runs blocks one after the other on one Plant from `start_s` on.
class Bench {
 public:
  Bench(plant::PlantConfig config, std::shared_ptr<const plant::Sample> sample, std::uint64_t seed,
        const Acquisition& acquisition, double start_s = 0.0);

  /// What the lock-in would give without noise, quantisation and clipping.
  std::vector<CleanRecord> clean(std::span<const RowBlock> blocks);
  /// Records from ADC codes; indices and times go on from block to block.
  formats::ScanTable measure(std::span<const RowBlock> blocks);
  /// Virtual time at which the last record ended.
  double time_s() const { return time_s_; }

 private:
  void arrange(const RowBlock& block);
  void go_to(const Row& row);
  int choose_range(int range) const;
  void turn(int axis, double angle_deg, double speed_deg_per_s, double& longest_s);

  plant::Plant plant_;
  std::shared_ptr<const plant::Sample> sample_;
  Acquisition acquisition_;
  double time_s_;
  int range_ = 0;
  int direction_ = 1;
  int laser_ = -1;
  bool shutter_open_ = true;
  std::array<double, plant::axis_count> at_deg_{};
  std::array<double, plant::axis_count> steps_per_deg_{};
};

}  // namespace umov::blind
