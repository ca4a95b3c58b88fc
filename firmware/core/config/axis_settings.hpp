// The axes: one table of their properties.
#pragma once

#include <array>
#include <cstdint>

#include "protocol/messages.hpp"

namespace umov::firmware {

using protocol::axis_count;

/// Properties of an axis. Those of `set_axis` can be changed by the host, the others are built in.
struct AxisSettings {
  std::uint32_t steps_per_turn;
  std::int32_t min_udeg;  ///< soft limits
  std::int32_t max_udeg;
  std::uint32_t speed_mdeg_s;
  std::uint32_t acceleration_mdeg_s2;
  std::uint32_t jerk_mdeg_s3;
  std::uint32_t take_up_udeg;     ///< 0 = off
  std::int32_t open_udeg;         ///< where the element is out of the beam; 0 = no such position
  std::uint32_t homing_mdeg_s;    ///< search for the home switch
  std::uint32_t approach_mdeg_s;  ///< last, slow approach to its edge
};

/// Room between a soft limit and its switch that a backlash take-up may use.
inline constexpr std::int32_t overtravel_udeg = 2'000'000;

/// `open` of polariser and analyser is a parking position of the same axis: the carrier turns the
/// element out of the beam 200 degrees beyond zero, 20 degrees above the angular range.
inline constexpr std::int32_t open_park_udeg = 200'000'000;

/// All axes of an instrument; order of protocol::Axis.
using AxisTable = std::array<AxisSettings, axis_count>;

/// What the reference instrument has.
inline constexpr AxisTable default_axes = {{
    // incidence: the sample turns
    {360'000, -10'000'000, 90'000'000, 40'000, 400'000, 8'000'000, 0, 0, 20'000, 1'000},
    // detector arm: signed angle in the plane, or with the azimuth out of it
    {360'000, -90'000'000, 90'000'000, 40'000, 400'000, 8'000'000, 0, 0, 20'000, 1'000},
    // azimuth: turns the detector's plane about the sample's normal
    {360'000, -180'000'000, 180'000'000, 40'000, 400'000, 8'000'000, 0, 0, 20'000, 1'000},
    // polariser and analyser: light carriers, fast
    {72'000, -180'000'000, 180'000'000, 360'000, 7'200'000, 200'000'000, 0, open_park_udeg, 90'000,
     5'000},
    {72'000, -180'000'000, 180'000'000, 360'000, 7'200'000, 200'000'000, 0, open_park_udeg, 90'000,
     5'000},
    // neutral-density wheel: position n at 60 n degrees
    {36'000, -5'000'000, 305'000'000, 360'000, 3'600'000, 72'000'000, 0, 0, 90'000, 5'000},
}};

/// Steps nearest to an angle, halves away from zero. Exact in 64 bits for any 32-bit angle.
constexpr std::int32_t steps_from_udeg(std::int32_t angle_udeg, std::uint32_t steps_per_turn) {
  constexpr std::int64_t turn_udeg = 360'000'000;
  const std::int64_t product = std::int64_t{angle_udeg} * steps_per_turn;
  const std::int64_t half = product >= 0 ? turn_udeg / 2 : -turn_udeg / 2;
  return static_cast<std::int32_t>((product + half) / turn_udeg);
}

/// Angle of a step count, to the nearest microdegree.
constexpr std::int32_t udeg_from_steps(std::int32_t steps, std::uint32_t steps_per_turn) {
  const std::int64_t product = std::int64_t{steps} * 360'000'000;
  const std::int64_t half = steps_per_turn / 2;
  return static_cast<std::int32_t>((product + (product >= 0 ? half : -half)) / steps_per_turn);
}

}  // namespace umov::firmware
