// The reference controller as hardware: an emulated STM32F407 that runs the image that is flashed,
// wired by board.toml to a bench.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hil/mcu/board/bench.hpp"
#include "hil/mcu/stm32f407.hpp"
#include "hil/usbip/usb_function.hpp"

namespace umov::mcu {

/// Choices at the start of an emulated board.
struct McuBoardOptions {
  /// The image, umov-stm32f407.elf; empty: none, a board as it leaves the factory.
  std::string image;
  /// The boot loader, umov-stm32f407-boot.elf; empty: the chip goes straight to the image.
  std::string boot_loader{};
  ChipOptions chip{};
  /// Called at every rising edge of a step pin with the axis and the moment; may be empty.
  std::function<void(int axis, Time moment)> on_step{};
  /// Called when the pulse ends; may be empty.
  std::function<void(int axis, Time moment)> on_step_end{};
};

/// The same verbs as boards::native::NativeBoard. Deterministic. Not thread-safe. Every call that
/// lets time pass throws umov::Error where the program does what the emulation does not cover, for
/// instance touch an address without memory.
class McuBoard {
 public:
  /// Flashes the image and switches the supply on. `bench` must outlive the board.
  McuBoard(Bench& bench, McuBoardOptions options);
  ~McuBoard();

  /// Bytes from the host begin to arrive at the receive line.
  void deliver(std::span<const std::uint8_t> bytes);
  /// Appends all bytes the board has sent to `buffer` and forgets them; returns how many.
  std::size_t take_output(std::vector<std::uint8_t>& buffer);
  bool has_output() const;
  void run_for(std::uint64_t duration_us);
  /// Lets virtual time pass until a byte has been sent, at most `max_duration_us`; true if one was.
  bool run_until_output(std::uint64_t max_duration_us);
  std::uint64_t now_us() const;

  /// What the bench does not announce is looked at each millisecond, and now.
  void look_at_inputs();
  /// The stall output of an axis' driver is at this level.
  void set_stall(int axis, bool high);
  /// The stall output of an axis' driver rises, and falls again.
  void signal_stall(int axis);
  /// The supply fails and comes back, or the reset pin is pulled.
  void reset(ResetSource source);

  /// The USB connector, for a virtual cable.
  usbip::UsbFunction& usb();
  /// Whether the program shows itself to a USB host (pull-up on D+).
  bool usb_connected();

  Stm32f407& chip();
  const Stm32f407& chip() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace umov::mcu
