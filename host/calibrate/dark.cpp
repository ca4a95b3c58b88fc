#include "host/calibrate/dark.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <Eigen/Dense>

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

/// The part of Y that does not go with X, by range: a lock-in phase puts a share of the signal into
/// Y, one of its own at each wavelength and the same in all ranges, where an offset of the
/// electronics stands still. Least squares, widened by its scatter.
std::map<double, Mean> quadrature_offsets(const formats::ScanTable& scan, const NoiseModel& noise,
                                          const std::map<double, std::vector<std::size_t>>& lit) {
  const auto lines = static_cast<Eigen::Index>(noise.entries.size());
  const auto size = lines + static_cast<Eigen::Index>(lit.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
  const auto visit = [&](auto&& take) {
    Eigen::Index offset = lines;
    for (const auto& [gain, rows] : lit) {
      for (std::size_t i : rows) {
        const NoiseModel::Entry& entry = noise.at(scan.wavelength_nm[i]);
        take(i, offset, &entry - noise.entries.data(),
             1.0 / noise.variance_y(entry.wavelength_nm, gain, scan.x_v[i]));
      }
      ++offset;
    }
  };
  std::size_t records = 0;
  visit([&](std::size_t i, Eigen::Index offset, Eigen::Index line, double w) {
    const double x = scan.x_v[i];
    normal(line, line) += w * x * x;
    normal(offset, offset) += w;
    normal(line, offset) += w * x;
    normal(offset, line) += w * x;
    right(line) += w * x * scan.y_v[i];
    right(offset) += w * scan.y_v[i];
    ++records;
  });
  // Signals of one size alone tell no slope; it is then taken as nearly none.
  const Eigen::VectorXd unit = normal.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  Eigen::MatrixXd scaled = unit.asDiagonal() * normal * unit.asDiagonal();
  scaled.topLeftCorner(lines, lines).diagonal().array() += 1e-6;
  const Eigen::LDLT<Eigen::MatrixXd> solver(scaled);
  const Eigen::VectorXd solution = unit.cwiseProduct(solver.solve(unit.cwiseProduct(right)));
  const Eigen::MatrixXd covariance =
      unit.asDiagonal() * solver.solve(Eigen::MatrixXd::Identity(size, size)) * unit.asDiagonal();
  double chi2 = 0;
  visit([&](std::size_t i, Eigen::Index offset, Eigen::Index line, double w) {
    const double r = scan.y_v[i] - solution(offset) - solution(line) * scan.x_v[i];
    chi2 += w * r * r;
  });
  const double dof = static_cast<double>(records) - static_cast<double>(size);
  const double widening = dof > 0 ? std::max(1.0, chi2 / dof) : 1.0;
  std::map<double, Mean> result;
  Eigen::Index offset = lines;
  for (const auto& [gain, rows] : lit) {
    result[gain] = {solution(offset), std::sqrt(widening * covariance(offset, offset)),
                    rows.size()};
    ++offset;
  }
  return result;
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
  for (const auto& [gain, quadrature] : quadrature_offsets(scan, noise, lit)) {
    if (levels.contains(gain)) continue;
    const double size = std::max(std::abs(quadrature.value), quadrature.u);
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

Dark pool(const std::vector<Dark>& scans) {
  struct Levels {
    std::vector<double> x, x2, y, y2;
    std::size_t records = 0;
  };
  std::map<double, Levels> ranges;
  for (const Dark& scan : scans)
    for (const DarkLevel& level : scan.levels) {
      if (level.records == 0) continue;
      Levels& range = ranges[level.gain];
      range.x.push_back(level.x_v);
      range.x2.push_back(level.x_u * level.x_u);
      range.y.push_back(level.y_v);
      range.y2.push_back(level.y_u * level.y_u);
      range.records += level.records;
    }
  Dark result;
  for (const auto& [gain, range] : ranges) {
    const Mean x = weighted_mean(range.x, range.x2), y = weighted_mean(range.y, range.y2);
    result.levels.push_back({gain, x.value, x.u, y.value, y.u, range.records});
  }
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
