// One measurement from the first sample to the sums: lead-in, range, integration.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "firmware/core/lockin/auto_range.hpp"
#include "firmware/core/lockin/integrator.hpp"
#include "firmware/core/lockin/period_integrator.hpp"
#include "firmware/core/lockin/reference_lock.hpp"

namespace umov::firmware {

/// Contexts: take() in the sample interrupt; begin() and result() in the main loop while not
/// running.
class Acquisition {
 public:
  enum class Outcome : std::uint8_t { idle, running, complete, range_changed, reference_lost };

  void begin(const Detection& detection, const RecordPlan& plan, AutoRange& range);
  /// Against an external reference that is locked and has been lost so often.
  void begin(const Detection& detection, const PeriodPlan& plan, AutoRange& range,
             std::uint32_t losses);
  /// Sample 0 of the stream is taken at this tick of the reference clock.
  void sampled_from(std::uint32_t tick) { first_tick_ = tick; }
  void cancel() { outcome_ = Outcome::idle; }
  /// Whether take() wants the phase of an external reference.
  bool external() const { return external_; }
  /// Returns true when sampling has to stop: see outcome(). `reference`: the lock of an external
  /// reference; others do without.
  bool take(std::span<const std::uint16_t> signal, std::span<const std::uint16_t> monitor,
            const ReferenceLock& reference);
  /// Of a complete record: whether its reference turned to its end. One that has stopped shows by
  /// no more than the edge that fails to come: until one comes after the last sample nobody knows,
  /// and when the lock is lost before that the outcome becomes `reference_lost`. In the main loop.
  bool confirmed(const ReferenceLock& reference);
  Outcome outcome() const { return outcome_.load(std::memory_order_acquire); }
  LockinResult result() const { return external_ ? periods_.result() : integrator_.result(); }
  /// Sample of the stream at the centre of the integration, times two.
  std::uint32_t twice_centre() const {
    return 2 * lead_in_ +
           (external_ ? 2 * periods_.skipped() + periods_.result().samples : samples_);
  }

 private:
  void begin(std::uint32_t lead_in, AutoRange& range, bool external);
  bool finish(Outcome outcome);
  bool lost(const ReferenceLock& reference) const {
    return external_ && (!reference.locked() || reference.losses() != losses_);
  }
  bool complete() const { return external_ ? periods_.complete() : integrator_.complete(); }
  bool saturated() const {
    return (external_ ? periods_.signal_saturated() : integrator_.signal_saturated()) > 0;
  }

  Integrator integrator_{};
  PeriodIntegrator periods_{};
  AutoRange* range_ = nullptr;
  std::atomic<Outcome> outcome_{Outcome::idle};
  bool external_ = false;
  std::uint32_t losses_ = 0;
  std::uint32_t first_tick_ = 0;
  std::uint32_t next_sample_ = 0;
  std::uint32_t lead_in_ = 0;
  std::uint32_t samples_ = 0;
  std::uint32_t lead_in_left_ = 0;
  int peak_ = 0;
  bool clipped_ = false;
};

}  // namespace umov::firmware
