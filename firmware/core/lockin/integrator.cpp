#include "firmware/core/lockin/integrator.hpp"

#include <algorithm>

#include "firmware/core/lockin/sine.hpp"

namespace umov::firmware {
namespace {

bool clipped(std::uint16_t code) {
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

void Integrator::begin(const Detection& detection, const RecordPlan& plan,
                       std::uint64_t first_sample) {
  plan_ = plan;
  step_ = detection.reference.phase_step * detection.harmonic;
  phase_ = static_cast<std::uint32_t>(first_sample) * step_ +
           detection.reference.half_spacing() * detection.harmonic + detection.phase_offset;
  block_ = {};
  signal_x_ = signal_y_ = monitor_x_ = monitor_y_ = {};
  blocks_done_ = 0;
  signal_saturated_ = 0;
  monitor_saturated_ = 0;
}

std::uint32_t Integrator::take(std::span<const std::uint16_t> signal,
                               std::span<const std::uint16_t> monitor) {
  std::uint32_t taken = 0;
  const auto available = static_cast<std::uint32_t>(signal.size());
  while (taken < available && !complete()) {
    const std::uint32_t count = std::min(available - taken, plan_.block_samples - block_.samples);
    Block b = block_;
    std::uint32_t phase = phase_;
    std::uint32_t signal_clipped = 0, monitor_clipped = 0;
    for (std::uint32_t i = taken; i < taken + count; ++i) {
      const std::int32_t sine = sine_of(phase);
      const std::int32_t cosine = sine_of(phase + quarter_turn);
      const std::int64_t s = signal[i] - adc_middle;
      const std::int64_t m = monitor[i] - adc_middle;
      b.signal_x += s * sine;
      b.signal_y += s * cosine;
      b.monitor_x += m * sine;
      b.monitor_y += m * cosine;
      b.signal += s;
      b.monitor += m;
      b.sine += sine;
      b.cosine += cosine;
      signal_clipped += clipped(signal[i]) ? 1u : 0u;
      monitor_clipped += clipped(monitor[i]) ? 1u : 0u;
      phase += step_;
    }
    b.samples += count;
    block_ = b;
    phase_ = phase;
    signal_saturated_ += signal_clipped;
    monitor_saturated_ += monitor_clipped;
    taken += count;
    if (block_.samples == plan_.block_samples) finish_block();
  }
  return taken;
}

void Integrator::finish_block() {
  const Block& b = block_;
  signal_x_.add(from_fine(b.signal_x - level_part(b.signal, b.sine, b.samples)));
  signal_y_.add(from_fine(b.signal_y - level_part(b.signal, b.cosine, b.samples)));
  monitor_x_.add(from_fine(b.monitor_x - level_part(b.monitor, b.sine, b.samples)));
  monitor_y_.add(from_fine(b.monitor_y - level_part(b.monitor, b.cosine, b.samples)));
  block_ = {};
  ++blocks_done_;
}

LockinResult Integrator::result() const {
  return {.samples = plan_.samples(),
          .saturated = signal_saturated_ + monitor_saturated_,
          .signal_x = signal_x_.sum(),
          .signal_y = signal_y_.sum(),
          .monitor_x = monitor_x_.sum(),
          .monitor_y = monitor_y_.sum(),
          .signal_x_se = signal_x_.standard_error(),
          .signal_y_se = signal_y_.standard_error(),
          .monitor_se = monitor_x_.standard_error()};
}

}  // namespace umov::firmware
