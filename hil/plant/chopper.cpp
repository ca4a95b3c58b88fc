#include "hil/plant/chopper.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "hil/plant/noise.hpp"

namespace umov::plant {
namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;

}  // namespace

double Chopper::turns(double time_s) const {
  const double t = std::min(time_s, config_.stops_s);
  const double rate = two_pi / config_.wander_period_s;
  return config_.frequency_hz * (t + config_.wander / rate * (1.0 - std::cos(rate * t)));
}

double Chopper::moment_of(double turns_made) const {
  // Newton's method: the frequency is known and never 0.
  const double rate = two_pi / config_.wander_period_s;
  double t = turns_made / config_.frequency_hz;
  for (int i = 0; i < 20; ++i) {
    const double made =
        config_.frequency_hz * (t + config_.wander / rate * (1.0 - std::cos(rate * t)));
    const double speed = config_.frequency_hz * (1.0 + config_.wander * std::sin(rate * t));
    const double step = (turns_made - made) / speed;
    t += step;
    if (std::abs(step) < 1e-13 + 1e-16 * t) break;
  }
  return t;
}

double Chopper::edge_s(std::uint64_t number) const {
  const double jitter_turns =
      config_.jitter_deg == 0.0 ? 0.0 : config_.jitter_deg / 360.0 * gaussian_of(key_, number);
  return moment_of(static_cast<double>(number) + jitter_turns);
}

double Chopper::next_edge_s(double after_s) const {
  constexpr double none = std::numeric_limits<double>::infinity();
  if (!present() || after_s >= config_.stops_s) return none;
  // An edge that jitters by more than a turn is none.
  const double here = std::floor(turns(after_s));
  auto number = static_cast<std::uint64_t>(std::max(here - 1.0, 1.0));
  while (edge_s(number) <= after_s) ++number;
  const double edge = edge_s(number);
  return edge < config_.stops_s ? edge : none;
}

double Chopper::opening(double time_s, double ahead) const {
  const double turned = turns(time_s) + config_.phase_deg / 360.0 + ahead;
  const double phase = turned - std::floor(turned);
  // Distance to the middle of the open half, 0 to half a turn; the edges lie at a quarter.
  const double away = std::abs(std::remainder(phase - 0.25, 1.0));
  const double beyond = 0.25 - away;
  if (config_.edge_share == 0.0) return beyond >= 0.0 ? 1.0 : -1.0;
  return std::clamp(2.0 * beyond / config_.edge_share, -1.0, 1.0);
}

double Chopper::fundamental() const {
  const double x = std::numbers::pi * config_.edge_share;
  return x == 0.0 ? 1.0 : std::sin(x) / x;
}

}  // namespace umov::plant
