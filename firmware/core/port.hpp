// What the core needs of a board. One implementation a board; the core knows no pin and no
// register.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace umov::firmware {

/// Switches of one axis as its inputs read them now.
struct AxisInputs {
  bool home = false;
  bool lower_limit = false;
  bool upper_limit = false;
};

/// The board's hardware as the core uses it. Every call must return at once.
///
/// Step timers: one a axis, counting at `step_timer_hz` (config/design_parameters.hpp). The core
/// starts a timer with the time to the first edge; at each edge the board calls
/// `Controller::on_step_timer(axis)`, which emits the step and returns the ticks from this edge to
/// the next, or 0 when the axis has come to rest. Intervals may exceed 16 bits: a board with short
/// timers counts overflows.
class Board {
 public:
  /// Device time since start, microseconds; never goes back.
  virtual std::uint64_t time_us() const = 0;
  /// Clock of the link's time-outs. On hardware the same as time_us(); a board that runs faster
  /// than real time gives wall time here, so that a host is given its seconds.
  virtual std::uint64_t link_time_us() const = 0;
  /// Bytes that fit the transmit buffer now. It should hold at least 2 KB: what the core says
  /// unasked leaves `reply_reserve_bytes` of it to replies.
  virtual std::size_t link_room() const = 0;
  /// Queues a whole frame for the host; false if it does not fit now (nothing is queued then).
  virtual bool write_link(std::span<const std::uint8_t> frame) = 0;

  virtual void set_direction(int axis, int direction) = 0;
  /// First edge of a move `ticks` from now.
  virtual void start_step_timer(int axis, std::uint32_t ticks) = 0;
  virtual void stop_step_timer(int axis) = 0;
  /// The step pulse; called from on_step_timer only. A board whose timer raises the pin itself
  /// leaves this empty.
  virtual void step(int axis) = 0;
  virtual AxisInputs switches(int axis) const = 0;

  /// laser 0 to 2.
  virtual void set_laser(int laser, bool on) = 0;
  virtual void set_shutter(bool open) = 0;
  /// range 0 to 3 = gain 1, 10, 100, 1000 of the signal channel.
  virtual void set_gain(int range) = 0;
  virtual bool interlock_closed() const = 0;
  /// The emergency stop's button is out.
  virtual bool emergency_released() const = 0;
  /// A thermostat on drivers or lasers has opened.
  virtual bool overheated() const = 0;
  /// The supply is about to fail: below what flash may be written at.
  virtual bool supply_low() const = 0;
  /// The driver of an axis reports lost steps at this moment.
  virtual bool stalled(int axis) const = 0;

  /// Starts sampling both channels at `sample_rate_hz`, first sample now, with the modulation's
  /// phase n * phase_step (mod 2^32) at sample n; the laser is on while that phase is below 2^31,
  /// so with step 0 always. Returns when sample 0 is taken, on the reference clock.
  virtual std::uint32_t start_sampling(std::uint32_t phase_step) = 0;
  virtual void stop_sampling() = 0;
  /// The reference clock now: counts at `reference_clock_hz`, modulo 2^32. At each rising edge of
  /// the reference input the board calls `Controller::on_reference_edge` with its tick, within
  /// 0.2 ms, from an interrupt that mask_interrupts() keeps out.
  virtual std::uint32_t reference_clock() const = 0;

  /// Keep all interrupts out for the few instructions in between. Not nested.
  virtual void mask_interrupts() = 0;
  virtual void unmask_interrupts() = 0;

 protected:
  Board() = default;
  Board(const Board&) = default;
  Board& operator=(const Board&) = default;
  ~Board() = default;  // never destroyed through the port: no heap
};

/// One latched fault as it is kept over resets.
struct LoggedFault {
  std::uint64_t time_us = 0;
  std::uint32_t boot_id = 0;
  std::uint8_t fault = 0;
  std::int32_t detail = -1;
};

/// Fault log that survives a reset (flash on hardware).
class PersistentLog {
 public:
  virtual void append(const LoggedFault& entry) = 0;
  virtual std::uint16_t count() const = 0;
  /// index 0 = newest; false if there is no such entry.
  virtual bool read(std::uint16_t index, LoggedFault& entry) const = 0;

 protected:
  PersistentLog() = default;
  PersistentLog(const PersistentLog&) = default;
  PersistentLog& operator=(const PersistentLog&) = default;
  ~PersistentLog() = default;
};

/// Settings that survive a reset (flash on hardware). Whoever saves them names their layout.
class SettingsStore {
 public:
  /// none: nothing was ever saved. damaged: what was saved last fails its check. other_layout: it
  /// is of firmware that keeps other settings.
  enum class Loaded : std::uint8_t { good, none, damaged, other_layout };
  /// Fills `settings` when the answer is good.
  virtual Loaded load(std::uint16_t layout, std::span<std::uint8_t> settings) const = 0;
  /// Returns when they are safe; false: those saved before stay.
  virtual bool save(std::uint16_t layout, std::span<const std::uint8_t> settings) = 0;
  /// The next saving may take half a second, in which the processor stands still.
  virtual bool next_save_is_slow() const = 0;

 protected:
  SettingsStore() = default;
  SettingsStore(const SettingsStore&) = default;
  SettingsStore& operator=(const SettingsStore&) = default;
  ~SettingsStore() = default;
};

/// Why the board started, as its reset flags tell.
enum class ResetCause : std::uint8_t { power_on, watchdog, brown_out, processor_fault };

/// Who this controller is; told to the host at the handshake.
struct Identity {
  std::array<char, 24> device_name{};
  std::array<char, 24> serial{};
  std::uint64_t firmware_hash = 0;
  /// Differs at every start.
  std::uint32_t boot_id = 0;
  ResetCause reset_cause = ResetCause::power_on;
  /// Where the program was, after a processor fault; -1: not known.
  std::int32_t reset_detail = -1;
};

}  // namespace umov::firmware
