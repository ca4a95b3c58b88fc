#include "host/cli/study/foretelling.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "host/brdf/facet.hpp"
#include "host/formats/order_statistics.hpp"
#include "host/optics/angles.hpp"

namespace umov::study {
namespace {

constexpr double in_plane_within_deg = 0.5;
constexpr std::size_t plane_neighbours = 8;
constexpr double same_incidence_deg = 0.01;

}  // namespace

Direction direction_at(double theta_i_deg, double theta_r_deg, double phi_r_deg) {
  const double theta_r = optics::radians(theta_r_deg), phi_r = optics::radians(phi_r_deg);
  const auto frame =
      brdf::facet_frame(brdf::Geometry<double>{optics::radians(theta_i_deg), theta_r, phi_r});
  Direction d{theta_i_deg, theta_r_deg, phi_r_deg};
  d.half_deg = optics::degrees(std::atan(std::sqrt(frame.tan2_h)));
  d.difference_deg = optics::degrees(std::atan2(frame.sin_d, frame.cos_d));
  d.off_mirror_deg = optics::degrees(2 * std::asin(std::min(1.0, 0.5 * std::sqrt(frame.chord2))));
  d.in_plane = std::abs(std::sin(theta_r) * std::sin(phi_r)) <=
               std::sin(optics::radians(in_plane_within_deg));
  return d;
}

Region region_of(const Direction& d) {
  if (d.half_deg < 10) return Region::lobe;
  if (d.theta_i_deg >= 70 || std::abs(d.theta_r_deg) >= 70) return Region::grazing;
  if (d.difference_deg < 15) return Region::retro;
  return Region::other;
}

Score score(const std::vector<double>& foretold, const std::vector<double>& measured,
            const std::vector<std::size_t>& at) {
  Score out{.points = at.size()};
  if (at.empty()) return out;
  std::vector<double> sizes, errors;
  for (const std::size_t i : at) {
    const double error = foretold[i] / measured[i] - 1;
    const double counted = std::isfinite(error) ? error : -1.0;
    sizes.push_back(std::abs(counted));
    errors.push_back(counted);
  }
  out.offset = formats::median(errors);
  out.median = formats::median(sizes);
  out.p90 = formats::quantile(sizes, 0.9);
  return out;
}

Score noise_score(const std::vector<double>& relative_u, const std::vector<std::size_t>& at) {
  Score out{.points = at.size()};
  std::vector<double> sizes;
  // Quantiles of each point's error, ten a point, together give the distribution of all.
  for (const std::size_t i : at) {
    for (const double z :
         {0.0627, 0.1891, 0.3186, 0.4538, 0.5978, 0.7554, 0.9346, 1.1503, 1.4395, 1.9600})
      sizes.push_back(z * relative_u[i]);
  }
  out.median = formats::median(sizes);
  out.p90 = formats::quantile(sizes, 0.9);
  return out;
}

void HalfAnglePlane::add(const Direction& direction, double value) {
  points_.push_back({direction.half_deg, direction.difference_deg, value});
}

double HalfAnglePlane::at(const Direction& here) const {
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const double x = points_[i].half_deg - here.half_deg;
    const double y = points_[i].difference_deg - here.difference_deg;
    near.emplace_back(x * x + y * y, i);
  }
  const std::size_t count = std::min(plane_neighbours, near.size());
  std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
  double low = points_[near[0].second].value, high = low;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t n = 0; n < count; ++n) {
    const Point& p = points_[near[n].second];
    const double weight = 1 / (near[n].first + 1);
    const Eigen::Vector3d row(1, p.half_deg - here.half_deg,
                              p.difference_deg - here.difference_deg);
    normal += weight * row * row.transpose();
    right += weight * p.value * row;
    low = std::min(low, p.value);
    high = std::max(high, p.value);
  }
  // Points on one line leave a slope open; a trace of stiffness makes it none.
  normal(1, 1) += 1e-6;
  normal(2, 2) += 1e-6;
  return std::clamp(normal.ldlt().solve(right)(0), low, high);
}

void MirrorAngleCurves::add(const Direction& direction, double value) {
  auto curve = std::lower_bound(
      curves_.begin(), curves_.end(), direction.theta_i_deg,
      [](const Curve& c, double theta) { return c.theta_i_deg < theta - same_incidence_deg; });
  if (curve == curves_.end() || curve->theta_i_deg > direction.theta_i_deg + same_incidence_deg)
    curve = curves_.insert(curve, {direction.theta_i_deg, {}});
  const std::array<double, 2> point = {direction.off_mirror_deg, value};
  curve->points.insert(std::lower_bound(curve->points.begin(), curve->points.end(), point), point);
}

double MirrorAngleCurves::on(const Curve& curve, double off_mirror_deg) {
  const auto& points = curve.points;
  const auto above =
      std::lower_bound(points.begin(), points.end(), off_mirror_deg,
                       [](const std::array<double, 2>& p, double angle) { return p[0] < angle; });
  if (above == points.begin()) return points.front()[1];
  if (above == points.end()) return points.back()[1];
  const auto below = std::prev(above);
  const double span = (*above)[0] - (*below)[0];
  if (span <= 0) return (*above)[1];
  return (*below)[1] + (off_mirror_deg - (*below)[0]) / span * ((*above)[1] - (*below)[1]);
}

double MirrorAngleCurves::at(const Direction& d) const {
  const auto above = std::lower_bound(
      curves_.begin(), curves_.end(), d.theta_i_deg,
      [](const Curve& c, double theta) { return c.theta_i_deg < theta - same_incidence_deg; });
  if (above == curves_.end()) return on(curves_.back(), d.off_mirror_deg);
  if (above == curves_.begin() || above->theta_i_deg <= d.theta_i_deg + same_incidence_deg)
    return on(*above, d.off_mirror_deg);
  const auto below = std::prev(above);
  const double share =
      (d.theta_i_deg - below->theta_i_deg) / (above->theta_i_deg - below->theta_i_deg);
  return (1 - share) * on(*below, d.off_mirror_deg) + share * on(*above, d.off_mirror_deg);
}

}  // namespace umov::study
