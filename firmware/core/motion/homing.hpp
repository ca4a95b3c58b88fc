// Finds the zero of an axis: the upper edge of its home switch, approached slowly from inside.
#pragma once

#include <cstdint>

#include "firmware/core/config/axis_settings.hpp"
#include "firmware/core/motion/axis_motion.hpp"

namespace umov::firmware {

/// The home switch is pressed over some range of the axis, wide (all below zero) or narrow (a
/// flag); zero is where it is released when the axis moves upwards. Works wherever the axis starts:
///   search   down until the switch presses; if a limit switch comes first, up from there
///   release  up until it releases (the first stage when it is pressed at the start)
///   approach down, slowly, until it presses
///   edge     up, at a quarter of that speed, until it releases: here is zero
///   arrive   below zero and up again to it, so that backlash is taken up
class Homing {
 public:
  enum class Result : std::uint8_t { busy, done, not_found, limit };

  void begin(AxisMotion& axis, const AxisSettings& settings, bool home_pressed);
  /// Once a millisecond while the axis is at rest.
  Result advance(bool home_pressed);

 private:
  enum class Stage : std::uint8_t {
    search_down,
    search_up,
    release,
    approach,
    edge,
    below,
    arrive
  };

  Result enter(Stage stage);
  bool start(Stage stage);
  bool seek(int direction, std::uint32_t speed_mdeg_s, Watch watch);
  Result after_search(bool home_pressed);
  Result after_edge();

  AxisMotion* axis_ = nullptr;
  const AxisSettings* settings_ = nullptr;
  Stage stage_ = Stage::search_down;
};

}  // namespace umov::firmware
