#include "firmware/core/lockin/acquisition.hpp"

#include <algorithm>

namespace umov::firmware {

void Acquisition::begin(const Detection& detection, const RecordPlan& plan, AutoRange& range) {
  range_ = &range;
  lead_in_ = lead_in_left_ = plan.lead_in;
  samples_ = plan.samples();
  peak_ = 0;
  clipped_ = false;
  integrator_.begin(detection, plan, plan.lead_in);
  outcome_.store(Outcome::running, std::memory_order_release);
}

bool Acquisition::finish(Outcome outcome) {
  outcome_.store(outcome, std::memory_order_release);
  return true;
}

bool Acquisition::take(std::span<const std::uint16_t> signal,
                       std::span<const std::uint16_t> monitor) {
  if (outcome() != Outcome::running) return true;
  if (lead_in_left_ > 0) {
    const auto count =
        static_cast<std::uint32_t>(std::min<std::size_t>(lead_in_left_, signal.size()));
    for (std::uint32_t i = 0; i < count; ++i) {
      const int code = signal[i];
      peak_ = std::max(peak_, code >= adc_middle ? code - adc_middle : adc_middle - code);
      clipped_ = clipped_ || code == 0 || code == adc_codes - 1;
    }
    lead_in_left_ -= count;
    if (lead_in_left_ > 0) return false;
    if (range_->judge_lead_in(peak_, clipped_)) return finish(Outcome::range_changed);
    signal = signal.subspan(count);
    monitor = monitor.subspan(count);
  }
  integrator_.take(signal, monitor);
  if (integrator_.signal_saturated() > 0 && range_->step_down()) {
    return finish(Outcome::range_changed);
  }
  return integrator_.complete() ? finish(Outcome::complete) : false;
}

}  // namespace umov::firmware
