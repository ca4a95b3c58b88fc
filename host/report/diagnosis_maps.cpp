// Residuals of a diagnosis over the angles, and in the order of measurement.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "host/report/diagnosis_parts.hpp"
#include "host/report/json_parts.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {

namespace {

using gap::scan::Picture;

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double most_columns = 120;
constexpr double coarse_columns = 18;
/// A record's colour reaches to its neighbours no further than this, degrees.
constexpr double widest_gap_deg = 12;
constexpr std::size_t trace_points = 240;

/// Of values; the list is taken apart.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

struct Row {
  std::size_t setup;
  double theta_i_deg;
  int direction;  ///< 0: one direction only
  auto operator<=>(const Row&) const = default;
};

struct Grid {
  double from = 0, step = 1;
  std::size_t columns = 1;
  std::vector<double> centres() const {
    std::vector<double> x;
    for (std::size_t c = 0; c < columns; ++c) x.push_back(from + step * static_cast<double>(c));
    return x;
  }
};

using Panel = std::pair<std::size_t, std::size_t>;  ///< channel, wavelength
using Lines = std::map<Panel, std::map<Row, std::vector<std::size_t>>>;

/// A regular grid about as fine as the scan is, with `most` columns.
Grid grid_of(const Scene& scene, const Lines& lines, double most) {
  double low = 1e300, high = -1e300;
  std::vector<double> spacing;
  for (const auto& [panel, rows] : lines) {
    for (const auto& [row, records] : rows) {
      double last = nothing;
      for (const std::size_t i : records) {
        const double theta = scene.theta_r_deg(i);
        low = std::min(low, theta);
        high = std::max(high, theta);
        if (theta - last > 1e-3) spacing.push_back(theta - last);
        last = theta;
      }
    }
  }
  Grid grid;
  grid.from = low;
  grid.step = std::clamp(spacing.empty() ? 1.0 : quantile(spacing, 0.5),
                         std::max(1e-3, (high - low) / most), 10.0);
  grid.columns = static_cast<std::size_t>(std::floor((high - low) / grid.step + 0.5)) + 1;
  return grid;
}

/// Values of one row's records on the grid: means where records fall, the nearest one's between
/// them, nothing beyond.
std::vector<double> gridded(const Scene& scene, const Grid& grid,
                            const std::vector<std::size_t>& records,
                            const std::vector<double>& value) {
  std::vector<double> sum(grid.columns, 0.0), count(grid.columns, 0.0), out(grid.columns, nothing);
  std::vector<std::pair<double, double>> points;
  for (const std::size_t i : records) {
    if (!std::isfinite(value[i])) continue;
    const double theta = scene.theta_r_deg(i);
    points.emplace_back(theta, value[i]);
    const auto column = static_cast<std::size_t>(std::clamp(
        std::round((theta - grid.from) / grid.step), 0.0, static_cast<double>(grid.columns - 1)));
    sum[column] += value[i];
    count[column] += 1;
  }
  for (std::size_t c = 0; c < grid.columns; ++c) {
    if (count[c] > 0) {
      out[c] = sum[c] / count[c];
      continue;
    }
    const double x = grid.from + grid.step * static_cast<double>(c);
    const auto above = std::lower_bound(points.begin(), points.end(), std::pair(x, -1e300));
    if (above == points.begin() || above == points.end()) continue;
    const auto below = above - 1;
    if (above->first - below->first > widest_gap_deg) continue;
    out[c] = x - below->first < above->first - x ? below->second : above->second;
  }
  return out;
}

/// Sums over the records of a row that fall into each column.
std::vector<double> summed(const Scene& scene, const Grid& grid,
                           const std::vector<std::size_t>& records,
                           const std::vector<double>& value) {
  std::vector<double> sum(grid.columns, 0.0);
  for (const std::size_t i : records)
    if (std::isfinite(value[i]))
      sum[static_cast<std::size_t>(
          std::clamp(std::round((scene.theta_r_deg(i) - grid.from) / grid.step), 0.0,
                     static_cast<double>(grid.columns - 1)))] += value[i];
  return sum;
}

/// Residuals of a panel's records, one entry a record of the whole picture.
struct PanelValues {
  std::vector<double> before, after, scale, count, precision;
};

PanelValues values_of(const Picture& p, const std::map<Row, std::vector<std::size_t>>& rows,
                      bool quadrature) {
  std::vector<double> none(p.records.size(), nothing);
  PanelValues v{none, none, none, none, none};
  for (const auto& [row, records] : rows) {
    for (const std::size_t i : records) {
      if (p.records[i].saturated) continue;
      v.before[i] = normalised(p, i, quadrature, false);
      v.after[i] = normalised(p, i, quadrature, true);
      v.scale[i] = percent_per_sigma(p, i, quadrature);
      v.count[i] = 1;
      v.precision[i] = 1 / (v.scale[i] * v.scale[i]);
    }
  }
  return v;
}

/// Each record by itself.
Json fine_rows(const Scene& scene, const Grid& grid, const std::set<Row>& rows,
               const std::map<Row, std::vector<std::size_t>>& own, const PanelValues& v) {
  Json z{{"before", Json::array()}, {"after", Json::array()}, {"scale", Json::array()}};
  for (const Row& row : rows) {
    const auto found = own.find(row);
    const std::vector<std::size_t> none;
    const auto& records = found == own.end() ? none : found->second;
    z["before"].push_back(rounded(gridded(scene, grid, records, v.before), 3));
    z["after"].push_back(rounded(gridded(scene, grid, records, v.after), 3));
    z["scale"].push_back(rounded(gridded(scene, grid, records, v.scale), 3));
  }
  return z;
}

/// Neighbours together: Σz/√n, in which what they share stands out of their noise.
Json coarse_rows(const Scene& scene, const Grid& grid, const std::set<Row>& rows,
                 const std::map<Row, std::vector<std::size_t>>& own, const PanelValues& v) {
  Json z{{"before", Json::array()}, {"after", Json::array()}, {"scale", Json::array()}};
  for (const Row& row : rows) {
    const auto found = own.find(row);
    const std::vector<std::size_t> none;
    const auto& records = found == own.end() ? none : found->second;
    std::vector<double> before = summed(scene, grid, records, v.before);
    std::vector<double> after = summed(scene, grid, records, v.after);
    const std::vector<double> count = summed(scene, grid, records, v.count);
    std::vector<double> scale = summed(scene, grid, records, v.precision);
    for (std::size_t c = 0; c < grid.columns; ++c) {
      before[c] /= std::sqrt(count[c]);
      after[c] /= std::sqrt(count[c]);
      scale[c] = scale[c] > 0 ? 1 / std::sqrt(scale[c]) : nothing;
    }
    z["before"].push_back(rounded(before, 3));
    z["after"].push_back(rounded(after, 3));
    z["scale"].push_back(rounded(scale, 3));
  }
  return z;
}

/// One group of rows: the plain scan, or all further set-ups.
Json map_set(const Scene& scene, const std::string& title, const Lines& lines) {
  const Picture& p = *scene.picture;
  std::set<Row> rows;
  for (const auto& [panel, own] : lines)
    for (const auto& [row, records] : own) rows.insert(row);
  const Grid fine = grid_of(scene, lines, most_columns);
  Grid coarse = fine;
  const double reach = fine.step * static_cast<double>(fine.columns);
  coarse.step = std::max(fine.step, reach / coarse_columns);
  coarse.columns = static_cast<std::size_t>(std::ceil(reach / coarse.step - 1e-9));
  coarse.from = fine.from + 0.5 * (coarse.step - fine.step);
  Json labels = Json::array();
  for (const Row& row : rows) {
    std::string label = plain(row.theta_i_deg) + "°";
    if (row.direction != 0) label += row.direction > 0 ? " ↑" : " ↓";
    if (row.setup != 0) label = scene.setups[row.setup] + ", θi = " + label;
    labels.push_back(label);
  }
  Json panels = Json::array();
  for (const auto& [panel, own] : lines) {
    Json out{{"channel", scene.channels[panel.first]},
             {"wavelength_nm", rounded(p.wavelengths_nm[panel.second], 6)}};
    for (const bool quadrature : {false, true}) {
      const PanelValues values = values_of(p, own, quadrature);
      out[quadrature ? "y" : "x"] = {{"fine", fine_rows(scene, fine, rows, own, values)},
                                     {"coarse", coarse_rows(scene, coarse, rows, own, values)}};
    }
    Json saturated = Json::array();
    for (const auto& [row, records] : own)
      for (const std::size_t i : records)
        if (p.records[i].saturated)
          saturated.push_back({scene.theta_r_deg(i), std::distance(rows.begin(), rows.find(row))});
    if (!saturated.empty()) out["saturated"] = std::move(saturated);
    panels.push_back(std::move(out));
  }
  return {{"title", title},
          {"theta_r_deg",
           {{"fine", rounded(fine.centres(), 5)}, {"coarse", rounded(coarse.centres(), 5)}}},
          {"rows", std::move(labels)},
          {"panels", std::move(panels)}};
}

}  // namespace

