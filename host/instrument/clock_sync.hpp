// Where the controller's clock stands against the host's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

namespace umov::instrument {

/// One round trip of time_sync, all in microseconds; sent and received as seen by each side.
struct RoundTrip {
  std::uint64_t host_sent_us = 0;
  std::uint64_t device_received_us = 0;
  std::uint64_t device_sent_us = 0;
  std::uint64_t host_received_us = 0;
};

/// Fits host time = offset + rate · device time to the round trips of the last minutes, each
/// weighted by how much slower than the fastest it was: a slow one was held up on one way or the
/// other, and nothing tells on which. The rate is fitted once the round trips spread over a few
/// seconds; before that both clocks are taken to run alike within 100 ppm.
class ClockSync {
 public:
  /// Adds a round trip; one that goes back in time is ignored.
  void add(const RoundTrip& round_trip);
  /// Forgets all, for a device that was restarted.
  void reset() { samples_.clear(); }

  bool ready() const { return !samples_.empty(); }
  /// Host clock at a device time, microseconds. Throws umov::Error before the first round trip.
  double host_time_us(double device_time_us) const;
  /// Standard uncertainty of host_time_us at that device time, microseconds: half the mean round
  /// trip, weighted, as a uniform bound on asymmetry, together with the scatter of the fit.
  double uncertainty_us(double device_time_us) const;
  /// Host seconds per device second.
  double rate() const { return rate_; }
  /// Fastest round trip seen among those kept, microseconds.
  double fastest_us() const { return fastest_us_; }
  std::size_t round_trips() const { return samples_.size(); }

 private:
  struct Sample {
    std::uint64_t host_us;    ///< middle of the round trip
    std::uint64_t device_us;  ///< middle of the device's stay
    double round_trip_us;     ///< on the wire, both ways
  };
  void fit();

  std::deque<Sample> samples_;
  std::uint64_t host_reference_us_ = 0;
  std::uint64_t device_reference_us_ = 0;
  double offset_us_ = 0.0;  ///< of host against device, both from their references
  double rate_ = 1.0;
  double fastest_us_ = 0.0;
  double device_mean_us_ = 0.0;  ///< of the fitted samples, from the reference
  double offset_variance_us2_ = 0.0;
  double rate_variance_ = 0.0;
};

}  // namespace umov::instrument
