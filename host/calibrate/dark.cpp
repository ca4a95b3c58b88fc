#include "host/calibrate/dark.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

namespace umov::calibrate {

namespace {

struct Mean {
  double value = 0, u = 0;
  std::size_t records = 0;
};

/// Weighted mean; its uncertainty grows with the scatter where that exceeds the weights' (Birge).
Mean weighted_mean(const std::vector<double>& value, const std::vector<double>& variance) {
  Mean mean;
  mean.records = value.size();
  double weight_sum = 0, sum = 0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    weight_sum += 1.0 / variance[i];
    sum += value[i] / variance[i];
  }
  mean.value = sum / weight_sum;
  double chi2 = 0;
  for (std::size_t i = 0; i < value.size(); ++i)
    chi2 += (value[i] - mean.value) * (value[i] - mean.value) / variance[i];
  const double birge =
      value.size() > 1 ? std::max(1.0, chi2 / static_cast<double>(value.size() - 1)) : 1.0;
  mean.u = std::sqrt(birge / weight_sum);
  return mean;
}

std::map<double, std::vector<std::size_t>> by_range(const formats::ScanTable& scan,
                                                    const std::function<bool(std::size_t)>& take) {
  std::map<double, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < scan.size(); ++i)
    if (scan.saturated[i] == 0 && take(i)) groups[scan.gain[i]].push_back(i);
  return groups;
}

DarkLevel level_of(const formats::ScanTable& scan, const NoiseModel& noise, double gain,
                   const std::vector<std::size_t>& rows) {
  std::vector<double> x, y, x2, y2;
  for (std::size_t i : rows) {
    x.push_back(scan.x_v[i]);
    y.push_back(scan.y_v[i]);
    x2.push_back(noise.variance_x(scan.wavelength_nm[i], gain, scan.x_v[i]));
    y2.push_back(noise.variance_y(scan.wavelength_nm[i], gain, scan.x_v[i]));
  }
  const Mean mean_x = weighted_mean(x, x2), mean_y = weighted_mean(y, y2);
  return {gain, mean_x.value, mean_x.u, mean_y.value, mean_y.u, rows.size()};
}

}  // namespace

DarkLevel Dark::at(double gain) const {
  DarkLevel unknown;
  unknown.gain = gain;
  for (const DarkLevel& level : levels) {
    if (level.gain == gain) return level;
    unknown.x_u = std::max(unknown.x_u, std::hypot(level.x_v, level.x_u));
    unknown.y_u = std::max(unknown.y_u, std::hypot(level.y_v, level.y_u));
  }
  return unknown;
}

bool Dark::measured(double gain) const {
  return std::any_of(levels.begin(), levels.end(), [gain](const DarkLevel& level) {
    return level.gain == gain && level.records > 0;
  });
}

Dark find_dark(const formats::ScanTable& scan, const ScanRows& set_up, const NoiseModel& noise) {
  Dark dark;
  const auto closed =
      by_range(scan, [&](std::size_t i) { return set_up.row[i] == RowUse::closed; });
  const auto lit = by_range(scan, [&](std::size_t i) { return set_up.row[i] == RowUse::plain; });
  std::map<double, DarkLevel> levels;
  for (const auto& [gain, rows] : closed) levels[gain] = level_of(scan, noise, gain, rows);
  for (const auto& [gain, rows] : lit) {
    if (levels.contains(gain)) continue;
    // A lock-in phase puts part of strong signals into Y; take the weaker half of the records.
    std::vector<std::size_t> weak = rows;
    std::sort(weak.begin(), weak.end(), [&scan](std::size_t a, std::size_t b) {
      return std::abs(scan.x_v[a]) < std::abs(scan.x_v[b]);
    });
    weak.resize((weak.size() + 1) / 2);
    const DarkLevel quadrature = level_of(scan, noise, gain, weak);
    const double size = std::max(std::abs(quadrature.y_v), quadrature.y_u);
    levels[gain] = {gain, 0.0, size, 0.0, size, 0};
  }
  for (const auto& [gain, level] : levels) dark.levels.push_back(level);
  return dark;
}

Dark find_dark_of_dark_scan(const formats::ScanTable& scan, const NoiseModel& noise) {
  Dark dark;
  for (const auto& [gain, rows] : by_range(scan, [](std::size_t) { return true; }))
    dark.levels.push_back(level_of(scan, noise, gain, rows));
  return dark;
}

Dark merge(const Dark& first, const Dark& second) {
  Dark result;
  for (const DarkLevel& level : first.levels)
    result.levels.push_back(
        level.records == 0 && second.measured(level.gain) ? second.at(level.gain) : level);
  for (const DarkLevel& level : second.levels)
    if (std::none_of(first.levels.begin(), first.levels.end(),
                     [&level](const DarkLevel& own) { return own.gain == level.gain; }))
      result.levels.push_back(level);
  std::sort(result.levels.begin(), result.levels.end(),
            [](const DarkLevel& a, const DarkLevel& b) { return a.gain < b.gain; });
  return result;
}

std::vector<LockinPhase> find_phase(const formats::ScanTable& scan, const ScanRows& set_up,
                                    const NoiseModel& noise, const Dark& dark) {
  std::vector<LockinPhase> phases;
  for (const NoiseModel::Entry& entry : noise.entries) {
    std::vector<double> angle, variance;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (set_up.row[i] != RowUse::plain || scan.saturated[i] != 0) continue;
      if (std::abs(scan.wavelength_nm[i] - entry.wavelength_nm) >= 0.5) continue;
      const DarkLevel level = dark.at(scan.gain[i]);
      const double x = scan.x_v[i] - level.x_v, y = scan.y_v[i] - level.y_v;
      const double y2 =
          noise.variance_y(entry.wavelength_nm, scan.gain[i], scan.x_v[i]) + level.y_u * level.y_u;
      if (!(x > 20.0 * std::sqrt(y2))) continue;  // the angle of a weak signal is biased
      angle.push_back(std::atan2(y, x));
      variance.push_back(y2 / (x * x));
    }
    LockinPhase phase;
    phase.wavelength_nm = entry.wavelength_nm;
    if (!angle.empty()) {
      const Mean mean = weighted_mean(angle, variance);
      phase.phase_rad = mean.value;
      phase.u_rad = mean.u;
    }
    phases.push_back(phase);
  }
  return phases;
}

}  // namespace umov::calibrate