Json residual_maps(const Scene& scene) {
  const Picture& p = *scene.picture;
  Lines plain_lines, further;
  std::vector<double> sigmas, percents;
  for (std::size_t i = 0; i < p.records.size(); ++i) {
    const gap::scan::Record& r = p.records[i];
    const Row row{scene.setup[i], scene.theta_i_deg(i), scene.direction[i]};
    (scene.setup[i] == 0 ? plain_lines : further)[{scene.channel[i], r.wavelength}][row].push_back(
        i);
    if (r.saturated) continue;
    const double z = std::abs(normalised(p, i, false, false));
    const double percent = z * percent_per_sigma(p, i, false);
    sigmas.push_back(z);
    if (std::isfinite(percent)) percents.push_back(percent);
  }
  for (Lines* lines : {&plain_lines, &further})
    for (auto& [panel, rows] : *lines)
      for (auto& [row, records] : rows)
        std::stable_sort(records.begin(), records.end(), [&](std::size_t a, std::size_t b) {
          return scene.theta_r_deg(a) < scene.theta_r_deg(b);
        });
  Json sets = Json::array();
  if (!plain_lines.empty())
    sets.push_back(map_set(scene, "in the plane of incidence", plain_lines));
  if (!further.empty()) sets.push_back(map_set(scene, "further set-ups", further));
  return {{"wavelengths_nm", rounded(p.wavelengths_nm, 6)},
          {"channels", scene.channels},
          {"clip_sigma", rounded(std::clamp(quantile(sigmas, 0.98), 4.0, 8.0), 2)},
          {"clip_percent", rounded(std::clamp(quantile(percents, 0.9), 0.2, 50.0), 2)},
          {"sets", std::move(sets)}};
}

