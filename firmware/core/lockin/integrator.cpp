#include "firmware/core/lockin/integrator.hpp"

#include <algorithm>

namespace umov::firmware {

void Integrator::begin(const Detection& detection, const RecordPlan& plan,
                       std::uint64_t first_sample) {
  plan_ = plan;
  step_ = detection.reference.phase_step * detection.harmonic;
  phase_ = static_cast<std::uint32_t>(first_sample) * step_ +
           detection.reference.half_spacing() * detection.harmonic + detection.phase_offset;
  block_ = {};
  sums_ = {};
  clipped_ = {};
}

std::uint32_t Integrator::take(std::span<const std::uint16_t> signal,
                               std::span<const std::uint16_t> monitor) {
  std::uint32_t taken = 0;
  const auto available = static_cast<std::uint32_t>(signal.size());
  while (taken < available && !complete()) {
    const std::uint32_t count = std::min(available - taken, plan_.block_samples - block_.samples);
    block_.take(signal.subspan(taken, count), monitor.subspan(taken, count), phase_, step_,
                clipped_);
    taken += count;
    if (block_.samples == plan_.block_samples) {
      sums_.add(block_);
      block_ = {};
    }
  }
  return taken;
}

LockinResult Integrator::result() const {
  LockinResult result = sums_.result();
  result.samples = plan_.samples();
  result.saturated = clipped_.signal + clipped_.monitor;
  return result;
}

}  // namespace umov::firmware
