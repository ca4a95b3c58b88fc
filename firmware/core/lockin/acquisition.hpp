// One measurement from the first sample to the sums: lead-in, range, integration.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "firmware/core/lockin/auto_range.hpp"
#include "firmware/core/lockin/integrator.hpp"

namespace umov::firmware {

/// Contexts: take() in the sample interrupt; begin() and result() in the main loop while not
/// running.
class Acquisition {
 public:
  enum class Outcome : std::uint8_t { idle, running, complete, range_changed };

  void begin(const Detection& detection, const RecordPlan& plan, AutoRange& range);
  void cancel() { outcome_ = Outcome::idle; }
  /// Returns true when sampling has to stop: see outcome().
  bool take(std::span<const std::uint16_t> signal, std::span<const std::uint16_t> monitor);
  Outcome outcome() const { return outcome_.load(std::memory_order_acquire); }
  LockinResult result() const { return integrator_.result(); }
  /// Sample of the stream at the centre of the integration, times two.
  std::uint32_t twice_centre() const { return 2 * lead_in_ + samples_; }

 private:
  bool finish(Outcome outcome);

  Integrator integrator_{};
  AutoRange* range_ = nullptr;
  std::atomic<Outcome> outcome_{Outcome::idle};
  std::uint32_t lead_in_ = 0;
  std::uint32_t samples_ = 0;
  std::uint32_t lead_in_left_ = 0;
  int peak_ = 0;
  bool clipped_ = false;
};

}  // namespace umov::firmware
