#include "host/calibrate/noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "host/calibrate/set_up.hpp"
#include "host/errors/error.hpp"
#include "host/formats/order_statistics.hpp"

namespace umov::calibrate {

namespace {

constexpr double wavelength_tolerance_nm = 0.5;
/// Repeats say something about the scatter from this many degrees of freedom on.
constexpr std::size_t enough_repeats = 10;

/// Quantities a repeat must share, in units fine enough for any drive.
using Geometry = std::array<long long, 6>;

long long rounded(double value) {
  return std::isnan(value) ? -999999999LL : std::llround(value * 1e4);
}

Geometry geometry(const formats::ScanTable& scan, std::size_t i) {
  return {rounded(scan.theta_i_deg[i]),   rounded(scan.theta_r_deg[i]),  rounded(scan.phi_r_deg[i]),
          rounded(scan.polarizer_deg[i]), rounded(scan.analyzer_deg[i]), rounded(scan.gain[i])};
}

/// Relative scatter of the monitor between neighbouring records of one light path: half the mean
/// square of differences, which slow drift does not enter. Median-based, so that steps do not
/// count.
double monitor_scatter(const formats::ScanTable& scan, const ScanRows& set_up,
                       const std::vector<std::size_t>& rows) {
  std::vector<double> difference;
  double squares = 0;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const std::size_t a = rows[k - 1], b = rows[k];
    if (set_up.block[a] != set_up.block[b] || set_up.row[a] != set_up.row[b]) continue;
    if (rounded(scan.polarizer_deg[a]) != rounded(scan.polarizer_deg[b])) continue;
    const double mean = 0.5 * (scan.monitor_v[a] + scan.monitor_v[b]);
    if (!(mean > 0)) continue;
    const double d = (scan.monitor_v[b] - scan.monitor_v[a]) / mean;
    if (std::abs(d) > 0.2) continue;  // a filter or another power, not noise
    difference.push_back(std::abs(d));
    squares += d * d;
  }
  if (difference.size() < 2) return 0;
  const double rms = std::sqrt(squares / (2.0 * static_cast<double>(difference.size())));
  const double robust = formats::median(difference) / (0.6745 * std::sqrt(2.0));
  return robust > 0 ? robust : rms;
}

/// Fits the relative term of x/monitor from repeats, the law's other terms held.
void fit_repeats(const formats::ScanTable& scan, const ScanRows& set_up,
                 const std::vector<std::size_t>& rows, NoiseModel::Entry& entry) {
  // Another power is no repeat: it compares the detector's law and weighs another noise.
  const auto power = [&scan](std::size_t i) {
    return std::llround(std::log(scan.monitor_v[i]) / std::log(1.5));
  };
  std::map<std::pair<Geometry, long long>, std::vector<std::size_t>> groups;
  for (std::size_t i : rows)
    if (set_up.row[i] == RowUse::plain && scan.monitor_v[i] > 0)
      groups[{geometry(scan, i), power(i)}].push_back(i);
  struct Group {
    double sum_squares, fixed, signal;
    double dof;
  };
  std::vector<Group> seen;
  NoiseLaw fixed_part = entry.x;
  fixed_part.relative2 = 0;
  for (const auto& [key, members] : groups) {
    if (members.size() < 2) continue;
    double monitor = 0, mean = 0;
    for (std::size_t i : members)
      monitor += scan.monitor_v[i] / static_cast<double>(members.size());
    for (std::size_t i : members)
      mean += scan.x_v[i] / scan.monitor_v[i] * monitor / static_cast<double>(members.size());
    double squares = 0;
    for (std::size_t i : members) {
      const double d = scan.x_v[i] / scan.monitor_v[i] * monitor - mean;
      squares += d * d;
    }
    const double dof = static_cast<double>(members.size() - 1);
    entry.repeat_dof += members.size() - 1;
    seen.push_back(
        {squares, fixed_part.variance(mean, scan.gain[members[0]]), std::abs(mean), dof});
  }
  if (entry.repeat_dof < enough_repeats) return;
  // One-parameter chi-square likelihood in c: Σ dof [s²/V + ln V], V = fixed + c S²; a spike is
  // damped by capping its s²/V at 9, as long as spikes are few: with all of them capped any c would
  // do, and the smallest look best. Repeats of weak signals alone say nothing of c: a broad prior
  // (a factor of 7 in c) about what blocks and monitor say holds it then.
  const double prior = std::log(
      std::max({entry.x.relative2, entry.monitor_relative * entry.monitor_relative, 1e-10}));
  double best = std::numeric_limits<double>::infinity();
  const auto deviance = [&seen, prior](double c) {
    const double away = (std::log(c) - prior) / 2.0;
    double sum = away * away, capped = 0, all = 0;
    for (const Group& g : seen) {
      const double v = std::max(g.fixed + c * g.signal * g.signal, 1e-300);
      const double square = g.sum_squares / (g.dof * v);
      all += g.dof;
      if (square > 9.0) capped += g.dof;
      sum += g.dof * (std::min(square, 9.0) + std::log(v));
    }
    return capped > 0.25 * all ? std::numeric_limits<double>::infinity() : sum;
  };
  const auto consider = [&](double c) {
    const double value = deviance(c);
    if (value < best) {
      best = value;
      entry.repeat_relative2 = c;
    }
  };
  for (int step = 0; step <= 250; ++step) consider(std::pow(10.0, -12.0 + 0.04 * step));
}

/// The voltages are whole numbers of ADC codes (a converter's result that was not averaged
/// further).
bool on_lattice(const formats::ScanTable& scan, double step_v) {
  std::size_t small = 0, off = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double codes = scan.y_v[i] * scan.gain[i] / step_v;
    if (std::abs(codes) > 200) continue;  // the header's step is printed to few digits
    ++small;
    if (std::abs(codes - std::round(codes)) > 0.02) ++off;
  }
  return small >= 10 && off * 20 < small;
}

}  // namespace

