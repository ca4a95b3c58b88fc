#include "host/instrument/clock_sync.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/errors/error.hpp"

namespace umov::instrument {
namespace {

constexpr std::size_t kept_round_trips = 128;
/// Scatter of a round trip that was not held up: this share of the fastest, and a timer's grain.
constexpr double unhindered_share = 0.1;
constexpr double unhindered_us = 10.0;
/// Least spread (weighted standard deviation) of device time over which a rate is fitted.
constexpr double least_spread_us = 1e6;
/// Crystals agree within this; the uncertainty of the rate before it is fitted.
constexpr double rate_bound = 1e-4;

double difference(std::uint64_t a, std::uint64_t b) {
  return static_cast<double>(static_cast<std::int64_t>(a - b));
}

}  // namespace

void ClockSync::add(const RoundTrip& trip) {
  if (trip.host_received_us < trip.host_sent_us) return;
  if (trip.device_sent_us < trip.device_received_us) return;
  const std::uint64_t host_span = trip.host_received_us - trip.host_sent_us;
  const std::uint64_t device_span = trip.device_sent_us - trip.device_received_us;
  const Sample sample{trip.host_sent_us + host_span / 2, trip.device_received_us + device_span / 2,
                      std::max(0.0, difference(host_span, device_span))};
  samples_.push_back(sample);
  if (samples_.size() > kept_round_trips) samples_.pop_front();
  fit();
}

void ClockSync::fit() {
  fastest_us_ = std::numeric_limits<double>::infinity();
  for (const Sample& sample : samples_) fastest_us_ = std::min(fastest_us_, sample.round_trip_us);
  host_reference_us_ = samples_.back().host_us;
  device_reference_us_ = samples_.back().device_us;

  // visit(weight, host, device, round_trip), times from the references. A round trip that took
  // longer than the fastest was held up on one way; half of that is its error.
  const auto each = [&](auto&& visit) {
    for (const Sample& sample : samples_) {
      const double error_us = (sample.round_trip_us - fastest_us_) / 2.0 +
                              unhindered_share * fastest_us_ + unhindered_us;
      visit(1.0 / (error_us * error_us), difference(sample.host_us, host_reference_us_),
            difference(sample.device_us, device_reference_us_), sample.round_trip_us);
    }
  };
  double total = 0.0;
  double mean_host = 0.0;
  double mean_device = 0.0;
  double mean_round_trip_us = 0.0;
  each([&](double weight, double host, double device, double round_trip_us) {
    total += weight;
    mean_host += weight * host;
    mean_device += weight * device;
    mean_round_trip_us += weight * round_trip_us;
  });
  mean_host /= total;
  mean_device /= total;
  mean_round_trip_us /= total;

  double device_scatter = 0.0;
  double covariance = 0.0;
  each([&](double weight, double host, double device, double) {
    device_scatter += weight * (device - mean_device) * (device - mean_device);
    covariance += weight * (device - mean_device) * (host - mean_host);
  });
  const auto count = static_cast<double>(samples_.size());
  const bool fits_rate =
      count >= 3.0 && device_scatter >= total * least_spread_us * least_spread_us;
  rate_ = fits_rate ? covariance / device_scatter : 1.0;

  double chi_square = 0.0;
  each([&](double weight, double host, double device, double) {
    const double miss = host - mean_host - rate_ * (device - mean_device);
    chi_square += weight * miss * miss;
  });
  const double freedom = count - (fits_rate ? 2.0 : 1.0);
  // Delays are one-sided: that they happen to agree is no sign of precision.
  const double scale = freedom > 0.0 ? std::max(1.0, chi_square / freedom) : 1.0;
  offset_us_ = mean_host;
  device_mean_us_ = mean_device;
  // All of a round trip may have been spent on the way there, or back: uniform between the two.
  offset_variance_us2_ = scale / total + mean_round_trip_us * mean_round_trip_us / 12.0;
  rate_variance_ = fits_rate ? scale / device_scatter : rate_bound * rate_bound / 3.0;
}

double ClockSync::host_time_us(double device_time_us) const {
  if (!ready()) {
    throw Error("the controller's clock has not been compared with the host's",
                "synchronise the clock first");
  }
  const double device = device_time_us - static_cast<double>(device_reference_us_);
  return static_cast<double>(host_reference_us_) + offset_us_ + rate_ * (device - device_mean_us_);
}

double ClockSync::uncertainty_us(double device_time_us) const {
  const double distance =
      device_time_us - static_cast<double>(device_reference_us_) - device_mean_us_;
  return std::sqrt(offset_variance_us2_ + rate_variance_ * distance * distance);
}

}  // namespace umov::instrument
