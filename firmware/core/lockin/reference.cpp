#include "firmware/core/lockin/reference.hpp"

#include <algorithm>

namespace umov::firmware {
namespace {

/// Longest repetition considered for frequencies above 100 Hz; lower ones take a period as it is.
constexpr std::uint32_t longest_repetition = 1000;
constexpr std::uint64_t millihertz = 1000;

std::uint32_t gcd(std::uint32_t a, std::uint32_t b) {
  while (b != 0) {
    const std::uint32_t rest = a % b;
    a = b;
    b = rest;
  }
  return a;
}

/// Deviation of periods/samples from the frequency asked for, relative, in 2^-32.
std::uint64_t deviation(std::uint32_t periods, std::uint32_t samples, std::uint32_t reference_mhz) {
  const std::uint64_t have = std::uint64_t{periods} * sample_rate_hz * millihertz;
  const std::uint64_t want = std::uint64_t{samples} * reference_mhz;
  const std::uint64_t off = have > want ? have - want : want - have;
  return (off << 20) / (want >> 12);
}

}  // namespace

Reference choose_reference(std::uint32_t reference_mhz) {
  constexpr std::uint64_t tolerance = (std::uint64_t{1} << 32) / 1000;
  const std::uint64_t rate_mhz = std::uint64_t{sample_rate_hz} * millihertz;
  Reference best{};
  std::uint64_t best_cost = UINT64_MAX;
  for (std::uint32_t periods = 1; periods <= longest_repetition / 2; ++periods) {
    const auto nearest =
        static_cast<std::uint32_t>((periods * rate_mhz + reference_mhz / 2) / reference_mhz);
    if (periods > 1 && nearest > longest_repetition) break;
    const std::uint32_t reach = nearest / 1000 + 1;
    for (std::uint32_t samples = nearest - std::min(reach, nearest - 2); samples <= nearest + reach;
         ++samples) {
      if (gcd(periods, samples) != 1) continue;
      const std::uint64_t off = deviation(periods, samples, reference_mhz);
      if (off > tolerance && best_cost != UINT64_MAX) continue;
      const std::uint64_t turns = std::uint64_t{periods} << 32;
      const std::uint64_t step = (turns + samples - 1) / samples;
      const std::uint64_t excess =
          ((step * samples - turns) << 20) / samples;  // 2^-20 of 2^-32 turn
      // Short repetitions give fine steps of dwell, small excess a steady edge, an even number of
      // samples equal halves of the square wave.
      std::uint64_t cost = 4 * excess + (std::uint64_t{samples} << 20) / 2048;
      if (samples % 2 != 0) cost += 1u << 19;
      if (off > tolerance) cost = UINT64_MAX - (UINT64_MAX >> 8) + off;
      if (cost < best_cost) {
        best_cost = cost;
        best = {periods, samples, static_cast<std::uint32_t>(step)};
      }
    }
  }
  return best;
}

RecordPlan plan_record(const Reference& reference, std::uint32_t dwell_ms,
                       std::uint32_t max_blocks) {
  const std::uint64_t wanted = std::uint64_t{dwell_ms} * sample_rate_hz / 1000;
  const auto repetitions = static_cast<std::uint32_t>(
      std::max<std::uint64_t>(2, (wanted + reference.samples / 2) / reference.samples));
  const std::uint32_t per_block = (repetitions + max_blocks - 1) / max_blocks;
  constexpr std::uint32_t shortest_lead_in = 64;
  return {.lead_in =
              reference.samples * ((shortest_lead_in + reference.samples - 1) / reference.samples),
          .blocks = std::max<std::uint32_t>(2, repetitions / per_block),
          .block_samples = per_block * reference.samples};
}

}  // namespace umov::firmware