bool NoiseModel::has(double wavelength_nm) const {
  return std::any_of(entries.begin(), entries.end(), [wavelength_nm](const Entry& entry) {
    return std::abs(entry.wavelength_nm - wavelength_nm) < wavelength_tolerance_nm;
  });
}

const NoiseModel::Entry& NoiseModel::at(double wavelength_nm) const {
  for (const Entry& entry : entries)
    if (std::abs(entry.wavelength_nm - wavelength_nm) < wavelength_tolerance_nm) return entry;
  throw Error(fmt::format("no noise model at {:g} nm", wavelength_nm),
              "fit the noise on a scan that has this wavelength");
}

namespace {

/// Keeps weights finite for noiseless input; far below any converter.
double with_floor(double variance, double signal_v) {
  return variance + 1e-14 * signal_v * signal_v + 1e-30;
}

}  // namespace

double NoiseModel::variance_x(double wavelength_nm, double gain, double signal_v) const {
  const double q = quantisation_v / gain;
  return with_floor(at(wavelength_nm).x.variance(signal_v, gain) + q * q / 12.0, signal_v);
}

double NoiseModel::variance_y(double wavelength_nm, double gain, double signal_v) const {
  const double q = quantisation_v / gain;
  return with_floor(at(wavelength_nm).y.variance(signal_v, gain) + q * q / 12.0, signal_v);
}

double NoiseModel::variance_normalised(double wavelength_nm, double gain, double signal_v) const {
  const Entry& entry = at(wavelength_nm);
  NoiseLaw law = entry.x;
  law.relative2 = relative2_normalised(wavelength_nm);
  const double q = quantisation_v / gain;
  return with_floor(law.variance(signal_v, gain) + q * q / 12.0, signal_v);
}

double NoiseModel::relative2_normalised(double wavelength_nm) const {
  const Entry& entry = at(wavelength_nm);
  return std::isnan(entry.repeat_relative2)
             ? std::max(entry.x.relative2, entry.monitor_relative * entry.monitor_relative)
             : entry.repeat_relative2;
}

double NoiseModel::variance_floor(double wavelength_nm, double gain, double signal_v) const {
  const double relative = relative2_normalised(wavelength_nm) * signal_v * signal_v;
  return std::max(variance_normalised(wavelength_nm, gain, signal_v) - relative,
                  with_floor(0.0, signal_v));
}

double NoiseModel::dof_normalised(double wavelength_nm, double gain, double signal_v) const {
  const Entry& entry = at(wavelength_nm);
  const double blocks = std::max(1.0, entry.x.dof * static_cast<double>(entry.x.rows));
  if (std::isnan(entry.repeat_relative2)) return blocks;
  const double relative = entry.repeat_relative2 * signal_v * signal_v;
  const double all = variance_normalised(wavelength_nm, gain, signal_v);
  const double floor = std::max(0.0, all - relative);
  const double repeats = static_cast<double>(entry.repeat_dof);
  return all * all / (floor * floor / blocks + relative * relative / repeats);
}

NoiseModel fit_noise(const formats::ScanTable& scan, const NoiseOptions& options) {
  const ScanRows set_up = sort_rows(scan);
  std::vector<double> wavelengths;
  std::vector<std::vector<std::size_t>> rows;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (scan.saturated[i] != 0) continue;
    std::size_t w = 0;
    while (w < wavelengths.size() &&
           std::abs(wavelengths[w] - scan.wavelength_nm[i]) >= wavelength_tolerance_nm)
      ++w;
    if (w == wavelengths.size()) {
      wavelengths.push_back(scan.wavelength_nm[i]);
      rows.emplace_back();
    }
    rows[w].push_back(i);
  }
  if (wavelengths.empty())
    throw Error("the scan has no unsaturated record", "measure with a smaller amplifier range");

  NoiseModel model;
  for (std::size_t w = 0; w < wavelengths.size(); ++w) {
    NoiseModel::Entry entry;
    entry.wavelength_nm = wavelengths[w];
    std::vector<double> x2, y2, signal, gain;
    for (std::size_t i : rows[w]) {
      x2.push_back(scan.x_se_v[i] * scan.x_se_v[i]);
      y2.push_back(scan.y_se_v[i] * scan.y_se_v[i]);
      signal.push_back(std::abs(scan.x_v[i]));
      gain.push_back(scan.gain[i]);
    }
    entry.x = fit_law(x2, signal, gain);
    entry.y = fit_law(y2, signal, gain);
    entry.monitor_relative = monitor_scatter(scan, set_up, rows[w]);
    fit_repeats(scan, set_up, rows[w], entry);
    model.entries.push_back(entry);
  }
  double step = options.adc_step_v;
  if (std::isnan(step)) step = scan.number("adc_step_v").value_or(0.0);
  if (step > 0 && on_lattice(scan, step)) model.quantisation_v = step;
  return model;
}

}  // namespace umov::calibrate
