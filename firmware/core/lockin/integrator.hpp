// Lock-in detection of two channels: exact integer sums over whole reference periods.
#pragma once

#include <cstdint>
#include <span>

#include "firmware/core/integer/wide.hpp"
#include "firmware/core/lockin/reference.hpp"

namespace umov::firmware {

/// Sums of a record, in codes x sine. Standard errors are those of the sums, from the scatter of
/// the blocks.
struct LockinResult {
  std::uint32_t samples = 0;
  std::uint32_t saturated = 0;
  std::int64_t signal_x = 0;
  std::int64_t signal_y = 0;
  std::int64_t monitor_x = 0;
  std::int64_t monitor_y = 0;
  std::uint64_t signal_x_se = 0;
  std::uint64_t signal_y_se = 0;
  std::uint64_t monitor_se = 0;
};

/// Sum and sum of squares of block sums.
class BlockScatter {
 public:
  constexpr void add(std::int64_t block) {
    sum_ += block;
    const std::uint64_t size = static_cast<std::uint64_t>(block < 0 ? -block : block);
    squares_ = squares_ + multiply(size, size);
    ++blocks_;
  }
  constexpr std::int64_t sum() const { return sum_; }
  /// sqrt((b Σx² - (Σx)²) / (b - 1)) = sqrt(b) x standard deviation of a block, rounded down.
  std::uint64_t standard_error() const;

 private:
  std::int64_t sum_ = 0;
  Uint128 squares_{};
  std::uint32_t blocks_ = 0;
};

/// What does not change during a record.
struct Detection {
  Reference reference{};
  std::uint8_t harmonic = 1;
  std::uint32_t phase_offset = 0;  ///< 2^-32 turns, added to the phase of the harmonic
};

/// One record. Exact for blocks of up to 2^25 samples.
class Integrator {
 public:
  /// `first_sample`: index in the sampled stream at which integration begins.
  void begin(const Detection& detection, const RecordPlan& plan, std::uint64_t first_sample);
  /// Takes samples from the front of both channels (equal lengths) until the record is complete;
  /// returns how many were taken.
  std::uint32_t take(std::span<const std::uint16_t> signal, std::span<const std::uint16_t> monitor);
  bool complete() const { return blocks_done_ == plan_.blocks; }
  LockinResult result() const;
  /// Clipped samples of the signal so far.
  std::uint32_t signal_saturated() const { return signal_saturated_; }

 private:
  /// Sums of the block being taken, in codes x fine sine: 2^11 x 2^26 x 2^25 samples fit 63 bits.
  struct Block {
    std::int64_t signal_x = 0, signal_y = 0, monitor_x = 0, monitor_y = 0;
    std::int64_t signal = 0, monitor = 0, sine = 0, cosine = 0;
    std::uint32_t samples = 0;
  };

  void finish_block();

  RecordPlan plan_{};
  std::uint32_t step_ = 0;
  std::uint32_t phase_ = 0;
  Block block_{};
  BlockScatter signal_x_{}, signal_y_{}, monitor_x_{}, monitor_y_{};
  std::uint32_t blocks_done_ = 0;
  std::uint32_t signal_saturated_ = 0;
  std::uint32_t monitor_saturated_ = 0;
};

}  // namespace umov::firmware
