#include "host/calibrate/mirror_scan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/calibrate/noise.hpp"
#include "host/calibrate/set_up.hpp"
#include "host/errors/error.hpp"

namespace umov::calibrate {

namespace {

constexpr double least_incidence_deg = 5;  ///< nearer to the normal there is no plane of incidence
constexpr double mirror_within_deg = 0.3;

bool in_mirror_direction(const formats::ScanTable& scan, std::size_t i) {
  return std::abs(scan.theta_r_deg[i] - scan.theta_i_deg[i]) <= mirror_within_deg &&
         std::abs(scan.phi_r_deg[i]) <= mirror_within_deg &&
         scan.theta_i_deg[i] >= least_incidence_deg;
}

/// An axis in (-90, 90].
double reduced(double axis_deg) {
  const double r = std::remainder(axis_deg, 180.0);
  return r <= -90.0 ? r + 180.0 : r;
}

bool is_axis(double axis_deg, double wanted_deg) {
  return !formats::is_open(axis_deg) &&
         std::abs(std::remainder(axis_deg - wanted_deg, 180.0)) < 0.5;
}

/// Neither P nor S: +1 or -1 for the side, measured from P or S, whichever is nearer; 0 for P, S
/// and open.
int side_of(double axis_deg) {
  if (formats::is_open(axis_deg) || is_axis(axis_deg, 0) || is_axis(axis_deg, 90)) return 0;
  return std::remainder(reduced(axis_deg), 90.0) > 0 ? 1 : -1;
}

void check_states(const MirrorRecords& records, std::size_t wavelength) {
  std::vector<std::string> missing;
  const auto any = [&](auto&& test) {
    return std::any_of(records.rows.begin(), records.rows.end(), [&](const MirrorRow& row) {
      return row.wavelength == wavelength && test(row.polarizer_deg, row.analyzer_deg);
    });
  };
  const auto need = [&](double polarizer, double analyzer, const char* name) {
    if (!any([&](double p, double a) { return is_axis(p, polarizer) && is_axis(a, analyzer); }))
      missing.push_back(name);
  };
  need(0, 0, "P/P");
  need(90, 90, "S/S");
  need(0, 90, "P/S");
  need(90, 0, "S/P");
  // ±45 has a sign on either side of both P and S; closer to the crossed state it says more.
  const auto oblique_analyzer = [&](int side) {
    return any([side](double p, double a) {
      return (is_axis(p, 0) || is_axis(p, 90)) && side_of(a) == side;
    });
  };
  const auto oblique_polarizer = [&](int side) {
    return any([side](double p, double a) {
      return (is_axis(a, 0) || is_axis(a, 90)) && side_of(p) == side;
    });
  };
  if (!(oblique_analyzer(1) && oblique_analyzer(-1)))
    missing.push_back("the analyser on both sides of the crossed state (such as P/84 and P/96)");
  if (!(oblique_polarizer(1) && oblique_polarizer(-1)))
    missing.push_back("the polariser on both sides of it (such as 84/P and 96/P)");
  if (!missing.empty())
    throw Error(
        fmt::format("at {:g} nm the mirror scan lacks states (polariser/analyser): {}",
                    records.wavelengths_nm[wavelength], fmt::join(missing, ", ")),
        "add them to `states` of the plan; examples/campaign/germanium.toml has a full set");
  std::set<long long> angles;
  bool steep = false, grazing = false;
  for (const MirrorRow& row : records.rows) {
    if (row.wavelength != wavelength) continue;
    angles.insert(std::llround(row.theta_i_deg * 10));
    steep = steep || row.theta_i_deg <= 50;
    grazing = grazing || row.theta_i_deg >= 60;
  }
  if (angles.size() < 4 || !steep || !grazing)
    throw Error(fmt::format("at {:g} nm the mirror scan has {} angles of incidence{}",
                            records.wavelengths_nm[wavelength], angles.size(),
                            !grazing ? ", none from 60 deg up, where s and p differ most"
                            : !steep ? ", none up to 50 deg"
                                     : ""),
                "measure four or more between 20 and 80 deg: they separate polariser from analyser "
                "and the wafer's index from both");
}

/// Sense of the last move of a drive at every record, from the commanded axes in the order of the
/// records. `open` is parked beyond all axes.
std::vector<int> directions(const std::vector<double>& axis_deg) {
  constexpr double parked_deg = 200;
  std::vector<int> result;
  int direction = 1;  // homing ends upwards
  double last = -parked_deg;
  for (double axis : axis_deg) {
    const double now = formats::is_open(axis) ? parked_deg : axis;
    if (std::abs(now - last) > 1e-6) direction = now > last ? 1 : -1;
    last = now;
    result.push_back(direction);
  }
  return result;
}

/// Filters differ by a decade: half a decade either way is the same one.
long long filter_of(double monitor_v, double brightest_v) {
  return std::llround(std::log10(monitor_v / brightest_v));
}

}  // namespace

MirrorRecords mirror_records(const formats::ScanTable& scan, const Dark& known_dark) {
  if (const auto role = scan.key("role"); role.value_or("mirror") != "mirror")
    throw Error(fmt::format("a scan of role `{}` is no mirror scan", *role),
                "scan a wafer with `role = \"mirror\"` in the plan");
  MirrorRecords result;
  const ScanRows set_up = sort_rows(scan);
  const NoiseModel noise = fit_noise(scan);
  const Dark dark = merge(find_dark(scan, set_up, noise), known_dark);
  const auto phases = find_phase(scan, set_up, noise, dark);

  const std::vector<int> polarizer_direction = directions(scan.polarizer_deg);
  const std::vector<int> analyzer_direction = directions(scan.analyzer_deg);
  std::vector<std::size_t> taken;
  std::size_t beside = 0;
  std::map<long long, double> brightest;  // monitor, by wavelength in 0.5 nm
  const auto wave = [&](std::size_t i) { return std::llround(scan.wavelength_nm[i]); };
  std::set<long long> waves;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (set_up.row[i] != RowUse::plain || scan.saturated[i] != 0 || !(scan.monitor_v[i] > 0))
      continue;
    if (!in_mirror_direction(scan, i)) {
      ++beside;
      continue;
    }
    taken.push_back(i);
    waves.insert(wave(i));
    double& monitor = brightest[wave(i)];
    monitor = std::max(monitor, scan.monitor_v[i]);
  }
  if (taken.empty())
    throw Error("the mirror scan has no usable record in the mirror direction",
                "set `theta_r_deg = \"mirror\"` in the plan, and neutral density enough that the "
                "detector does not saturate");
  if (beside > 0)
    result.notes.push_back(fmt::format(
        "{} records of the mirror scan are beside the mirror direction and left out", beside));
  std::map<long long, std::size_t> number;
  for (long long w : waves) {
    number[w] = result.wavelengths_nm.size();
    for (std::size_t i : taken)
      if (wave(i) == w) {
        result.wavelengths_nm.push_back(scan.wavelength_nm[i]);
        break;
      }
  }

