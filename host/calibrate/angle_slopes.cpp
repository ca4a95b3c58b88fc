#include "host/calibrate/angle_slopes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "host/formats/scan_table.hpp"
#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

long long rounded(double value) {
  return std::isnan(value) ? -999999999LL : std::llround(value * 1e4);
}

/// Wavelength, states and azimuth.
using Channel = std::array<long long, 4>;

/// Detector angle -> mean BRDF of one channel and incidence.
struct Line {
  struct Cell {
    double sum = 0, variance = 0;
    int count = 0;
  };
  std::map<double, Cell> cells;
  std::vector<double> angle, value;
  std::vector<bool> clear;  ///< well above the noise: its logarithm may be taken

  void close() {
    for (const auto& [at, cell] : cells) {
      angle.push_back(at);
      value.push_back(cell.sum / cell.count);
      clear.push_back(cell.sum > 5 * std::sqrt(cell.variance));
    }
  }

  /// Logarithm of the BRDF, by straight lines between points; nullopt beyond the line's ends and
  /// where the BRDF is not clear.
  std::optional<double> log_at(double theta_r) const {
    const auto high = std::lower_bound(angle.begin(), angle.end(), theta_r - 1e-4);
    if (high == angle.end()) return std::nullopt;
    const auto k = static_cast<std::size_t>(high - angle.begin());
    const bool on_point = std::abs(angle[k] - theta_r) < 1e-4;
    if (!clear[k] || (!on_point && (k == 0 || !clear[k - 1]))) return std::nullopt;
    if (on_point) return std::log(value[k]);
    const double t = (theta_r - angle[k - 1]) / (angle[k] - angle[k - 1]);
    return (1 - t) * std::log(value[k - 1]) + t * std::log(value[k]);
  }

  /// First and second derivative at an angle, of the parabola through it and its neighbours.
  std::array<double, 2> derivatives(double theta_r) const {
    const auto place = std::lower_bound(angle.begin(), angle.end(), theta_r - 1e-4);
    if (place == angle.end() || angle.size() < 2) return {0, 0};
    auto k = static_cast<std::size_t>(place - angle.begin());
    if (angle.size() == 2) return {(value[1] - value[0]) / (angle[1] - angle[0]), 0};
    const double at = angle[k], f = value[k];
    k = std::min(std::max<std::size_t>(k, 1), angle.size() - 2);
    const bool logarithmic = clear[k - 1] && clear[k] && clear[k + 1];
    const auto y = [&](std::size_t i) { return logarithmic ? std::log(value[i]) : value[i]; };
    const double left = (y(k) - y(k - 1)) / (angle[k] - angle[k - 1]);
    const double right = (y(k + 1) - y(k)) / (angle[k + 1] - angle[k]);
    const double second = 2.0 * (right - left) / (angle[k + 1] - angle[k - 1]);
    const double first = left + second * (at - 0.5 * (angle[k] + angle[k - 1]));
    if (!logarithmic) return {first, second};
    return {f * first, f * (second + first * first)};
  }
};

/// Lines of one channel by incidence.
using Lines = std::map<double, Line>;

/// d ln f/dθi at an incidence along one way through the neighbouring ones, per degree.
struct AlongIncidence {
  double slope = 0;
  double change = 0;  ///< largest change of ln f from one incidence to the next
};

/// Where θr follows θi by `follow` (1: a lobe stays in place, 0: θr stands still). From the
/// parabola through the three incidences about this one. Nullopt without a neighbour.
std::optional<AlongIncidence> along_incidence(const Lines& lines, Lines::const_iterator own,
                                              double theta_r, double follow) {
  std::vector<std::array<double, 2>> at;  // θi - own, ln f; nearest neighbours on either side first
  const auto take = [&](Lines::const_iterator line) {
    const double moved = line->first - own->first;
    if (const auto f = line->second.log_at(theta_r + follow * moved)) at.push_back({moved, *f});
  };
  const auto here = own->second.log_at(theta_r);
  if (!here) return std::nullopt;
  if (own != lines.begin()) take(std::prev(own));
  if (std::next(own) != lines.end()) take(std::next(own));
  if (at.size() == 1) {  // at the end of the incidences: the next but one on the same side
    if (at[0][0] > 0 && std::next(own, 2) != lines.end()) take(std::next(own, 2));
    if (at[0][0] < 0 && std::distance(lines.begin(), own) >= 2) take(std::prev(own, 2));
  }
  if (at.empty()) return std::nullopt;
  AlongIncidence result;
  for (const auto& [moved, f] : at) result.change = std::max(result.change, std::abs(f - *here));
  const double first = (at[0][1] - *here) / at[0][0];
  if (at.size() == 1) return AlongIncidence{first, result.change};
  const double second = (at[1][1] - *here) / at[1][0];
  result.slope = (first * at[1][0] - second * at[0][0]) / (at[1][0] - at[0][0]);
  return result;
}

}  // namespace

