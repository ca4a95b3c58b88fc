#include "host/calibrate/dhr.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include <Eigen/Dense>

#include "host/calibrate/linear_combination.hpp"
#include "host/formats/scan_table.hpp"
#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

constexpr double degree = optics::radians(1.0);
/// Of the part beyond the last angle: what the profile may do there although it was flat before.
constexpr double extrapolation_share = 0.1;
/// Of the result, where P or S incidence alone was measured.
constexpr double one_polarisation_share = 0.02;

enum State { open_beam = 0, p = 1, s = 2, other = 3 };

State state_of(double axis_deg) {
  if (formats::is_open(axis_deg)) return open_beam;
  if (std::abs(std::remainder(axis_deg, 180.0)) < 0.01) return p;
  if (std::abs(std::remainder(axis_deg - 90.0, 180.0)) < 0.01) return s;
  return other;
}

/// Used points of one exit angle by incident and detected state.
struct Node {
  std::vector<std::size_t> points[3][3];

  /// All light that leaves for incident state `from`: open analyser, or P and S added.
  LinearCombination total(State from) const {
    if (!points[from][open_beam].empty()) return mean(points[from][open_beam]);
    LinearCombination sum;
    if (points[from][p].empty() || points[from][s].empty()) return sum;
    sum.add(mean(points[from][p]), 1.0);
    sum.add(mean(points[from][s]), 1.0);
    return sum;
  }

 private:
  static LinearCombination mean(const std::vector<std::size_t>& members) {
    LinearCombination result;
    for (std::size_t i : members) result.add(i, 1.0 / static_cast<double>(members.size()));
    return result;
  }
};

struct Mode {
  const char* name;
  bool one_polarisation;
  LinearCombination (*value)(const Node&);
};

const Mode modes[] = {
    {"unpolarised incidence", false, [](const Node& n) { return n.total(open_beam); }},
    {"mean of P and S incidence", false,
     [](const Node& n) {
       const LinearCombination from_p = n.total(p), from_s = n.total(s);
       LinearCombination mean;
       if (from_p.empty() || from_s.empty()) return mean;
       mean.add(from_p, 0.5);
       mean.add(from_s, 0.5);
       return mean;
     }},
    {"P incidence only", true, [](const Node& n) { return n.total(p); }},
    {"S incidence only", true, [](const Node& n) { return n.total(s); }},
};

struct Profile {
  std::vector<double> theta_rad;  ///< signed, ascending
  std::vector<LinearCombination> value;
  double reach() const {
    return theta_rad.empty() ? 0.0
                             : std::max(std::abs(theta_rad.front()), std::abs(theta_rad.back()));
  }
};

Profile profile_of(const std::map<long long, Node>& nodes, const Mode& mode) {
  Profile profile;
  for (const auto& [angle, node] : nodes) {
    LinearCombination value = mode.value(node);
    if (value.empty()) continue;
    profile.theta_rad.push_back(static_cast<double>(angle) * 1e-4 * degree);
    profile.value.push_back(std::move(value));
  }
  return profile;
}

/// A profile on one side of the normal only is mirrored to the other.
Profile both_sides(Profile profile) {
  constexpr double little = 10.0 * degree;
  if (profile.theta_rad.empty() ||
      (profile.theta_rad.front() < -little && profile.theta_rad.back() > little))
    return profile;
  const bool positive = profile.theta_rad.back() > -profile.theta_rad.front();
  std::map<double, LinearCombination> nodes;
  for (std::size_t k = 0; k < profile.theta_rad.size(); ++k) {
    const double t = profile.theta_rad[k];
    if ((positive ? t : -t) < 0) continue;
    nodes[t] = profile.value[k];
    nodes[-t] = profile.value[k];
  }
  Profile result;
  for (const auto& [t, value] : nodes) {
    result.theta_rad.push_back(t);
    result.value.push_back(value);
  }
  return result;
}

/// ∫ (θ - θ0) cosθ sinθ dθ from θ0 to 90°.
double first_moment(double theta0) {
  // By parts: -½cos²θ (θ - θ0) vanishes at both ends, ∫ ½cos²θ dθ is left.
  return 0.25 * (std::numbers::pi / 2.0 - theta0) - 0.125 * std::sin(2.0 * theta0);
}

/// A straight line through the nodes of the last 15° on one side.
struct Tail {
  LinearCombination level;  ///< its value at the last node
  double slope = 0;         ///< per radian outwards
};

