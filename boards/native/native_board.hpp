// The firmware core as a process on the host: a board in virtual time whose pins end in a World.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "boards/native/ram_log.hpp"
#include "boards/native/ram_settings.hpp"
#include "boards/native/world.hpp"
#include "firmware/core/controller.hpp"

namespace umov::boards::native {

/// Choices at the start of a native board.
struct NativeBoardOptions {
  /// Serial number told at the handshake; cut to 24 bytes.
  std::string serial = "NATIVE-0001";
  /// Should differ at every start.
  std::uint32_t boot_id = 1;
  /// Clock of the heartbeat and of retransmissions, microseconds, never going back. Empty: virtual
  /// time. An emulator that runs faster than real time gives wall time, so that a host which is
  /// merely slower than virtual time is not taken for dead.
  std::function<std::uint64_t()> link_time_us;
  /// Why it starts.
  firmware::ResetCause reset_cause = firmware::ResetCause::power_on;
  /// Fault log kept over restarts; null: the board keeps its own, empty at start.
  std::shared_ptr<RamLog> log;
  /// Saved settings kept over restarts; null: the board keeps its own, empty at start.
  std::shared_ptr<RamSettings> settings{};
  /// ADC samples handed to the core at a time, like a DMA half-buffer.
  std::uint32_t samples_per_block = 250;
};

/// Runs the core against `world`, which must outlive the board. Deterministic: the same calls with
/// the same link clock give the same bytes. Not thread-safe.
class NativeBoard {
 public:
  explicit NativeBoard(World& world, NativeBoardOptions options = {});
  ~NativeBoard();
  NativeBoard(NativeBoard&&) noexcept;
  NativeBoard& operator=(NativeBoard&&) noexcept;

  /// Bytes from the host reach the core now, in virtual time.
  void deliver(std::span<const std::uint8_t> bytes);
  /// Appends all bytes for the host to `buffer` and forgets them; returns how many.
  std::size_t take_output(std::vector<std::uint8_t>& buffer);
  bool has_output() const;
  /// Lets virtual time pass.
  void run_for(std::uint64_t duration_us);
  /// Lets virtual time pass until there is output, at most `max_duration_us`; true if there is.
  bool run_until_output(std::uint64_t max_duration_us);
  /// Virtual time since the start.
  std::uint64_t now_us() const;
  /// True while nothing happens until the host says something: no move, no sampling, no timer but
  /// the tick. Running on then only lets time pass.
  bool resting() const;

  /// A hand controller at the instrument; see firmware::Controller.
  void jog(int axis, std::int32_t by_udeg);
  void stop_by_hand(bool emergency);
  firmware::HandView hand_view(int axis) const;

  /// The stall output of an axis' driver rises.
  void signal_stall(int axis);
  /// The ADC lost samples.
  void signal_adc_overrun();
  /// The processor stands still for so long while the world goes on: what was due meanwhile comes
  /// late, and a watchdog of 250 ms restarts it.
  void stand_still(std::uint64_t duration_us);
  /// The supply fails and comes back, or the watchdog bites: outputs fall, the core starts anew
  /// with its log, its boot id one higher. Time goes on.
  void reset(firmware::ResetCause cause);
  /// Step counter of an axis, as the core believes it.
  std::int32_t position_steps(int axis) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace umov::boards::native
