#include "hil/plant/laser_power.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "hil/plant/noise.hpp"
#include "host/optics/angles.hpp"

namespace umov::plant {

SlowNoise::SlowNoise(std::uint64_t seed) {
  constexpr double low_hz = 1e-4;
  constexpr double high_hz = 20.0;
  for (std::size_t i = 0; i < tones; ++i) {
    const double place =
        (static_cast<double>(i) + uniform(random_bits(seed, 2 * i))) / static_cast<double>(tones);
    frequency_hz_[i] = low_hz * std::pow(high_hz / low_hz, place);
    phase_[i] = 2.0 * optics::pi * uniform(random_bits(seed, 2 * i + 1));
  }
}

double SlowNoise::at(double time_s) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < tones; ++i) {
    sum += std::sin(2.0 * optics::pi * frequency_hz_[i] * time_s + phase_[i]);
  }
  return std::sqrt(2.0 / tones) * sum;
}

LaserPower::LaserPower(const LaserConfig& config, std::uint64_t seed)
    : config_(config), power_(derive_key(seed, 0)), pointing_(derive_key(seed, 1)) {}

double LaserPower::seen(double time_s) const {
  double relative = 1.0 + config_.power_drift_per_hour * time_s / 3600.0 -
                    config_.power_warmup * std::exp(-time_s / config_.warmup_tau_s);
  if (config_.power_noise != 0.0) relative += config_.power_noise * power_.at(time_s);
  return std::max(0.0, relative);
}

double LaserPower::unseen(double time_s) const {
  double relative = 1.0 + config_.drift_per_hour * time_s / 3600.0 -
                    config_.warmup * std::exp(-time_s / config_.warmup_tau_s);
  if (config_.unseen_noise != 0.0) relative += config_.unseen_noise * pointing_.at(time_s);
  return std::max(0.0, relative);
}

}  // namespace umov::plant
