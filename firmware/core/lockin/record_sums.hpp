// Sums of a lock-in record: of a block of samples, and of the blocks with their scatter.
#pragma once

#include <cstdint>
#include <span>

#include "firmware/core/integer/wide.hpp"

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

/// Clipped codes of both channels.
struct ClippedSamples {
  std::uint32_t signal = 0;
  std::uint32_t monitor = 0;
};

/// Sums of a block being taken, in codes x fine sine: 2^11 x 2^26 x 2^25 samples fit 63 bits.
struct BlockSums {
  std::int64_t signal_x = 0, signal_y = 0, monitor_x = 0, monitor_y = 0;
  std::int64_t signal = 0, monitor = 0, sine = 0, cosine = 0;
  std::uint32_t samples = 0;

  /// Samples of both channels (equal lengths), the first at `phase`, which ends up at the sample
  /// after the last; phase and step 2^-32 turns.
  void take(std::span<const std::uint16_t> signal_codes,
            std::span<const std::uint16_t> monitor_codes, std::uint32_t& phase, std::uint32_t step,
            ClippedSamples& clipped);
};

/// The blocks of a record. What a constant level leaves in a block's products, because the rounded
/// sine does not sum to exactly 0, is taken out.
class RecordSums {
 public:
  void add(const BlockSums& block);
  std::uint32_t blocks() const { return blocks_; }
  /// Everything but the numbers of samples.
  LockinResult result() const;

 private:
  BlockScatter signal_x_{}, signal_y_{}, monitor_x_{}, monitor_y_{};
  std::uint32_t blocks_ = 0;
};

}  // namespace umov::firmware
