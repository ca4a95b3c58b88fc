#include "firmware/core/motion/profile.hpp"

#include <algorithm>
#include <bit>

#include "firmware/core/integer/wide.hpp"

namespace umov::firmware {
namespace {

constexpr std::uint64_t half_step = std::uint64_t{1} << (Profile::fraction_bits - 1);

/// Shortest whole-tick durations that keep J = D/(T1 U S), A = D/(U S) and V = D/S within the
/// limits, with U = T1 + T2 and S = 2 T1 + T2 + T3; the move takes T1 + U + S.
SegmentTicks plan(std::uint32_t steps, const MotionLimits& limits, std::uint32_t timer_hz) {
  const std::uint64_t f = timer_hz;
  const std::uint64_t scaled = std::uint64_t{steps} * limits.denominator;
  const Uint128 distance_f2 = multiply(multiply(f, f), scaled);      // D f^2
  const Uint128 distance_f3 = multiply(multiply(f * f, f), scaled);  // D f^3

  // T1 ends when the acceleration, the speed or the distance allows no more jerk.
  const std::uint64_t by_distance = cube_root_up(divide_up(distance_f3, 2 * limits.jerk));
  const std::uint64_t by_speed =
      square_root_up(divide_up(multiply(multiply(f, f), limits.speed), limits.jerk));
  const std::uint64_t by_acceleration =
      divide_up(multiply(f, limits.acceleration), limits.jerk).low;
  const std::uint64_t t1 =
      std::max<std::uint64_t>(1, std::min({by_distance, by_speed, by_acceleration}));

  const std::uint64_t s_speed = divide_up(multiply(scaled, f), limits.speed).low;
  const Uint128 by_a = divide_up(distance_f2, limits.acceleration);
  const Uint128 by_j = divide_up(divide_up(distance_f3, limits.jerk), t1);
  const Uint128 product = by_a < by_j ? by_j : by_a;  // U S must reach this

  // With a cruise S = s_speed; without one S = T1 + U, a quadratic in U.
  const Uint128 u_cruising = divide_up(product, s_speed);
  const std::uint64_t root = square_root_up(multiply(t1, t1) + (product << 2));
  Uint128 u = (root - t1 + 1) / 2;
  if (u_cruising < u) u = u_cruising;
  const std::uint64_t u_ticks = std::max(t1, u.low);
  const std::uint64_t s_ticks = std::max(s_speed, t1 + u_ticks);
  return {t1, u_ticks - t1, s_ticks - t1 - u_ticks};
}

/// Smallest e >= 1 with 2^e > ticks.
unsigned exponent_above(std::uint64_t ticks) {
  return std::max(1u, static_cast<unsigned>(std::bit_width(ticks)));
}

/// value * scaled time, scaled time = ticks / 2^exponent.
std::uint64_t times(std::uint64_t value, std::uint64_t ticks, unsigned exponent) {
  return multiply_shift(value, ticks, exponent);
}
std::int64_t times(std::int64_t value, std::uint64_t ticks, unsigned exponent) {
  return value >= 0
             ? static_cast<std::int64_t>(times(static_cast<std::uint64_t>(value), ticks, exponent))
             : -static_cast<std::int64_t>(
                   times(static_cast<std::uint64_t>(-value), ticks, exponent));
}

/// Ticks by which a Newton step moves: difference * 2^exponent / slope. `exact`: to the nearest
/// tick; else the move is long or leaves the segment, and the next iteration looks again.
struct NewtonStep {
  std::uint64_t ticks;
  bool exact;
};

/// Divides only when the guess was off by more than four ticks.
NewtonStep newton_step(std::uint64_t difference, std::uint64_t slope, unsigned exponent) {
  if (difference >= slope) return {std::uint64_t{1} << exponent, false};
  const unsigned width = static_cast<unsigned>(std::bit_width(difference));
  const unsigned room = 63 - width;
  if (exponent <= room) {
    const std::uint64_t scaled = difference << exponent;
    if ((scaled >> 2) >= slope) return {(scaled + slope / 2) / slope, true};
    std::uint64_t ticks = 0;
    for (std::uint64_t rest = scaled + slope / 2; rest >= slope; rest -= slope) ++ticks;
    return {ticks, true};
  }
  const std::uint64_t coarse = slope >> (exponent - room);
  if (coarse == 0) return {std::uint64_t{1} << exponent, false};
  return {(difference << room) / coarse, false};
}

/// Whether a Newton step that ends `ticks` after the start needs no further look. The speed grows
/// at most like the square of the time, so what the step leaves is below moved^2 / ticks: here a
/// 64th of a tick.
bool good_enough(const NewtonStep& step, std::uint64_t ticks) {
  if (step.ticks <= 1) return true;
  return step.exact && step.ticks < 4096 && 64 * step.ticks * step.ticks <= ticks;
}

}  // namespace

Profile::Profile(std::uint32_t steps, const MotionLimits& limits, std::uint32_t timer_hz)
    : durations_(plan(steps, limits, timer_hz)), distance_(std::uint64_t{steps} << fraction_bits) {
  build_segments();
}

void Profile::build_segments() {
  total_ = durations_.total();
  half_ = durations_.half();
  steps_ = static_cast<std::uint32_t>((distance_ + half_step) >> fraction_bits);
  const std::uint64_t t1 = durations_.jerk;
  const std::uint64_t t2 = durations_.acceleration;
  const std::uint64_t u = t1 + t2;
  const std::uint64_t s = u + t1 + durations_.cruise;
  const auto power = [](unsigned exponent) { return std::uint64_t{1} << exponent; };
  // Speed of the cruise per 2^exponent ticks.
  const auto speed = [&](unsigned exponent) {
    return multiply_divide(distance_, power(exponent), s);
  };

  Segment& rising = segments_[0];
  rising.exponent = exponent_above(t1);
  const std::uint64_t scale = power(rising.exponent);
  // J T1^3, then J 2^(3e) / 6
  const std::uint64_t jerk_cubed = multiply_divide(multiply_divide(distance_, t1, s), t1, u);
  std::uint64_t cubic = multiply_divide(jerk_cubed, scale, t1);
  cubic = multiply_divide(cubic, scale, t1);
  cubic = multiply_divide(cubic, scale, 6 * t1);
  rising.cubic = static_cast<std::int64_t>(cubic);

  Segment& steady = segments_[1];
  steady.begin = t1;
  steady.start = jerk_cubed / 6;
  steady.exponent = exponent_above(t2);
  steady.linear = multiply_divide(speed(steady.exponent), t1, 2 * u);
  steady.square = multiply_divide(speed(steady.exponent), power(steady.exponent), 2 * u);
  steady.cubic = 0;

  Segment& falling = segments_[2];
  falling.begin = u;
  falling.start = steady.start + times(steady.linear + times(steady.square, t2, steady.exponent),
                                       t2, steady.exponent);
  falling.exponent = rising.exponent;
  falling.linear = multiply_divide(speed(falling.exponent), t1 + 2 * t2, 2 * u);
  falling.square = multiply_divide(speed(falling.exponent), scale, 2 * u);
  falling.cubic = -rising.cubic;

  Segment& cruising = segments_[3];
  cruising.begin = u + t1;
  cruising.start = multiply_divide(distance_, u + t1, 2 * s);
  cruising.exponent = exponent_above(durations_.cruise);
  cruising.linear = speed(cruising.exponent);
  cruising.square = 0;
  cruising.cubic = 0;
}

Profile Profile::stopped_after(std::uint64_t ticks) const {
  const SegmentTicks& d = durations_;
  Profile stop;
  stop.durations_ = d;
  const std::uint64_t cruise_begin = 2 * d.jerk + d.acceleration;
  if (ticks < d.jerk) {
    stop.durations_ = {std::max<std::uint64_t>(ticks, 1), 0, 0};
  } else if (ticks < d.jerk + d.acceleration) {
    stop.durations_ = {d.jerk, ticks - d.jerk, 0};
  } else if (ticks < cruise_begin) {
    stop.durations_.cruise = 0;
  } else if (ticks < cruise_begin + d.cruise) {
    stop.durations_.cruise = ticks - cruise_begin;
  } else {
    return *this;  // decelerating already: the end of the move is the earliest stop
  }
  // D = J T1 U S with the same jerk.
  const SegmentTicks& n = stop.durations_;
  const std::uint64_t u_new = n.jerk + n.acceleration, u_old = d.jerk + d.acceleration;
  stop.distance_ = multiply_divide(distance_, n.jerk, d.jerk);
  stop.distance_ = multiply_divide(stop.distance_, u_new, u_old);
  stop.distance_ =
      multiply_divide(stop.distance_, u_new + n.jerk + n.cruise, u_old + d.jerk + d.cruise);
  stop.build_segments();
  return stop;
}

const Profile::Segment& Profile::segment_at(std::uint64_t ticks) const {
  int index = 3;
  while (index > 0 && ticks < segments_[static_cast<std::size_t>(index)].begin) --index;
  return segments_[static_cast<std::size_t>(index)];
}

std::uint64_t Profile::distance_at(std::uint64_t ticks) const {
  if (ticks >= total_ticks()) return distance_;
  if (2 * ticks > total_ticks()) return distance_ - distance_at(total_ticks() - ticks);
  const Segment& g = segment_at(ticks);
  const std::uint64_t t = ticks - g.begin;
  const std::uint64_t curve = g.square + static_cast<std::uint64_t>(times(g.cubic, t, g.exponent));
  return g.start + times(g.linear + times(curve, t, g.exponent), t, g.exponent);
}

std::uint64_t Profile::rising_tick(std::uint64_t distance, std::uint64_t guess) const {
  // The distance is convex over the first half, so Newton's iteration comes from above after its
  // first step and cannot leave the half.
  const std::uint64_t half = half_;
  std::uint64_t t = std::min(guess, half);
  for (int iteration = 0; iteration < 100; ++iteration) {
    const Segment& g = segment_at(t);
    const std::uint64_t local = t - g.begin;
    std::uint64_t mean = g.linear;  // mean and final slope over the part of the segment gone
    std::uint64_t slope = g.linear;
    if (g.square != 0 || g.cubic != 0) {
      const std::uint64_t bend = static_cast<std::uint64_t>(times(g.cubic, local, g.exponent));
      const std::uint64_t curve = g.square + bend;
      mean += times(curve, local, g.exponent);
      slope += times(2 * curve + bend, local, g.exponent);  // linear + u (2 square + 3 u cubic)
    }
    const std::uint64_t reached = g.start + times(mean, local, g.exponent);
    if (reached <= distance) {
      const NewtonStep forward = newton_step(distance - reached, slope, g.exponent);
      t = std::min(half, t + forward.ticks);
      if (good_enough(forward, t)) break;
    } else {
      const NewtonStep back = newton_step(reached - distance, slope, g.exponent);
      t -= std::min(t, back.ticks);
      if (good_enough(back, t)) break;
    }
  }
  return t;
}

std::uint64_t Profile::step_tick(std::uint32_t number, std::uint64_t guess) const {
  const std::uint64_t target = (std::uint64_t{number} << fraction_bits) - half_step;
  if (2 * target <= distance_) return rising_tick(target, guess);
  const std::uint64_t total = total_ticks();
  return total - rising_tick(distance_ - target, total - std::min(guess, total));
}

}  // namespace umov::firmware
