// An operator at the emulated instrument: turns axes to angles, switches light on, demodulates in
// double precision.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "hil/plant/plant.hpp"
#include "hil/plant/sample_catalog.hpp"

namespace umov::plant::test {

inline constexpr double sample_rate_hz = 100e3;
inline constexpr double open = std::numeric_limits<double>::quiet_NaN();

/// Lock-in result in volts at range 1.
struct LockinResult {
  double x_v = 0.0, y_v = 0.0, monitor_v = 0.0;
  int clipped = 0;
};

class Bench {
 public:
  Bench(PlantConfig config, std::shared_ptr<const Sample> sample, std::uint64_t seed = 7)
      : travel_(travel_from_zero()), plant_({std::move(config), travel_, std::move(sample), seed}) {
    plant_.set_reference(reference(1000.0));
    plant_.set_shutter(true, time_s_);
    wait(1.0);
  }
  Bench(PlantConfig config, const std::string& sample, std::uint64_t seed = 7)
      : Bench(std::move(config), std::shared_ptr<const Sample>(make_sample(sample)), seed) {}

  /// Rounded up, so that an edge which falls on a sample is met by it.
  static std::uint32_t reference(double frequency_hz) {
    return static_cast<std::uint32_t>(std::ceil(frequency_hz / sample_rate_hz * 0x1p32));
  }

  Plant& plant() { return plant_; }
  double time_s() const { return time_s_; }
  void wait(double seconds) { time_s_ += seconds; }

  /// Turns the motor of an axis to the step nearest to the angle.
  void turn(int axis, double angle_deg) {
    const auto a = static_cast<std::size_t>(axis);
    const std::int64_t target = std::llround(angle_deg / 360.0 * travel_[a].steps_per_turn);
    while (steps_[a] != target) {
      const int direction = target > steps_[a] ? 1 : -1;
      plant_.step(axis, direction, time_s_);
      steps_[a] += direction;
    }
  }
  /// Comes from below or above, so that play is taken up in that sense.
  void arrive(int axis, double angle_deg, int direction) {
    turn(axis, angle_deg - 2.0 * direction);
    turn(axis, angle_deg);
  }
  void geometry(double theta_i_deg, double theta_r_deg, double phi_deg = 0.0) {
    turn(0, theta_i_deg);
    turn(1, theta_r_deg);
    turn(2, phi_deg);
  }
  /// Axes from p towards s; `open` takes the element out.
  void polarization(double polarizer_deg, double analyzer_deg) {
    turn(3, std::isnan(polarizer_deg) ? 200.0 : polarizer_deg);
    turn(4, std::isnan(analyzer_deg) ? 200.0 : analyzer_deg);
  }
  void optical_density(int density) { turn(5, 60.0 * density); }
  /// Only laser 0, 1 or 2; -1 for none.
  void laser(int which) {
    for (int i = 0; i < laser_count; ++i) plant_.set_laser(i, i == which, time_s_);
  }
  void gain(int range) {
    range_ = range;
    plant_.set_gain(range, time_s_);
  }

  /// Integrates whole periods of 1 kHz from now on. Blocks of `block` samples.
  LockinResult measure(int periods = 50, std::size_t block = 250) {
    const std::size_t samples = static_cast<std::size_t>(periods) * 100;
    std::vector<std::uint16_t> signal(samples), monitor(samples);
    for (std::size_t from = 0; from < samples; from += block) {
      const std::size_t count = std::min(block, samples - from);
      plant_.sample(time_s_, sample_rate_hz, from, std::span(signal).subspan(from, count),
                    std::span(monitor).subspan(from, count));
    }
    time_s_ += static_cast<double>(samples) / sample_rate_hz;
    double x = 0.0, y = 0.0, m = 0.0;
    LockinResult result;
    for (std::size_t n = 0; n < samples; ++n) {
      // Sampled at phases k/100, high for k < 50, the square wave has its centre half a sample
      // early.
      const double phase = 2.0 * optics::pi * (static_cast<double>(n) + 0.5) / 100.0;
      x += (signal[n] - 2048.0) * std::sin(phase);
      y += (signal[n] - 2048.0) * std::cos(phase);
      m += (monitor[n] - 2048.0) * std::sin(phase);
      result.clipped +=
          signal[n] == 0 || signal[n] == 4095 || monitor[n] == 0 || monitor[n] == 4095;
    }
    // With the harmonics 99, 101, … that fold onto it, the fundamental 4/π becomes 4/(100
    // sin(π/100)).
    const double waveform = (optics::pi / 100.0) / std::sin(optics::pi / 100.0);
    const double scale = 2.0 / static_cast<double>(samples) * 3.3 / 4096.0 / waveform;
    const double nominal = std::array{1.0, 10.0, 100.0, 1000.0}[static_cast<std::size_t>(range_)];
    result.x_v = x * scale / nominal;
    result.y_v = y * scale / nominal;
    result.monitor_v = m * scale;
    return result;
  }

  /// Standard error that the stated white noise (and quantisation) gives x_v of `periods` periods.
  double standard_error(int periods = 50) const {
    const AmplifierConfig& a = plant_.config().amplifier;
    const double nominal = std::array{1.0, 10.0, 100.0, 1000.0}[static_cast<std::size_t>(range_)];
    const double step_v = 3.3 / 4096.0;
    const double variance = a.output_noise_v * a.output_noise_v + step_v * step_v / 12.0 +
                            std::pow(nominal * a.input_noise_v, 2.0);
    return std::sqrt(2.0 * variance / (100.0 * periods)) / nominal;
  }
  double monitor_error(int periods = 50) const {
    const double step_v = 3.3 / 4096.0;
    const double noise = plant_.config().monitor.noise_v;
    return std::sqrt(2.0 * (noise * noise + step_v * step_v / 12.0) / (100.0 * periods));
  }

 private:
  static std::array<AxisTravel, axis_count> travel_from_zero() {
    auto travel = reference_travel();
    for (AxisTravel& t : travel) t.start_deg = 0.0;
    return travel;
  }

  std::array<AxisTravel, axis_count> travel_;
  Plant plant_;
  std::array<std::int64_t, axis_count> steps_{};
  double time_s_ = 10.0;
  int range_ = 0;
};

}  // namespace umov::plant::test
