// What a GPIO adapter's pins are wired to on the emulated bench.
#pragma once

#include <functional>
#include <optional>

#include "hil/plant/plant.hpp"
#include "hil/usbip/gpio_lines.hpp"

namespace umov::emulator {

/// The two pins of a controller that choose what it starts, and start it.
class BoardPins {
 public:
  virtual ~BoardPins() = default;
  /// BOOT0: high at a reset, the chip's ROM loader starts instead of the flash.
  virtual void set_boot0(bool high) = 0;
  /// NRST: low holds the controller in reset.
  virtual void set_nrst(bool high) = 0;
};

/// Pin 0 is BOOT0 (pulled down), pin 1 NRST (pulled up), pin 2 the interlock (pulled up: closed;
/// low opens it), pin 3 is not connected.
class BenchLines final : public usbip::GpioLines {
 public:
  static constexpr int boot0 = 0;
  static constexpr int nrst = 1;
  static constexpr int interlock = 2;

  /// Both must outlive it.
  BenchLines(plant::Plant& plant, BoardPins& board) : plant_(&plant), board_(&board) {}

  void drive(int pin, std::optional<bool> level) override {
    switch (pin) {
      case boot0:
        boot0_ = level.value_or(false);
        board_->set_boot0(boot0_);
        break;
      case nrst:
        nrst_ = level.value_or(true);
        board_->set_nrst(nrst_);
        break;
      case interlock:
        plant_->set_interlock(level.value_or(true));
        break;
      default:
        break;
    }
  }
  bool level(int pin) const override {
    switch (pin) {
      case boot0:
        return boot0_;
      case nrst:
        return nrst_;
      case interlock:
        return plant_->interlock_closed();
      default:
        return false;
    }
  }

 private:
  plant::Plant* plant_;
  BoardPins* board_;
  bool boot0_ = false;
  bool nrst_ = true;
};

}  // namespace umov::emulator
