// Modulation and how a record is cut into whole periods of it.
#pragma once

#include <cstdint>

#include "firmware/core/config/design_parameters.hpp"
#include "protocol/messages.hpp"

namespace umov::firmware {

/// The modulation: `periods` periods in exactly `samples` samples, for any ratio of the requested
/// frequency to the sample rate. The frequency is the one asked for within 0.1 %, moved to a ratio
/// of small numbers so that records hold whole periods and a fraction of a period cannot bias the
/// phase.
struct Reference {
  std::uint32_t periods = 1;
  std::uint32_t samples = 100;
  /// Phase per sample, rounded up. The excess over periods/samples (< 1/2^32 turn a sample) is the
  /// same in output and detection; over a record it shifts the sampled edges by nothing, because
  /// it stays far below 1/samples turn.
  std::uint32_t phase_step = 42'949'673;

  /// Half the spacing of the phases at which a period is sampled. A square wave that is sampled at
  /// phases k/samples and is high below half a turn has its centre that much early (by symmetry,
  /// for even and odd `samples`); detection is shifted by it so that Y is 0.
  constexpr std::uint32_t half_spacing() const {
    const std::uint32_t divisor = samples % 2 == 0 ? 2 * samples : 4 * samples;
    return static_cast<std::uint32_t>(((std::uint64_t{1} << 32) + divisor / 2) / divisor);
  }
};

/// Chooses the reference for a modulation of `reference_mhz` millihertz (10 Hz to 20 kHz).
Reference choose_reference(std::uint32_t reference_mhz);

/// A record: `blocks` blocks of `block_samples` samples, each of whole periods, after `lead_in`
/// samples that are looked at for the range only.
struct RecordPlan {
  std::uint32_t lead_in = 0;
  std::uint32_t blocks = 2;
  std::uint32_t block_samples = 0;

  constexpr std::uint32_t samples() const { return blocks * block_samples; }
};

/// Record of about `dwell_ms` (at least two repetitions of the reference) in at most `max_blocks`
/// equal blocks.
RecordPlan plan_record(const Reference& reference, std::uint32_t dwell_ms,
                       std::uint32_t max_blocks);

/// A harmonic must lie below half the sample rate.
constexpr bool detectable(std::uint32_t frequency_mhz, std::uint8_t harmonic) {
  return std::uint64_t{harmonic} * frequency_mhz < 500ull * sample_rate_hz;
}

/// Angle in 2^-32 turns, to the nearest.
constexpr std::uint32_t phase_from_udeg(std::int32_t angle_udeg) {
  const std::int64_t scaled = std::int64_t{angle_udeg} * (std::int64_t{1} << 32);
  const std::int64_t half = scaled >= 0 ? 180'000'000 : -180'000'000;
  return static_cast<std::uint32_t>((scaled + half) / 360'000'000);
}

}  // namespace umov::firmware
