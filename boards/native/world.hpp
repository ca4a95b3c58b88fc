// What the pins of the native board are wired to. The plant implements it through an adapter that
// the program assembles; tests use small worlds of their own.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

namespace umov::boards::native {

/// Switches of an axis as seen by its inputs.
struct AxisSwitches {
  bool home = false;
  bool lower_limit = false;
  bool upper_limit = false;
};

/// The physical side of the board. `time_s` is virtual time and never goes back.
/// Axes are 0 incidence, 1 detector, 2 azimuth, 3 polarizer, 4 analyzer, 5 filter.
class World {
 public:
  virtual ~World() = default;
  /// One step pulse on an axis; direction +1 or -1.
  virtual void step(int axis, int direction, double time_s) = 0;
  virtual AxisSwitches switches(int axis) const = 0;
  /// Laser enables 0..2 as commanded; the interlock cuts them in hardware whatever is commanded.
  virtual void set_laser(int laser, bool on, double time_s) = 0;
  virtual void set_shutter(bool open, double time_s) = 0;
  /// Amplifier range 0..3 = gain 1, 10, 100, 1000.
  virtual void set_gain(int range, double time_s) = 0;
  virtual bool interlock_closed() const = 0;
  /// Emergency button out; thermostats of drivers and lasers; supply voltage; a driver's stall
  /// line.
  virtual bool emergency_released() const { return true; }
  virtual bool overheated() const { return false; }
  virtual bool supply_low() const { return false; }
  virtual bool stalled(int) const { return false; }
  /// Modulation output: a square wave, high while phase < 2^31; phase(n) = n * phase_step (mod
  /// 2^32) at sample n counted from the start of sampling; phase_step = f / f_sample * 2^32.
  virtual void set_reference(std::uint32_t phase_step) = 0;
  /// The first rising edge at the reference input after `after_s`; infinite: none comes.
  virtual double next_reference_edge(double after_s) const {
    (void)after_s;
    return std::numeric_limits<double>::infinity();
  }
  /// ADC codes of the two channels for samples first .. first + n - 1 of the stream that began at
  /// start_time_s with `sample_rate_hz`; both spans have length n; codes 0 .. 4095, mid-scale 2048.
  virtual void sample(double start_time_s, double sample_rate_hz, std::uint64_t first,
                      std::span<std::uint16_t> signal, std::span<std::uint16_t> monitor) = 0;
};

}  // namespace umov::boards::native
