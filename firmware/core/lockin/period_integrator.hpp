// Lock-in detection of two channels against an external reference: sums over whole periods of it,
// which are no whole number of samples.
#pragma once

#include <cstdint>
#include <span>

#include "firmware/core/lockin/integrator.hpp"
#include "firmware/core/lockin/record_sums.hpp"

namespace umov::firmware {

/// A record: `blocks` blocks of `block_periods` periods, after `lead_in` samples that are looked at
/// for the range only and what is left of the period they end in.
struct PeriodPlan {
  std::uint32_t lead_in = 0;
  std::uint32_t blocks = 2;
  std::uint32_t block_periods = 1;
};

/// Record of about `dwell_ms` (at least two periods) in at most `max_blocks` equal blocks.
PeriodPlan plan_periods(std::uint32_t frequency_mhz, std::uint32_t dwell_ms,
                        std::uint32_t max_blocks);

/// One record. A sample stands for the time from half a sample before it to half a sample after:
/// the one in which a block ends is divided between that block and the next by their shares of that
/// time, to 2^-16, so that blocks last whole periods and no sample is counted twice or left out.
/// Within the sample that is divided what is summed goes as a straight line, whose slope is that of
/// its neighbours. Blocks of up to 2^25 samples.
class PeriodIntegrator {
 public:
  void begin(const Detection& detection, const PeriodPlan& plan);
  /// Takes samples from the front of both channels (equal lengths) until the record is complete;
  /// returns how many were taken. `turns`: phase of the reference at the first of them, `step`:
  /// from sample to sample, 2^-32 turns. From one call to the next the phase may be corrected by
  /// less than half a turn.
  std::uint32_t take(std::span<const std::uint16_t> signal, std::span<const std::uint16_t> monitor,
                     std::uint64_t turns, std::uint32_t step);
  bool complete() const { return sums_.blocks() == plan_.blocks; }
  /// Sums scaled to a whole number of samples, the one nearest to the time integrated.
  LockinResult result() const;
  /// Clipped samples of the signal so far.
  std::uint32_t signal_saturated() const { return clipped_.signal; }
  /// Samples before the first block.
  std::uint32_t skipped() const { return skipped_; }

 private:
  std::uint32_t phase_of(std::uint64_t turns) const {
    return static_cast<std::uint32_t>(turns) * harmonic_ + offset_;
  }
  /// The sample in which a block ends, until the one after it is there.
  struct Divided {
    bool waiting = false;
    std::uint16_t signal_before = 0, monitor_before = 0;
    std::uint16_t signal = 0, monitor = 0;
    std::uint32_t phase = 0;
    std::uint32_t step = 0;   ///< of the harmonic
    std::uint32_t share = 0;  ///< of the block that ends, 2^-16
  };
  BlockSums slope_at(const Divided& d, std::uint16_t signal_after,
                     std::uint16_t monitor_after) const;
  void divide(std::uint16_t signal_after, std::uint16_t monitor_after);
  void end_block(std::uint32_t share);

  PeriodPlan plan_{};
  std::uint32_t harmonic_ = 1;
  std::uint32_t offset_ = 0;
  bool begun_ = false;     ///< the first end of a period has been chosen
  bool summing_ = false;   ///< and passed
  std::uint64_t end_ = 0;  ///< of the block, 2^-32 turns
  BlockSums block_{};
  std::uint64_t begin_share_ = 0;  ///< of the sample that the block began in, 2^-16
  std::uint64_t duration_ = 0;     ///< of the blocks that are complete, 2^-16 samples
  RecordSums sums_{};
  ClippedSamples clipped_{};
  Divided divided_{};
  bool any_ = false;  ///< a sample has been taken: `last_…`
  std::uint16_t last_signal_ = 0, last_monitor_ = 0;
  std::uint32_t skipped_ = 0;
};

}  // namespace umov::firmware
