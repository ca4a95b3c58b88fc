// Lock-in detection of two channels: exact integer sums over whole periods of the modulation.
#pragma once

#include <cstdint>
#include <span>

#include "firmware/core/lockin/record_sums.hpp"
#include "firmware/core/lockin/reference.hpp"

namespace umov::firmware {

/// What does not change during a record.
struct Detection {
  Reference reference{};  ///< of the modulation output; an external reference has its own
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
  bool complete() const { return sums_.blocks() == plan_.blocks; }
  LockinResult result() const;
  /// Clipped samples of the signal so far.
  std::uint32_t signal_saturated() const { return clipped_.signal; }

 private:
  RecordPlan plan_{};
  std::uint32_t step_ = 0;
  std::uint32_t phase_ = 0;
  BlockSums block_{};
  RecordSums sums_{};
  ClippedSamples clipped_{};
};

}  // namespace umov::firmware