  std::map<std::tuple<std::size_t, int, long long>, std::size_t> sets;
  std::map<std::pair<std::size_t, long long>, std::size_t> scales;
  std::set<double> gains;
  using MonitorKey = std::pair<std::size_t, long long>;
  struct Sum {
    double n = 0, sum = 0, squares = 0, axis = 0;
    std::size_t wavelength = 0;
  };
  std::map<MonitorKey, Sum> monitors;
  for (std::size_t i : taken) {
    MirrorRow row;
    row.wavelength = number.at(wave(i));
    const std::tuple key{row.wavelength, set_up.block[i],
                         filter_of(scan.monitor_v[i], brightest.at(wave(i)))};
    row.set = sets.try_emplace(key, sets.size()).first->second;
    if (result.set_wavelength.size() < sets.size()) result.set_wavelength.push_back(row.wavelength);
    const std::pair angle{row.set, std::llround(scan.theta_i_deg[i] * 100)};
    row.scale = scales.try_emplace(angle, scales.size()).first->second;
    if (result.scales.size() < scales.size())
      result.scales.push_back({row.wavelength, row.set, scan.theta_i_deg[i]});
    row.theta_i_deg = scan.theta_i_deg[i];
    row.polarizer_deg = scan.polarizer_deg[i];
    row.analyzer_deg = scan.analyzer_deg[i];
    row.polarizer_direction = polarizer_direction[i];
    row.analyzer_direction = analyzer_direction[i];
    row.gain = scan.gain[i];
    row.monitor_v = scan.monitor_v[i];
    double phase = 0;
    for (const LockinPhase& p : phases)
      if (std::abs(p.wavelength_nm - scan.wavelength_nm[i]) < 0.5) phase = p.phase_rad;
    const DarkLevel level = dark.at(row.gain);
    row.signal_v =
        (scan.x_v[i] - level.x_v) * std::cos(phase) + (scan.y_v[i] - level.y_v) * std::sin(phase);
    // The source's own fluctuation is in the block scatter, and in the monitor too: what the ratio
    // of both keeps of it is learned from the residuals.
    NoiseLaw law = noise.at(scan.wavelength_nm[i]).x;
    law.relative2 = 0;
    row.variance_v2 = law.variance(scan.x_v[i], row.gain) +
                      std::pow(noise.quantisation_v / row.gain, 2) / 12.0 + level.x_u * level.x_u +
                      1e-14 * scan.x_v[i] * scan.x_v[i];
    gains.insert(row.gain);
    Sum& sum = monitors[{row.set, formats::is_open(row.polarizer_deg)
                                      ? -100000LL
                                      : std::llround(reduced(row.polarizer_deg) * 100)}];
    const double log_monitor = std::log(row.monitor_v);
    sum.n += 1;
    sum.sum += log_monitor;
    sum.squares += log_monitor * log_monitor;
    sum.axis = row.polarizer_deg;
    sum.wavelength = row.wavelength;
    result.rows.push_back(row);
  }
  result.sets = sets.size();
  result.gains.assign(gains.begin(), gains.end());
  for (const auto& [key, sum] : monitors) {
    const double mean = sum.sum / sum.n;
    const double variance =
        sum.n > 1 ? std::max(0.0, (sum.squares / sum.n - mean * mean) * sum.n / (sum.n - 1)) : 0.01;
    // The source's slow drift between the states is in the scatter only in part.
    constexpr double drift_u = 0.005;
    result.monitors.push_back({sum.wavelength, key.first, sum.axis, mean,
                               std::sqrt(variance / sum.n + drift_u * drift_u)});
  }
  for (std::size_t w = 0; w < result.wavelengths_nm.size(); ++w) check_states(result, w);
  return result;
}

}  // namespace umov::calibrate
