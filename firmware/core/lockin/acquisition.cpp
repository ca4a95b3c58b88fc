#include "firmware/core/lockin/acquisition.hpp"

#include <algorithm>

namespace umov::firmware {

void Acquisition::begin(std::uint32_t lead_in, AutoRange& range, bool external) {
  range_ = &range;
  external_ = external;
  lead_in_ = lead_in_left_ = lead_in;
  next_sample_ = 0;
  peak_ = 0;
  clipped_ = false;
}

void Acquisition::begin(const Detection& detection, const RecordPlan& plan, AutoRange& range) {
  begin(plan.lead_in, range, false);
  samples_ = plan.samples();
  integrator_.begin(detection, plan, plan.lead_in);
  outcome_.store(Outcome::running, std::memory_order_release);
}

void Acquisition::begin(const Detection& detection, const PeriodPlan& plan, AutoRange& range,
                        std::uint32_t losses) {
  begin(plan.lead_in, range, true);
  losses_ = losses;
  periods_.begin(detection, plan);
  outcome_.store(Outcome::running, std::memory_order_release);
}

bool Acquisition::finish(Outcome outcome) {
  outcome_.store(outcome, std::memory_order_release);
  return true;
}

bool Acquisition::take(std::span<const std::uint16_t> signal,
                       std::span<const std::uint16_t> monitor, const ReferenceLock& reference) {
  if (outcome() != Outcome::running) return true;
  if (lost(reference)) return finish(Outcome::reference_lost);
  if (lead_in_left_ > 0) {
    const auto count =
        static_cast<std::uint32_t>(std::min<std::size_t>(lead_in_left_, signal.size()));
    for (std::uint32_t i = 0; i < count; ++i) {
      const int code = signal[i];
      peak_ = std::max(peak_, code >= adc_middle ? code - adc_middle : adc_middle - code);
      clipped_ = clipped_ || code == 0 || code == adc_codes - 1;
    }
    lead_in_left_ -= count;
    next_sample_ += count;
    if (lead_in_left_ > 0) return false;
    if (range_->judge_lead_in(peak_, clipped_)) return finish(Outcome::range_changed);
    signal = signal.subspan(count);
    monitor = monitor.subspan(count);
  }
  if (external_) {
    const PhaseLine& line = reference.line();
    const std::uint32_t tick = first_tick_ + next_sample_ * reference_ticks_per_sample;
    next_sample_ += periods_.take(signal, monitor, line.turns_at(tick), line.step_per_sample());
  } else {
    integrator_.take(signal, monitor);
  }
  if (saturated() && range_->step_down()) return finish(Outcome::range_changed);
  return complete() ? finish(Outcome::complete) : false;
}

bool Acquisition::confirmed(const ReferenceLock& reference) {
  if (!external_) return true;
  if (lost(reference)) {
    finish(Outcome::reference_lost);
    return false;
  }
  // Of the sample after the last one, which gives the slope where the record ends.
  const std::uint32_t end = first_tick_ + next_sample_ * reference_ticks_per_sample;
  return static_cast<std::int32_t>(reference.last_edge() - end) > 0;
}

}  // namespace umov::firmware
