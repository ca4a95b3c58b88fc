// What the pins of the emulated board are wired to. The plant implements it through an adapter that
// the program assembles; tests use small benches of their own.
#pragma once

#include <cstdint>
#include <limits>

namespace umov::mcu {

/// Switches of an axis as the bench has them; how they are wired to pins, the board knows.
struct AxisSwitches {
  bool home = false;
  bool lower_limit = false;
  bool upper_limit = false;
};

/// Codes of one instant, 0 to 4095.
struct CodePair {
  std::uint16_t signal = 2048;
  std::uint16_t monitor = 2048;
};

/// `time_s` is virtual time and never goes back. Axes are 0 incidence, 1 detector, 2 azimuth,
/// 3 polarizer, 4 analyzer, 5 filter.
class Bench {
 public:
  virtual ~Bench() = default;
  /// A rising edge of a step pin; direction +1 or -1.
  virtual void step(int axis, int direction, double time_s) = 0;
  virtual AxisSwitches switches(int axis) const = 0;
  virtual void set_laser(int laser, bool on, double time_s) = 0;
  virtual void set_shutter(bool open, double time_s) = 0;
  /// Amplifier range 0..3 = gain 1, 10, 100, 1000.
  virtual void set_gain(int range, double time_s) = 0;
  virtual bool interlock_closed() const = 0;
  /// Emergency button out; thermostats of drivers and lasers.
  virtual bool emergency_released() const { return true; }
  virtual bool overheated() const { return false; }
  /// The first rising edge at the reference input after `after_s`; infinite: none comes.
  virtual double next_reference_edge(double after_s) const {
    (void)after_s;
    return std::numeric_limits<double>::infinity();
  }
  /// Sample `number` of a stream that began at `start_time_s` with `sample_rate_hz`; `light`: level
  /// of the modulation output at that instant.
  virtual CodePair sample(double start_time_s, double sample_rate_hz, std::uint64_t number,
                          bool light) = 0;
};

}  // namespace umov::mcu