Tail tail_of(const Profile& profile, const formats::BrdfTable& table, bool upper) {
  Tail tail;
  const auto outwards = [&](std::size_t k) {
    return upper ? profile.theta_rad[k] : -profile.theta_rad[k];
  };
  const double end = upper ? profile.theta_rad.back() : -profile.theta_rad.front();
  std::vector<std::size_t> near;
  double mean = 0;
  for (std::size_t k = 0; k < profile.theta_rad.size(); ++k)
    if (outwards(k) > end - 15.0 * degree - 1e-9) near.push_back(k);
  const double n = static_cast<double>(near.size());
  for (std::size_t k : near) mean += outwards(k) / n;
  double spread = 0;
  for (std::size_t k : near) spread += (outwards(k) - mean) * (outwards(k) - mean);
  for (std::size_t k : near) {
    const double lever = near.size() >= 3 && spread > 0 ? (outwards(k) - mean) / spread : 0.0;
    tail.level.add(profile.value[k], 1.0 / n + (end - mean) * lever);
    tail.slope += lever * profile.value[k].value(table);
  }
  return tail;
}

/// a + b t + c t² through values at t by least squares.
Eigen::Vector3d parabola(const Eigen::VectorXd& t, const Eigen::VectorXd& values) {
  Eigen::MatrixXd design(t.size(), 3);
  design << Eigen::VectorXd::Ones(t.size()), t, t.array().square().matrix();
  return design.colPivHouseholderQr().solve(values);
}

/// The gap that unusable points leave about the normal: how far apart a flat, a parabolic and a
/// Gaussian bridge are. All three follow the nodes beside the gap, so that the largest difference
/// stands for what a smooth lobe may do in it.
void bridge_gap(const Profile& profile, const formats::BrdfTable& table,
                const std::vector<double>& unusable_rad, DhrDetail& detail) {
  const auto upper = std::upper_bound(profile.theta_rad.begin(), profile.theta_rad.end(), 1e-9);
  if (upper == profile.theta_rad.begin() || upper == profile.theta_rad.end()) return;
  const double high = *upper, low = *std::prev(upper);
  if (low > -1e-9) return;  // the normal itself was measured
  if (std::none_of(unusable_rad.begin(), unusable_rad.end(),
                   [&](double t) { return t > low && t < high; }))
    return;
  detail.gap_deg = optics::degrees(0.5 * (high - low));
  constexpr std::ptrdiff_t beside = 3;
  const auto right = upper - profile.theta_rad.begin();
  const auto first = std::max<std::ptrdiff_t>(right - beside, 0);
  const auto last = std::min<std::ptrdiff_t>(right + beside, std::ssize(profile.theta_rad));
  Eigen::VectorXd angle(last - first), value(last - first);
  for (std::ptrdiff_t k = first; k < last; ++k) {
    angle[k - first] = profile.theta_rad[static_cast<std::size_t>(k)];
    value[k - first] = profile.value[static_cast<std::size_t>(k)].value(table);
  }
  const double edge = 0.5 * (value[right - first] + value[right - 1 - first]);
  if (angle.size() < 4) {
    // Too few nodes for a shape: the bridge is not known better than to its own size.
    detail.gap_u = std::numbers::pi * std::abs(edge) * 0.5 *
                   (std::pow(std::sin(low), 2) + std::pow(std::sin(high), 2));
    return;
  }
  const Eigen::Vector3d plain = parabola(angle, value);
  const bool positive = value.minCoeff() > 0;
  const Eigen::Vector3d bell =
      positive ? parabola(angle, value.array().log().matrix()) : Eigen::Vector3d::Zero();
  double by_parabola = 0, by_gaussian = 0;
  constexpr int steps = 200;
  const double step = (high - low) / steps;
  for (int k = 0; k < steps; ++k) {
    const double t = low + (k + 0.5) * step;
    const double weight = std::numbers::pi * std::cos(t) * std::abs(std::sin(t)) * step;
    const auto at = [t](const Eigen::Vector3d& c) { return c[0] + t * (c[1] + t * c[2]); };
    by_parabola += weight * (at(plain) - edge);
    if (positive) by_gaussian += weight * (std::exp(at(bell)) - edge);
  }
  detail.gap_u =
      std::max({std::abs(by_parabola), std::abs(by_gaussian), std::abs(by_parabola - by_gaussian)});
}