AngleSlopes angle_slopes(const formats::BrdfTable::Points& points) {
  std::map<Channel, Lines> channels;
  const auto channel_of = [&points](std::size_t i) {
    return Channel{rounded(points.wavelength_nm[i]), rounded(points.polarizer_deg[i]),
                   rounded(points.analyzer_deg[i]), rounded(points.phi_r_deg[i])};
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.used[i] == 0) continue;
    auto& cell = channels[channel_of(i)][points.theta_i_deg[i]].cells[points.theta_r_deg[i]];
    cell.sum += points.brdf_per_sr[i];
    cell.variance += points.brdf_u[i] * points.brdf_u[i];
    ++cell.count;
  }
  for (auto& [channel, lines] : channels)
    for (auto& [theta_i, line] : lines) line.close();

  AngleSlopes slopes;
  slopes.detector.assign(points.size(), 0.0);
  slopes.incidence = slopes.slope = slopes.curvature = slopes.detector;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto channel = channels.find(channel_of(i));
    if (channel == channels.end()) continue;
    const auto& lines = channel->second;
    const auto own = lines.find(points.theta_i_deg[i]);
    if (own == lines.end()) continue;
    const double theta_r = points.theta_r_deg[i];
    const auto [first, second] = own->second.derivatives(theta_r);
    slopes.slope[i] = first;
    slopes.curvature[i] = second;
    slopes.detector[i] =
        first - points.brdf_per_sr[i] * std::tan(optics::radians(theta_r)) * optics::radians(1.0);
    // With both arms moved together a lobe stays in place and what is left changes slowly; what
    // goes with the exit angle alone, as at grazing, changes slowly where the detector stands
    // still.
    const auto with_lobe = along_incidence(lines, own, theta_r, 1.0);
    const auto standing = along_incidence(lines, own, theta_r, 0.0);
    const double f = points.brdf_per_sr[i];
    if (standing && (!with_lobe || standing->change < with_lobe->change))
      slopes.incidence[i] = f * standing->slope;
    else
      slopes.incidence[i] = (with_lobe ? f * with_lobe->slope : 0.0) -
                            first * std::cos(optics::radians(points.phi_r_deg[i]));
  }
  return slopes;
}

AngleSlopes angle_slopes(const formats::BrdfTable::Points& points, const BrdfShape& shape) {
  constexpr double step_deg = 0.05;
  AngleSlopes slopes;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto at = [&](double by_incidence_deg, double by_detector_deg) {
      return shape(points.theta_i_deg[i] + by_incidence_deg,
                   points.theta_r_deg[i] + by_detector_deg, points.phi_r_deg[i],
                   points.wavelength_nm[i], points.polarizer_deg[i], points.analyzer_deg[i]);
    };
    const double middle = at(0, 0), low = at(0, -step_deg), high = at(0, step_deg);
    const double scale = middle > 0 ? points.brdf_per_sr[i] / middle : 0.0;
    const double slope = scale * (high - low) / (2 * step_deg);
    slopes.slope.push_back(slope);
    slopes.curvature.push_back(scale * (high - 2 * middle + low) / (step_deg * step_deg));
    slopes.detector.push_back(slope - points.brdf_per_sr[i] * optics::radians(1.0) *
                                          std::tan(optics::radians(points.theta_r_deg[i])));
    slopes.incidence.push_back(scale * (at(step_deg, 0) - at(-step_deg, 0)) / (2 * step_deg));
  }
  return slopes;
}

}  // namespace umov::calibrate
