#include "host/calibrate/aperture.hpp"

#include <cmath>
#include <utility>

#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

constexpr double doubt_from_points = 0.2, doubt_from_shape = 0.05;
constexpr double narrow_share = 0.25;
/// Nearer than this to the mirror direction the slope over tanθh is the ratio of two small numbers.
constexpr double middle_deg = 1.5;

/// Second derivative of f along the great circle across the plane of incidence, 1/sr per rad².
double curvature_across(double slope, double curvature, double theta_i, double theta_r) {
  const double half = 0.5 * (theta_r - theta_i), difference = 0.5 * (theta_r + theta_i);
  const double cos2 = std::pow(std::cos(difference), 2);
  if (!(cos2 > 1e-3)) return 0;
  return std::abs(half) < optics::radians(0.5 * middle_deg) ? curvature / cos2
                                                            : slope / (2 * std::tan(half) * cos2);
}

/// Collects the excess of one point after the other.
class Collector {
 public:
  Collector(const formats::BrdfTable::Points& points, double relative_doubt)
      : points_(points), relative_doubt_(relative_doubt) {
    result.per_sr.assign(points.size(), 0.0);
    result.doubt_per_sr = result.per_sr;
  }

  void set(std::size_t i, double excess, double higher_orders) {
    const double f = points_.brdf_per_sr[i];
    if (std::abs(excess) > narrow_share * std::abs(f)) {
      result.doubt_per_sr[i] = std::copysign(narrow_share * f, excess);
      result.too_narrow += points_.used[i] != 0;
      return;
    }
    result.per_sr[i] = excess;
    result.doubt_per_sr[i] = excess * std::hypot(relative_doubt_, higher_orders);
  }

  ApertureExcess result;

 private:
  const formats::BrdfTable::Points& points_;
  double relative_doubt_;
};

/// Directions over a disc about (θ, φ), with equal weights: midpoints of equal areas, two rings of
/// six, good to the fourth order.
struct DiscDirection {
  double theta_deg, phi_deg, cosine;
};
std::vector<DiscDirection> disc_directions(double theta_deg, double phi_deg, double half_angle) {
  const double theta = optics::radians(theta_deg), phi = optics::radians(phi_deg);
  std::vector<DiscDirection> directions;
  // Nodes of the Gauss rule of two points over the disc's area.
  for (const double share : {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)}) {
    const double away = half_angle * std::sqrt(share);
    for (int k = 0; k < 6; ++k) {
      const double turn = optics::pi * (k + (share < 0.5 ? 0.0 : 0.5)) / 3;
      const double along = std::sin(away) * std::cos(turn),
                   across = std::sin(away) * std::sin(turn);
      // In the frame of the plane through the normal and the middle.
      const double x = std::cos(away) * std::sin(theta) + along * std::cos(theta);
      const double z = std::cos(away) * std::cos(theta) - along * std::sin(theta);
      // θ keeps its sign, so that the azimuth stays near that of the middle.
      const double sign = x < 0 ? -1 : 1;
      directions.push_back({sign * optics::degrees(std::atan2(std::hypot(x, across), z)),
                            optics::degrees(phi + std::atan2(sign * across, sign * x)), z});
    }
  }
  return directions;
}

}  // namespace

ApertureExcess aperture_excess(const formats::BrdfTable::Points& points, const AngleSlopes& slopes,
                               double half_angle_deg) {
  Collector collector(points, doubt_from_points);
  const double a = optics::radians(half_angle_deg), per_rad = 1.0 / optics::radians(1.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double f = points.brdf_per_sr[i];
    const double sign = std::cos(optics::radians(points.phi_r_deg[i])) < 0 ? -1 : 1;
    const double theta_i = optics::radians(points.theta_i_deg[i]),
                 theta_r = optics::radians(points.theta_r_deg[i]);
    const double slope = slopes.slope[i] * per_rad,
                 curvature = slopes.curvature[i] * per_rad * per_rad;
    if (slope == 0 && curvature == 0) continue;
    // Off the plane of incidence the lobe's middle is not on the line; there the line stands for
    // both directions.
    const bool in_plane = std::abs(std::sin(optics::radians(points.phi_r_deg[i]))) < 1e-3;
    const double across =
        in_plane ? curvature_across(sign * slope, curvature, theta_i, sign * theta_r) : curvature;
    const double excess = a * a / 8 * (curvature - 2 * slope * std::tan(theta_r) + across - 2 * f);
    collector.set(i, excess, std::abs(f) > 0 ? std::abs(excess / f) : 0.0);
  }
  return std::move(collector.result);
}

ApertureExcess aperture_excess(const formats::BrdfTable::Points& points, const BrdfShape& shape,
                               double half_angle_deg) {
  Collector collector(points, doubt_from_shape);
  const double half_angle = optics::radians(half_angle_deg);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double cosine = std::cos(optics::radians(points.theta_r_deg[i]));
    // The analyser stands still while the plane through the normal, from which its axis counts,
    // turns with the azimuth: by Δφ cosθ about the beam.
    const auto at = [&](double theta_deg, double phi_deg) {
      return shape(points.theta_i_deg[i], theta_deg, phi_deg, points.wavelength_nm[i],
                   points.polarizer_deg[i],
                   points.analyzer_deg[i] + (phi_deg - points.phi_r_deg[i]) * cosine);
    };
    const double middle = at(points.theta_r_deg[i], points.phi_r_deg[i]);
    if (!(middle > 0) || !(cosine > 0)) continue;
    double sum = 0;
    const auto directions = disc_directions(points.theta_r_deg[i], points.phi_r_deg[i], half_angle);
    for (const DiscDirection& d : directions)
      if (d.cosine > 0) sum += at(d.theta_deg, d.phi_deg) * d.cosine;
    // Of the point's own value: the mean is what was measured.
    const double mean = sum / static_cast<double>(directions.size()) / (cosine * middle);
    if (mean > 0) collector.set(i, points.brdf_per_sr[i] * (1 - 1 / mean), 0.0);
  }
  return std::move(collector.result);
}

}  // namespace umov::calibrate