DhrDetail integrate(const Profile& profile, const formats::BrdfTable& table) {
  DhrDetail detail;
  const std::vector<double> weight = hemisphere_weights(profile.theta_rad, false);
  const std::vector<double> coarse = hemisphere_weights(profile.theta_rad, true);
  LinearCombination spline, straight;
  for (std::size_t k = 0; k < weight.size(); ++k) {
    spline.add(profile.value[k], std::numbers::pi * weight[k]);
    straight.add(profile.value[k], std::numbers::pi * coarse[k]);
  }
  detail.quadrature_u = 0.5 * std::abs(spline.value(table) - straight.value(table));
  double bends = 0;
  for (bool upper : {true, false}) {
    const double end = upper ? profile.theta_rad.back() : -profile.theta_rad.front();
    const Tail tail = tail_of(profile, table, upper);
    const double share = std::numbers::pi * 0.5 * std::cos(end) * std::cos(end);
    spline.add(tail.level, share);
    const double flat = share * tail.level.value(table);
    // Half of the way between a flat and a straight continuation; that half is its uncertainty.
    const double bend = 0.5 * std::numbers::pi * tail.slope * first_moment(end);
    detail.extrapolation += flat + bend;
    detail.dhr += bend;
    // Both sides may err alike, so their parts add.
    detail.extrapolation_u += extrapolation_share * std::abs(flat);
    bends += std::abs(bend);
  }
  detail.extrapolation_u = std::hypot(detail.extrapolation_u, bends);
  detail.dhr += spline.value(table);
  detail.noise_u = std::sqrt(spline.noise_variance(table));
  detail.shared_u = std::sqrt(spline.shared_variance(table));
  return detail;
}

}  // namespace

double DhrDetail::u() const {
  return std::sqrt(noise_u * noise_u + shared_u * shared_u + quadrature_u * quadrature_u +
                   extrapolation_u * extrapolation_u + polarisation_u * polarisation_u +
                   gap_u * gap_u);
}

std::vector<DhrDetail> add_dhr(formats::BrdfTable& table, const DhrOptions& options) {
  table.dhr = {};
  const auto& points = table.points;
  std::map<double, std::map<long long, Node>> by_wavelength;
  std::map<double, double> incidence;
  std::map<double, std::vector<double>> unusable;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::abs(points.theta_i_deg[i]) > options.normal_incidence_within_deg) continue;
    const State from = state_of(points.polarizer_deg[i]), to = state_of(points.analyzer_deg[i]);
    if (from == other || to == other) continue;
    const double phi = std::abs(std::remainder(points.phi_r_deg[i], 360.0));
    if (phi > 0.05 && phi < 179.95) continue;
    const double theta_r = phi > 90 ? -points.theta_r_deg[i] : points.theta_r_deg[i];
    if (points.used[i] == 0) {
      unusable[points.wavelength_nm[i]].push_back(theta_r * degree);
      continue;
    }
    by_wavelength[points.wavelength_nm[i]][std::llround(theta_r * 1e4)].points[from][to].push_back(
        i);
    incidence[points.wavelength_nm[i]] = points.theta_i_deg[i];
  }
  std::vector<DhrDetail> details;
  for (const auto& [wavelength, nodes] : by_wavelength) {
    std::vector<Profile> profiles;
    std::size_t most = 0;
    for (const Mode& mode : modes) {
      profiles.push_back(profile_of(nodes, mode));
      most = std::max(most, profiles.back().theta_rad.size());
    }
    for (std::size_t m = 0; m < profiles.size(); ++m) {
      const std::size_t count = profiles[m].theta_rad.size();
      if (count < 5 || 10 * count < 9 * most) continue;
      if (profiles[m].reach() < options.min_reach_deg * degree) continue;
      const Profile profile = both_sides(std::move(profiles[m]));
      DhrDetail detail = integrate(profile, table);
      bridge_gap(profile, table, unusable[wavelength], detail);
      detail.wavelength_nm = wavelength;
      detail.theta_i_deg = incidence[wavelength];
      detail.states = modes[m].name;
      if (modes[m].one_polarisation)
        detail.polarisation_u = one_polarisation_share * std::abs(detail.dhr);
      table.dhr.wavelength_nm.push_back(wavelength);
      table.dhr.theta_i_deg.push_back(detail.theta_i_deg);
      table.dhr.dhr.push_back(detail.dhr);
      table.dhr.dhr_u.push_back(detail.u());
      details.push_back(detail);
      break;
    }
  }
  return details;
}

}  // namespace umov::calibrate
