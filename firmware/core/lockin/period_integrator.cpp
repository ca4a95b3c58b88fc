#include "firmware/core/lockin/period_integrator.hpp"

#include <algorithm>

#include "firmware/core/lockin/sine.hpp"

namespace umov::firmware {
namespace {

constexpr unsigned share_bits = 16;
constexpr std::uint32_t whole_sample = 1u << share_bits;

/// value * to / from, to the nearest, halves away from zero.
std::int64_t rescaled(std::int64_t value, std::uint64_t to, std::uint64_t from) {
  const auto size = static_cast<std::uint64_t>(value < 0 ? -value : value);
  const auto scaled = static_cast<std::int64_t>(multiply_divide(size, to, from));
  return value < 0 ? -scaled : scaled;
}

/// The term of a sample, `share` (2^-16) of it to the block before and the rest to the block after.
/// `slope` per sample: the part before lies earlier, by half of what it leaves to the other.
void divide_term(std::int64_t term, std::int64_t slope, std::uint32_t share, std::int64_t& before,
                 std::int64_t& after) {
  const std::int64_t lever = std::int64_t{share} * (whole_sample - share) >> (share_bits + 1);
  const std::int64_t part = (term * std::int64_t{share} - slope * lever) >> share_bits;
  before += part;
  after += term - part;
}

}  // namespace

PeriodPlan plan_periods(std::uint32_t frequency_mhz, std::uint32_t dwell_ms,
                        std::uint32_t max_blocks) {
  const std::uint64_t wanted = (std::uint64_t{dwell_ms} * frequency_mhz + 500'000) / 1'000'000;
  const auto periods = static_cast<std::uint32_t>(std::max<std::uint64_t>(2, wanted));
  const std::uint32_t per_block = (periods + max_blocks - 1) / max_blocks;
  const auto one_period = static_cast<std::uint32_t>(
      (std::uint64_t{sample_rate_hz} * 1000 + frequency_mhz - 1) / frequency_mhz);
  constexpr std::uint32_t shortest_lead_in = 64;
  return {.lead_in = std::max(shortest_lead_in, one_period),
          .blocks = std::max<std::uint32_t>(2, periods / per_block),
          .block_periods = per_block};
}

void PeriodIntegrator::begin(const Detection& detection, const PeriodPlan& plan) {
  *this = {};
  plan_ = plan;
  harmonic_ = detection.harmonic;
  offset_ = detection.phase_offset;
}

std::uint32_t PeriodIntegrator::take(std::span<const std::uint16_t> signal,
                                     std::span<const std::uint16_t> monitor, std::uint64_t turns,
                                     std::uint32_t step) {
  constexpr std::uint64_t one_turn = std::uint64_t{1} << 32;
  if (!begun_) {
    end_ = (turns / one_turn + 1) * one_turn;
    begun_ = true;
  }
  const auto available = static_cast<std::uint32_t>(signal.size());
  std::uint32_t taken = 0;
  while (taken < available && !complete()) {
    const auto ahead = static_cast<std::int64_t>(end_ - turns);
    const std::int64_t room = ahead - step / 2;  // to the last sample that lies within the block
    if (divided_.waiting) {
      divide(signal[taken], monitor[taken]);
      continue;
    }
    if (room < 0) {
      const std::int64_t share = (ahead * whole_sample + step / 2) / step + whole_sample / 2;
      const std::uint16_t s = signal[taken], m = monitor[taken];
      divided_ = {
          .waiting = true,
          .signal_before = any_ ? last_signal_ : s,
          .monitor_before = any_ ? last_monitor_ : m,
          .signal = s,
          .monitor = m,
          .phase = phase_of(turns),
          .step = step * harmonic_,
          .share = static_cast<std::uint32_t>(std::clamp<std::int64_t>(share, 0, whole_sample))};
      end_ += std::uint64_t{plan_.block_periods} << 32;
      ++taken;
      turns += step;
      continue;
    }
    const auto within = static_cast<std::uint64_t>(room) / step + 1;
    const auto count =
        static_cast<std::uint32_t>(std::min<std::uint64_t>(within, available - taken));
    if (summing_) {
      std::uint32_t phase = phase_of(turns);
      block_.take(signal.subspan(taken, count), monitor.subspan(taken, count), phase,
                  step * harmonic_, clipped_);
    } else {
      skipped_ += count;
    }
    taken += count;
    turns += std::uint64_t{count} * step;
    any_ = true;
    last_signal_ = signal[taken - 1];
    last_monitor_ = monitor[taken - 1];
  }
  return taken;
}

/// Change of the products from sample to sample: of the signal by its neighbours, of sine and
/// cosine by each other.
BlockSums PeriodIntegrator::slope_at(const Divided& d, std::uint16_t signal_after,
                                     std::uint16_t monitor_after) const {
  const std::int64_t sine = sine_of(d.phase), cosine = sine_of(d.phase + quarter_turn);
  // 2 pi steps in 2^-16 radians.
  constexpr std::uint64_t radians_a_turn = 411'775;
  const auto turn = static_cast<std::int64_t>(radians_a_turn * d.step >> 32);
  const std::int64_t sine_slope = cosine * turn >> share_bits;
  const std::int64_t cosine_slope = -sine * turn >> share_bits;
  const std::int64_t s = d.signal - adc_middle, m = d.monitor - adc_middle;
  const std::int64_t s_twice = signal_after - d.signal_before;
  const std::int64_t m_twice = monitor_after - d.monitor_before;
  return {.signal_x = s_twice * sine / 2 + s * sine_slope,
          .signal_y = s_twice * cosine / 2 + s * cosine_slope,
          .monitor_x = m_twice * sine / 2 + m * sine_slope,
          .monitor_y = m_twice * cosine / 2 + m * cosine_slope,
          .signal = s_twice / 2,
          .monitor = m_twice / 2,
          .sine = sine_slope,
          .cosine = cosine_slope};
}

void PeriodIntegrator::divide(std::uint16_t signal_after, std::uint16_t monitor_after) {
  const Divided d = divided_;
  divided_.waiting = false;
  const BlockSums slope = slope_at(d, signal_after, monitor_after);
  BlockSums sample, next;
  std::uint32_t phase = d.phase;
  sample.take({&d.signal, 1}, {&d.monitor, 1}, phase, 0, clipped_);
  for (std::int64_t BlockSums::*const sum :
       {&BlockSums::signal_x, &BlockSums::signal_y, &BlockSums::monitor_x, &BlockSums::monitor_y,
        &BlockSums::signal, &BlockSums::monitor, &BlockSums::sine, &BlockSums::cosine}) {
    divide_term(sample.*sum, slope.*sum, d.share, block_.*sum, next.*sum);
  }
  if (summing_) end_block(d.share);
  summing_ = true;
  block_ = next;
  begin_share_ = whole_sample - d.share;
  any_ = true;
  last_signal_ = d.signal;
  last_monitor_ = d.monitor;
}

void PeriodIntegrator::end_block(std::uint32_t share) {
  const std::uint64_t lasted = (std::uint64_t{block_.samples} << share_bits) + begin_share_ + share;
  block_.samples = static_cast<std::uint32_t>((lasted + whole_sample / 2) >> share_bits);
  duration_ += lasted;
  sums_.add(block_);
}

LockinResult PeriodIntegrator::result() const {
  LockinResult result = sums_.result();
  result.samples = static_cast<std::uint32_t>((duration_ + whole_sample / 2) >> share_bits);
  result.saturated = clipped_.signal + clipped_.monitor;
  if (duration_ == 0) return result;
  const std::uint64_t whole = std::uint64_t{result.samples} << share_bits;
  for (std::int64_t* sum :
       {&result.signal_x, &result.signal_y, &result.monitor_x, &result.monitor_y}) {
    *sum = rescaled(*sum, whole, duration_);
  }
  return result;
}

}  // namespace umov::firmware