Json residual_trace(const Scene& scene) {
  const Picture& p = *scene.picture;
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < p.records.size(); ++i) {
    const gap::scan::Record& r = p.records[i];
    if (!r.saturated && r.shutter_open && !r.sample_removed && !r.long_pass) used.push_back(i);
  }
  std::vector<double> record, before, after, u;
  const std::size_t block = std::max<std::size_t>(5, used.size() / trace_points);
  for (std::size_t first = 0; first + block <= used.size(); first += block) {
    double weight = 0, before_sum = 0, after_sum = 0;
    for (std::size_t k = first; k < first + block; ++k) {
      const std::size_t i = used[k];
      // The most likely relative deviation that these records share.
      const double steepness = p.best.x_v[i] / p.sigma.x_v[i];
      weight += steepness * steepness;
      before_sum += steepness * normalised(p, i, false, false);
      after_sum += steepness * normalised(p, i, false, true);
    }
    record.push_back(static_cast<double>(used[first + block / 2] + 1));
    before.push_back(100 * before_sum / weight);
    after.push_back(100 * after_sum / weight);
    u.push_back(100 / std::sqrt(weight));
  }
  return {{"block", block},
          {"record", rounded(record, 7)},
          {"before", rounded(before, 4)},
          {"after", rounded(after, 4)},
          {"u", rounded(u, 3)}};
}

}  // namespace umov::report
