// One small bench for both boards: stages that count steps, and a signal with noise that depends on
// nothing but the number of the stream and the sample.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>

#include "boards/native/world.hpp"
#include "hil/mcu/board/bench.hpp"
#include "tests/unit/outside_reference.hpp"

namespace umov::test {

struct NoisyStages {
  struct Switches {
    bool home, lower_limit, upper_limit;
  };
  Switches switches(int axis) const {
    const std::int32_t at = position[static_cast<std::size_t>(axis)];
    return {at < 0, at <= lower, at >= upper || axis == upper_closed};
  }
  mcu::CodePair codes_of(std::uint64_t number, bool light, double time_s) {
    if (number == 0) ++streams;
    if (reference) return chopped_codes(number, light ? reference->light(time_s) : -1.0);
    std::uint64_t x = (streams << 32 | number) * 0x9E37'79B9'7F4A'7C15ull;
    x ^= x >> 29;
    x *= 0xBF58'476D'1CE4'E5B9ull;
    x ^= x >> 32;
    const int noise = static_cast<int>(x & 63u) - 32, other = static_cast<int>(x >> 8 & 15u) - 8;
    const int height = shutter ? (lasers[1] ? 500 : 150) * (1 << 2 * gain) : 0;
    const auto code = [](int v) {
      return static_cast<std::uint16_t>(std::clamp(2048 + v, 0, 4095));
    };
    return {code((light ? height : -height) + noise), code((light ? 900 : -900) + other)};
  }

  double next_reference_edge(double after_s) const {
    return reference ? reference->next_edge_s(after_s) : std::numeric_limits<double>::infinity();
  }

  /// Chops the light of all samples.
  std::optional<OutsideReference> reference;
  std::array<std::int32_t, 6> position{100, 1500, -300, 2000, -40, 0};
  std::int32_t lower = -2'000'000, upper = 2'000'000;
  std::array<bool, 3> lasers{};
  bool shutter = false;
  bool interlock = true, button_out = true, hot = false, supply_low = false;
  int upper_closed = -1;  ///< axis whose upper limit switch somebody holds closed
  int stalled = -1;       ///< axis whose driver reports lost steps
  bool dark() const { return !shutter && !lasers[0] && !lasers[1] && !lasers[2]; }
  int gain = 0;
  std::uint64_t streams = 0;

 private:
  /// Dithered by a sequence without a period, so that quantisation is none either.
  static mcu::CodePair chopped_codes(std::uint64_t number, double light) {
    const double dither = std::fmod(0.618033988749895 * static_cast<double>(number), 1.0) - 0.5;
    const auto code = [&](double height) {
      return static_cast<std::uint16_t>(std::lround(2048 + height * light + dither));
    };
    return {code(1800), code(900)};
  }
};

/// The stages as the native board drives them.
class NoisyWorld final : public boards::native::World {
 public:
  void step(int axis, int direction, double) override {
    stages.position[static_cast<std::size_t>(axis)] += direction;
  }
  boards::native::AxisSwitches switches(int axis) const override {
    const auto s = stages.switches(axis);
    return {s.home, s.lower_limit, s.upper_limit};
  }
  void set_laser(int laser, bool on, double time_s) override {
    stages.lasers[static_cast<std::size_t>(laser)] = on;
    if (!on) went_dark_s = time_s;
  }
  void set_shutter(bool open, double time_s) override {
    stages.shutter = open;
    if (!open) went_dark_s = time_s;
  }
  void set_gain(int range, double) override { stages.gain = range; }
  bool interlock_closed() const override { return stages.interlock; }
  bool emergency_released() const override { return stages.button_out; }
  bool overheated() const override { return stages.hot; }
  bool supply_low() const override { return stages.supply_low; }
  bool stalled(int axis) const override { return axis == stages.stalled; }
  void set_reference(std::uint32_t phase_step) override { step_per_sample_ = phase_step; }
  double next_reference_edge(double after_s) const override {
    return stages.next_reference_edge(after_s);
  }
  void sample(double start_time_s, double sample_rate_hz, std::uint64_t first,
              std::span<std::uint16_t> signal, std::span<std::uint16_t> monitor) override {
    for (std::size_t i = 0; i < signal.size(); ++i) {
      const bool light = static_cast<std::uint32_t>((first + i) * step_per_sample_) < 0x8000'0000u;
      const double time_s = start_time_s + static_cast<double>(first + i) / sample_rate_hz;
      const mcu::CodePair codes = stages.codes_of(first + i, light, time_s);
      signal[i] = codes.signal;
      monitor[i] = codes.monitor;
    }
  }
  NoisyStages stages;
  double went_dark_s = 0;  ///< the last time something was switched off

 private:
  std::uint32_t step_per_sample_ = 0;
};

/// And as the emulated board's connectors do.
class NoisyBench final : public mcu::Bench {
 public:
  void step(int axis, int direction, double) override {
    stages.position[static_cast<std::size_t>(axis)] += direction;
  }
  mcu::AxisSwitches switches(int axis) const override {
    const auto s = stages.switches(axis);
    return {s.home, s.lower_limit, s.upper_limit};
  }
  void set_laser(int laser, bool on, double time_s) override {
    stages.lasers[static_cast<std::size_t>(laser)] = on;
    if (!on) went_dark_s = time_s;
  }
  void set_shutter(bool open, double time_s) override {
    stages.shutter = open;
    if (!open) went_dark_s = time_s;
  }
  void set_gain(int range, double) override { stages.gain = range; }
  bool interlock_closed() const override { return stages.interlock; }
  bool emergency_released() const override { return stages.button_out; }
  bool overheated() const override { return stages.hot; }
  double next_reference_edge(double after_s) const override {
    return stages.next_reference_edge(after_s);
  }
  mcu::CodePair sample(double start_time_s, double sample_rate_hz, std::uint64_t number,
                       bool light) override {
    return stages.codes_of(number, light,
                           start_time_s + static_cast<double>(number) / sample_rate_hz);
  }
  bool dark() const { return stages.dark(); }
  NoisyStages stages;
  double went_dark_s = 0;  ///< the last time something was switched off
};

}  // namespace umov::test
