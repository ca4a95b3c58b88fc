// Two benches with a controller for the same troubles: the core in this process, and the flashed
// image on the emulated chip. What happens, happens to pins, supply and peripherals.
#pragma once

#include <memory>

#include "boards/native/native_board.hpp"
#include "hil/mcu/board/mcu_board.hpp"
#include "tests/unit/mcu_board/noisy_stages.hpp"
#include "tests/unit/mcu_board/scan_run.hpp"

namespace umov::test {

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

  NoisyWorld world;
  boards::native::NativeBoard board{world};
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

  NoisyBench bench;
  mcu::McuBoard board{bench, {.image = UMOV_STM32F407_ELF}};
};

}  // namespace umov::test
