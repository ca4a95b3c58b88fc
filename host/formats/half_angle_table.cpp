#include "host/formats/half_angle_table.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/mueller.hpp"

namespace umov::formats {
namespace {

using optics::pi;
using optics::Vec3;

/// Position among cell middles: the two cells around it and the share of the upper one.
struct Between {
  std::size_t lower, upper;
  double share;
};

Between clamped(double position, std::size_t count) {
  const double last = static_cast<double>(count - 1);
  const double p = std::clamp(position, 0.0, last);
  const auto lower = static_cast<std::size_t>(p);
  return {lower, std::min(lower + 1, count - 1), p - std::floor(p)};
}

Between periodic(double position, std::size_t count) {
  const double n = static_cast<double>(count);
  double p = position - n * std::floor(position / n);
  if (p >= n) p = 0.0;  // a position a rounding error below 0
  const auto lower = static_cast<std::size_t>(p);
  return {lower, (lower + 1) % count, p - std::floor(p)};
}

}  // namespace

HalfAngles half_angles(const brdf::Geometry<double>& geometry) {
  // φ = 0 is away from the source; the frame is turned so that the source stands at azimuth 0.
  const Vec3<double> in(std::sin(geometry.theta_i), 0.0, std::cos(geometry.theta_i));
  const double sine = std::sin(geometry.theta_r);
  const Vec3<double> out(-sine * std::cos(geometry.phi_r), -sine * std::sin(geometry.phi_r),
                         std::cos(geometry.theta_r));
  const Vec3<double> h = in + out;
  const double across = std::hypot(h.x, h.y);
  const double theta_h = std::atan2(across, h.z);
  const double cos_phi = across > 1e-15 ? h.x / across : 1.0;
  const double sin_phi = across > 1e-15 ? h.y / across : 0.0;
  const double x = in.x * cos_phi;
  const double y = -in.x * sin_phi;
  const double along = x * std::cos(theta_h) - in.z * std::sin(theta_h);
  return {theta_h,
          std::atan2(std::hypot(along, y), x * std::sin(theta_h) + in.z * std::cos(theta_h)),
          std::atan2(y, along)};
}

brdf::Geometry<double> geometry_of(const HalfAngles& angles) {
  const double ch = std::cos(angles.theta_h), sh = std::sin(angles.theta_h);
  const double cd = std::cos(angles.theta_d), sd = std::sin(angles.theta_d);
  const double x = sd * std::cos(angles.phi_d), y = sd * std::sin(angles.phi_d);
  const Vec3<double> in(x * ch + cd * sh, y, -x * sh + cd * ch);
  const Vec3<double> out(-x * ch + cd * sh, -y, x * sh + cd * ch);
  const double turn = std::atan2(out.y, out.x) - std::atan2(in.y, in.x) - pi;
  return {std::atan2(std::hypot(in.x, in.y), in.z), std::atan2(std::hypot(out.x, out.y), out.z),
          std::remainder(turn, 2.0 * pi)};
}

HalfAngles HalfAngleCells::middle(std::size_t h, std::size_t d, std::size_t p) const {
  const auto share = [](std::size_t i, std::size_t n) {
    return (static_cast<double>(i) + 0.5) / static_cast<double>(n);
  };
  const double root = share(h, theta_h);
  return {0.5 * pi * root * root, 0.5 * pi * share(d, theta_d), pi * share(p, phi_d)};
}

HalfAngleTable::HalfAngleTable(HalfAngleCells cells, std::vector<double> stored, std::string origin)
    : cells_(cells),
      stored_(std::move(stored)),
      origin_(std::move(origin)),
      wavelengths_um_(channel_um.begin(), channel_um.end()) {
  if (cells_.theta_h < 1 || cells_.theta_d < 1 || cells_.phi_d < 1 ||
      stored_.size() / 3 / cells_.theta_h / cells_.theta_d != cells_.phi_d ||
      stored_.size() != 3 * cells_.count())
    throw Error(Place{origin_},
                fmt::format("has {} values, not 3 x {} x {} x {}", stored_.size(), cells_.theta_h,
                            cells_.theta_d, cells_.phi_d),
                "a half-angle table has three channels with a value a cell");
  const auto bad = std::find_if_not(stored_.begin(), stored_.end(),
                                    [](double value) { return std::isfinite(value); });
  if (bad != stored_.end())
    throw Error(Place{origin_},
                fmt::format("value {} is not a finite number", bad - stored_.begin()),
                "unknown cells hold a negative number");
}

std::string HalfAngleTable::description() const {
  return fmt::format("half-angle table {} x {} x {}, 3 channels, from {}", cells_.theta_h,
                     cells_.theta_d, cells_.phi_d, origin_);
}

optics::Mueller<double> HalfAngleTable::at(double wavelength_um,
                                           const brdf::Geometry<double>& geometry) const {
  optics::Mueller<double> m(0.0);
  if (!(std::cos(geometry.theta_i) > 0.0) || !(std::cos(geometry.theta_r) > 0.0)) return m;
  const HalfAngles angles = half_angles(geometry);
  const auto cells_of = [](double share, std::size_t n) {
    return share * static_cast<double>(n) - 0.5;
  };
  const Between h =
      clamped(cells_of(std::sqrt(angles.theta_h / (0.5 * pi)), cells_.theta_h), cells_.theta_h);
  const Between d = clamped(cells_of(angles.theta_d / (0.5 * pi), cells_.theta_d), cells_.theta_d);
  const Between p = periodic(cells_of(angles.phi_d / pi, cells_.phi_d), cells_.phi_d);

  const auto channel = [&](std::size_t c) {
    const double* values = stored_.data() + c * cells_.count();
    const auto layer = [&](std::size_t theta_d) {
      double sum = 0.0, weight = 0.0;
      for (const auto& [ih, wh] : {std::pair(h.lower, 1.0 - h.share), std::pair(h.upper, h.share)})
        for (const auto& [ip, wp] :
             {std::pair(p.lower, 1.0 - p.share), std::pair(p.upper, p.share)}) {
          const double value = values[(ih * cells_.theta_d + theta_d) * cells_.phi_d + ip];
          if (value < 0.0) continue;
          sum += wh * wp * value;
          weight += wh * wp;
        }
      return std::pair(sum, weight);
    };
    const auto [low_sum, low_weight] = layer(d.lower);
    const auto [high_sum, high_weight] = layer(d.upper);
    const double weight = (1.0 - d.share) * low_weight + d.share * high_weight;
    if (weight > 1e-12) return ((1.0 - d.share) * low_sum + d.share * high_sum) / weight;
    for (std::size_t theta_d = d.lower; theta_d-- > 0;)
      if (const auto [sum, known] = layer(theta_d); known > 1e-12) return sum / known;
    return 0.0;
  };
  // wavelengths ascend: blue, green, red; channels are stored red first.
  const auto value_at = [&](std::size_t colour) {
    return channel(2 - colour) * channel_scale[2 - colour];
  };
  double value = 0.0;
  if (wavelength_um <= channel_um[0]) {
    value = value_at(0);
  } else if (wavelength_um >= channel_um[2]) {
    value = value_at(2);
  } else {
    const std::size_t lower = wavelength_um < channel_um[1] ? 0 : 1;
    const double share =
        (wavelength_um - channel_um[lower]) / (channel_um[lower + 1] - channel_um[lower]);
    value = share == 0.0 ? value_at(lower)
                         : (1.0 - share) * value_at(lower) + share * value_at(lower + 1);
  }
  m[0][0] = value;
  return m;
}

}  // namespace umov::formats
