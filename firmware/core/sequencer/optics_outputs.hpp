// Lasers, shutter and amplifier range as commanded, and whether a change needs time to settle.
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/core/port.hpp"
#include "protocol/messages.hpp"

namespace umov::firmware {

class OpticsOutputs {
 public:
  explicit OpticsOutputs(Board& board) : board_(&board) {}

  /// Brings everything to its state at start: dark, range 0.
  void reset() {
    cut_light();
    range_ = 0;
    board_->set_gain(0);
  }
  /// Shutter closed, lasers off. Safe in any context.
  void cut_light() {
    board_->set_shutter(false);
    for (int laser = 0; laser < 3; ++laser) board_->set_laser(laser, false);
    shutter_open_ = false;
    laser_ = protocol::laser_none;
  }
  /// Dark, and dark it stays whatever is commanded, until allow_light(). Safe in any context.
  void hold_dark() {
    held_dark_.store(true, std::memory_order_relaxed);
    cut_light();
  }
  void allow_light() { held_dark_.store(false, std::memory_order_relaxed); }
  /// laser 1 to 3, 0 = none. True if something changed (also below).
  bool set_laser(std::uint8_t laser) {
    if (laser == laser_) return false;
    if (laser_ != protocol::laser_none) board_->set_laser(laser_ - 1, false);
    if (laser != protocol::laser_none) board_->set_laser(laser - 1, true);
    laser_ = laser;
    stay_dark_if_held();
    return true;
  }
  bool set_shutter(bool open) {
    if (open == shutter_open_) return false;
    board_->set_shutter(open);
    shutter_open_ = open;
    stay_dark_if_held();
    return true;
  }
  bool set_range(int range) {
    if (range == range_) return false;
    board_->set_gain(range);
    range_ = range;
    return true;
  }
  bool laser_on() const { return laser_ != protocol::laser_none; }
  int range() const { return range_; }

 private:
  /// An interrupt may have asked for darkness just before the light was switched on.
  void stay_dark_if_held() {
    if (held_dark_.load(std::memory_order_relaxed)) cut_light();
  }

  Board* board_;
  std::atomic<bool> held_dark_{false};
  std::uint8_t laser_ = protocol::laser_none;
  bool shutter_open_ = false;
  int range_ = 0;
};

}  // namespace umov::firmware
