// Two benches with a controller for the same troubles: the core in this process, and the flashed
// image on the emulated chip. What happens, happens to pins, supply and peripherals.
#pragma once

#include <array>
#include <memory>
#include <span>

#include "boards/native/native_board.hpp"
#include "firmware/core/config/settings_pages.hpp"
#include "hil/mcu/board/mcu_board.hpp"
#include "tests/unit/mcu_board/noisy_stages.hpp"
#include "tests/unit/mcu_board/scan_run.hpp"

namespace umov::test {

/// The frame of a request whose answer nobody waits for.
inline std::vector<std::uint8_t> save_settings_frame() {
  std::vector<std::uint8_t> frame(protocol::wire_frame_size<protocol::SaveSettings>);
  frame.resize(protocol::FrameWriter::write(0x7FFF, protocol::SaveSettings{}, frame));
  return frame;
}

struct NativeRig {
  static constexpr const char* name = "native";
  /// Inputs are looked at in each tick: no interrupts in a process.
  static constexpr bool has_interrupts = false;

  NoisyStages& stages() { return world.stages; }
  double went_dark_s() const { return world.went_dark_s; }
  double now_s() const { return static_cast<double>(board.now_us()) * 1e-6; }
  void run_for(std::uint64_t us) { board.run_for(us); }
  std::unique_ptr<instrument::Transport> connect() { return test::connect(board); }

  void look_at_inputs() {}
  void overrun_adc() { board.signal_adc_overrun(); }
  void stand_still(std::uint64_t us) { board.stand_still(us); }
  void supply(bool low) { world.stages.supply_low = low; }
  void brown_out() { board.reset(firmware::ResetCause::brown_out); }
  void power_cycle() { board.reset(firmware::ResetCause::power_on); }
  /// Settings of other firmware: this board's memory has no bits to flip.
  void spoil_settings() { settings->save(0xFFFF, std::array<std::uint8_t, 1>{}); }
  /// Written in an instant: there is no middle of it.
  void begin_saving() { board.deliver(save_settings_frame()); }

  NoisyWorld world;
  std::shared_ptr<boards::native::RamSettings> settings =
      std::make_shared<boards::native::RamSettings>();
  boards::native::NativeBoard board{world, {.link_time_us = {}, .log = {}, .settings = settings}};
};

struct McuRig {
  static constexpr const char* name = "flashed image";
  static constexpr bool has_interrupts = true;

  NoisyStages& stages() { return bench.stages; }
  double went_dark_s() const { return bench.went_dark_s; }
  double now_s() const { return mcu::seconds(board.chip().now()); }
  void run_for(std::uint64_t us) { board.run_for(us); }
  std::unique_ptr<instrument::Transport> connect() { return test::connect(board); }

  void look_at_inputs() {
    board.look_at_inputs();
    for (int axis = 0; axis < 6; ++axis) board.set_stall(axis, axis == bench.stages.stalled);
  }
  void overrun_adc() { board.chip().overrun_adc(); }
  void stand_still(std::uint64_t us) { board.chip().stand_still(us * mcu::time_per_us); }
  void supply(bool low) { board.chip().set_supply(low ? 2700 : 3300); }
  void brown_out() { board.reset(mcu::ResetSource::brown_out); }
  void power_cycle() { board.reset(mcu::ResetSource::power_on); }
  /// A bit turns over in every set that was saved.
  void spoil_settings() {
    const std::span<std::uint8_t> page = settings_pages();
    constexpr std::size_t slot = 4 * firmware::SettingsPages::slot_words;
    for (std::size_t at = 0; at < page.size(); at += slot) {
      if (page[at] != 0xFF) page[at + 20] ^= 4;
    }
  }
  /// Returns when the flash is being written.
  void begin_saving() {
    const std::vector<std::uint8_t> before(settings_pages().begin(), settings_pages().end());
    board.deliver(save_settings_frame());
    for (int i = 0; i < 5'000; ++i) {
      board.run_for(1);
      if (!std::equal(before.begin(), before.end(), settings_pages().begin())) return;
    }
  }

  std::span<std::uint8_t> settings_pages() {
    return std::span(board.chip().flash_contents()).subspan(0x8000, 32 * 1024);
  }

  NoisyBench bench;
  mcu::McuBoard board{bench, {.image = UMOV_STM32F407_ELF}};
};

}  // namespace umov::test
