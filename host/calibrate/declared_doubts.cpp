#include "host/calibrate/declared_doubts.hpp"

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
  std::map<double, std::pair<double, int>> sum;
  std::vector<double> angle, value;

  void close() {
    for (const auto& [at, cell] : sum) {
      angle.push_back(at);
      value.push_back(cell.first / cell.second);
    }
  }

  std::optional<double> at(double theta_r) const {
    const auto high = std::lower_bound(angle.begin(), angle.end(), theta_r);
    if (high == angle.end()) return std::nullopt;
    const auto k = static_cast<std::size_t>(high - angle.begin());
    if (angle[k] - theta_r < 1e-4) return value[k];
    if (k == 0) return std::nullopt;
    const double t = (theta_r - angle[k - 1]) / (angle[k] - angle[k - 1]);
    return (1 - t) * value[k - 1] + t * value[k];
  }

  /// First and second derivative of the parabola through an angle and its neighbours.
  std::array<double, 2> derivatives(double theta_r) const {
    const auto place = std::lower_bound(angle.begin(), angle.end(), theta_r - 1e-4);
    if (place == angle.end() || angle.size() < 2) return {0, 0};
    auto k = static_cast<std::size_t>(place - angle.begin());
    if (angle.size() == 2) return {(value[1] - value[0]) / (angle[1] - angle[0]), 0};
    const double at = angle[k];
    k = std::min(std::max<std::size_t>(k, 1), angle.size() - 2);
    const double left = (value[k] - value[k - 1]) / (angle[k] - angle[k - 1]);
    const double right = (value[k + 1] - value[k]) / (angle[k + 1] - angle[k]);
    const double second = 2.0 * (right - left) / (angle[k + 1] - angle[k - 1]);
    const double middle = 0.5 * (angle[k] + angle[k - 1]);
    return {left + second * (at - middle), second};
  }
};

}  // namespace

AngleSlopes angle_slopes(const formats::BrdfTable::Points& points) {
  std::map<Channel, std::map<double, Line>> channels;
  const auto channel_of = [&points](std::size_t i) {
    return Channel{rounded(points.wavelength_nm[i]), rounded(points.polarizer_deg[i]),
                   rounded(points.analyzer_deg[i]), rounded(points.phi_r_deg[i])};
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.used[i] == 0) continue;
    auto& cell = channels[channel_of(i)][points.theta_i_deg[i]].sum[points.theta_r_deg[i]];
    cell.first += points.brdf_per_sr[i];
    cell.second += 1;
  }
  for (auto& [channel, lines] : channels)
    for (auto& [theta_i, line] : lines) line.close();

  AngleSlopes slopes;
  slopes.detector.assign(points.size(), 0.0);
  slopes.incidence = slopes.curvature = slopes.detector;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto channel = channels.find(channel_of(i));
    if (channel == channels.end()) continue;
    const auto& lines = channel->second;
    const auto own = lines.find(points.theta_i_deg[i]);
    if (own == lines.end()) continue;
    const double theta_r = points.theta_r_deg[i];
    const auto [first, second] = own->second.derivatives(theta_r);
    slopes.curvature[i] = second;
    slopes.detector[i] =
        first - points.brdf_per_sr[i] * std::tan(optics::radians(theta_r)) * optics::radians(1.0);
    // With both arms moved together the lobe stays in place; what is left changes slowly.
    double together = 0;
    int neighbours = 0;
    const auto compare = [&](double theta_i, const Line& line) {
      const double moved = theta_i - points.theta_i_deg[i];
      if (const auto there = line.at(theta_r + moved)) {
        together += (*there - points.brdf_per_sr[i]) / moved;
        ++neighbours;
      }
    };
    if (own != lines.begin()) compare(std::prev(own)->first, std::prev(own)->second);
    if (std::next(own) != lines.end()) compare(std::next(own)->first, std::next(own)->second);
    if (neighbours > 0) together /= neighbours;
    slopes.incidence[i] = together - first * std::cos(optics::radians(points.phi_r_deg[i]));
  }
  return slopes;
}

}  // namespace umov::calibrate
