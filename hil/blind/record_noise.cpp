#include "hil/blind/record_noise.hpp"

#include <cmath>
#include <cstddef>

namespace umov::blind {
namespace {

constexpr double jitter_interval = 128.0;  ///< samples over which the plant holds jitter: a period

}  // namespace

RecordNoise::RecordNoise(const plant::PlantConfig& config, const Acquisition& acquisition)
    : config_(config),
      samples_(acquisition.samples()),
      jitter_share2_(jitter_interval / acquisition.samples()) {}

double RecordNoise::jitter_share() const {
  return std::sqrt(jitter_share2_);
}

RecordVariance RecordNoise::of(int laser, const CleanRecord& record) const {
  const plant::AmplifierConfig& a = config_.amplifier;
  const double gain = std::pow(10.0, record.range);
  const double step_v = config_.adc.full_scale_v / 4096.0;
  const double quantisation = step_v * step_v / 12.0;
  const double electronics =
      a.output_noise_v * a.output_noise_v + std::pow(gain * a.input_noise_v, 2.0) + quantisation;
  const double signal2 = record.x_v * record.x_v + record.y_v * record.y_v;
  // Light is on during half of the samples.
  const double shot = 0.5 * config_.detector.shot_noise_v * std::sqrt(signal2);
  const double additive = 2.0 / samples_ * (electronics / (gain * gain) + shot);
  const double jitter = config_.laser[static_cast<std::size_t>(laser)].jitter;
  double monitor = 0.0;
  if (record.monitor_v > 0.0) {
    monitor = 2.0 / samples_ * (config_.monitor.noise_v * config_.monitor.noise_v + quantisation) /
              (record.monitor_v * record.monitor_v);
  }
  const double phase = optics::radians(config_.modulation.jitter_deg);
  return {additive + (jitter * jitter * jitter_share2_ + monitor) * signal2,
          additive + phase * phase * jitter_share2_ * signal2};
}

}  // namespace umov::blind
