#include "firmware/core/lockin/record_sums.hpp"

#include "firmware/core/config/design_parameters.hpp"
#include "firmware/core/lockin/sine.hpp"

namespace umov::firmware {
namespace {

bool clips(std::uint16_t code) {
  return code == 0 || code == adc_codes - 1;
}

/// What a constant level leaves in a product sum because the rounded sine does not sum to exactly
/// 0.
std::int64_t level_part(std::int64_t level_sum, std::int64_t sine_sum, std::uint32_t samples) {
  const std::int64_t product = level_sum * sine_sum;
  const std::int64_t half = samples / 2;
  return (product + (product >= 0 ? half : -half)) / static_cast<std::int64_t>(samples);
}

}  // namespace

std::uint64_t BlockScatter::standard_error() const {
  if (blocks_ < 2) return 0;
  const std::uint64_t size = static_cast<std::uint64_t>(sum_ < 0 ? -sum_ : sum_);
  const Uint128 scatter = multiply(squares_, blocks_) - multiply(size, size);
  return square_root(divide(scatter, blocks_ - 1));
}

void BlockSums::take(std::span<const std::uint16_t> signal_codes,
                     std::span<const std::uint16_t> monitor_codes, std::uint32_t& phase,
                     std::uint32_t step, ClippedSamples& clipped) {
  BlockSums b = *this;
  std::uint32_t p = phase;
  std::uint32_t signal_clipped = 0, monitor_clipped = 0;
  for (std::size_t i = 0; i < signal_codes.size(); ++i) {
    const std::int32_t sin = sine_of(p);
    const std::int32_t cos = sine_of(p + quarter_turn);
    const std::int64_t s = signal_codes[i] - adc_middle;
    const std::int64_t m = monitor_codes[i] - adc_middle;
    b.signal_x += s * sin;
    b.signal_y += s * cos;
    b.monitor_x += m * sin;
    b.monitor_y += m * cos;
    b.signal += s;
    b.monitor += m;
    b.sine += sin;
    b.cosine += cos;
    signal_clipped += clips(signal_codes[i]) ? 1u : 0u;
    monitor_clipped += clips(monitor_codes[i]) ? 1u : 0u;
    p += step;
  }
  b.samples += static_cast<std::uint32_t>(signal_codes.size());
  *this = b;
  phase = p;
  clipped.signal += signal_clipped;
  clipped.monitor += monitor_clipped;
}

void RecordSums::add(const BlockSums& b) {
  signal_x_.add(from_fine(b.signal_x - level_part(b.signal, b.sine, b.samples)));
  signal_y_.add(from_fine(b.signal_y - level_part(b.signal, b.cosine, b.samples)));
  monitor_x_.add(from_fine(b.monitor_x - level_part(b.monitor, b.sine, b.samples)));
  monitor_y_.add(from_fine(b.monitor_y - level_part(b.monitor, b.cosine, b.samples)));
  ++blocks_;
}

LockinResult RecordSums::result() const {
  return {.signal_x = signal_x_.sum(),
          .signal_y = signal_y_.sum(),
          .monitor_x = monitor_x_.sum(),
          .monitor_y = monitor_y_.sum(),
          .signal_x_se = signal_x_.standard_error(),
          .signal_y_se = signal_y_.standard_error(),
          .monitor_se = monitor_x_.standard_error()};
}

}  // namespace umov::firmware
