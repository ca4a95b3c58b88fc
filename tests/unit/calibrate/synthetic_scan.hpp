// Scans made by the nominal signal formula with chosen gain, instrument function and noise.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "host/formats/scan_table.hpp"

namespace umov::calibrate::test {

constexpr double degree = std::numbers::pi / 180.0;
inline const double open_axis = std::nan("");

/// BRDF seen through polariser and analyser, 1/sr.
using Brdf = std::function<double(double theta_i, double theta_r, double wavelength,
                                  double polarizer, double analyzer)>;

/// Depolarising sample whose total BRDF is `total`.
inline Brdf depolarising(std::function<double(double theta_r, double wavelength)> total) {
  return [total](double, double theta_r, double wavelength, double, double analyzer) {
    return total(theta_r, wavelength) * (std::isnan(analyzer) ? 1.0 : 0.5);
  };
}

inline Brdf lambertian(double rho) {
  return depolarising([rho](double, double) { return rho / std::numbers::pi; });
}

/// In plane: total BRDF t, Mueller elements relative to it m01 (incident Q), m10, m11.
inline Brdf polarising(std::function<double(double)> total, double m01, double m10, double m11) {
  return [=](double, double theta_r, double, double polarizer, double analyzer) {
    const double in = std::isnan(polarizer) ? 0.0 : -std::cos(2 * polarizer * degree);
    const double i = 1.0 + m01 * in, q = m10 + m11 * in;
    const double t = total(theta_r);
    if (std::isnan(analyzer)) return t * i;
    return t * 0.5 * (i - std::cos(2 * analyzer * degree) * q);
  };
}

struct Instrument {
  std::map<double, double> gain_constant = {{532, 600.0}, {633, 700.0}, {814, 520.0}};
  std::function<double(double)> instrument_function = [](double) { return 1.0; };
  std::function<double(double)> dark_v = [](double) { return 0.0; };       ///< of range
  std::function<double(double)> range_error = [](double) { return 0.0; };  ///< of range
  double phase_rad = 0;
  double bias = 0;
  double base_v = 1e-6, adc_v = 1e-4, shot_v = 2e-9, relative = 5e-4;
  double monitor_relative = 0;  ///< noise of the monitor alone
  double source_relative = 0;   ///< fluctuation that signal and monitor share, a record
  double slow_relative = 0;     ///< of the signal from record to record, unseen by block scatter
  double solid_angle_sr = 1e-4;
  int block_dof = 9;
  double power = 1;        ///< of the source: signal and monitor go with it
  double kappa_per_v = 0;  ///< the detector reads S/(1 + κS)
  std::function<double(double)> stray_per_sr = [](double) { return 0.0; };  ///< of θr
};

struct Plan {
  std::vector<double> wavelengths = {532};
  std::vector<double> theta_i = {0};
  double from = -84, to = 84, step = 4;
  std::vector<std::pair<double, double>> states = {{open_axis, open_axis}};
  double gain =
      0;  ///< 0 = by signal: up to .15 V range 10, up to .015 V range 100, below .0015 V 1000
  int repeats = 1;
};

inline double auto_range(double signal) {
  const double s = std::abs(signal);
  return s > 0.15 ? 1 : s > 0.015 ? 10 : s > 0.0015 ? 100 : 1000;
}

inline void add_record(formats::ScanTable& scan, const Instrument& instrument,
                       std::mt19937_64& random, double theta_i, double theta_r, double wavelength,
                       double polarizer, double analyzer, double gain, double nominal_v,
                       bool shutter_open) {
  std::normal_distribution<double> normal;
  std::chi_squared_distribution<double> chi2(instrument.block_dof);
  const double source = instrument.power * (1.0 + instrument.source_relative * normal(random));
  double s =
      shutter_open ? nominal_v * source * (1.0 + instrument.slow_relative * normal(random)) : 0.0;
  if (gain == 0) gain = auto_range(s);
  s = s / (1.0 + instrument.kappa_per_v * s) * (1.0 + instrument.range_error(gain));
  const double variance =
      instrument.base_v * instrument.base_v + instrument.adc_v * instrument.adc_v / (gain * gain) +
      instrument.shot_v * std::abs(s) + instrument.relative * instrument.relative * s * s;
  const double variance_y = variance - instrument.relative * instrument.relative * s * s;
  const auto se = [&](double v) { return std::sqrt(v * chi2(random) / instrument.block_dof); };
  scan.index.push_back(static_cast<std::int64_t>(scan.index.size()));
  scan.time_s.push_back(0.1 * static_cast<double>(scan.index.size()));
  scan.theta_i_deg.push_back(theta_i);
  scan.theta_r_deg.push_back(theta_r);
  scan.phi_r_deg.push_back(0);
  scan.wavelength_nm.push_back(wavelength);
  scan.polarizer_deg.push_back(polarizer);
  scan.analyzer_deg.push_back(analyzer);
  scan.direction.push_back(1);
  scan.gain.push_back(gain);
  scan.x_v.push_back(s * std::cos(instrument.phase_rad) + instrument.dark_v(gain) +
                     std::sqrt(variance) * normal(random));
  scan.y_v.push_back(s * std::sin(instrument.phase_rad) + std::sqrt(variance_y) * normal(random));
  scan.x_se_v.push_back(se(variance));
  scan.y_se_v.push_back(se(variance_y));
  scan.monitor_v.push_back(source * (1.0 + instrument.monitor_relative * normal(random)));
  scan.saturated.push_back(0);
  scan.shutter_open.push_back(shutter_open ? 1 : 0);
}

inline double nominal_signal(const Instrument& instrument, const Brdf& f, double theta_i,
                             double theta_r, double wavelength, double polarizer, double analyzer) {
  double seen = f(theta_i, theta_r, wavelength, polarizer, analyzer);
  if (std::isnan(analyzer))
    seen += instrument.bias * (f(theta_i, theta_r, wavelength, polarizer, 90) -
                               f(theta_i, theta_r, wavelength, polarizer, 0));
  else
    seen *= 1.0 - instrument.bias * std::cos(2 * analyzer * degree);
  const double share = std::isnan(analyzer) ? 1.0 : 0.5;
  return instrument.gain_constant.at(wavelength) * instrument.solid_angle_sr *
         (seen * std::cos(theta_r * degree) / instrument.instrument_function(theta_r) +
          share * instrument.stray_per_sr(theta_r));
}

inline formats::ScanTable make_scan(const Instrument& instrument, const Brdf& f, const Plan& plan,
                                    std::uint64_t seed) {
  std::mt19937_64 random(seed);
  formats::ScanTable scan;
  scan.set_key("solid_angle_sr", "1e-4");
  scan.set_key("sample", "synthetic");
  for (double wavelength : plan.wavelengths)
    for (double theta_i : plan.theta_i)
      for (const auto& [polarizer, analyzer] : plan.states)
        for (double theta_r = plan.from; theta_r <= plan.to + 1e-9; theta_r += plan.step)
          for (int repeat = 0; repeat < plan.repeats; ++repeat)
            add_record(
                scan, instrument, random, theta_i, theta_r, wavelength, polarizer, analyzer,
                plan.gain,
                nominal_signal(instrument, f, theta_i, theta_r, wavelength, polarizer, analyzer),
                true);
  return scan;
}

/// Appends `count` shutter-closed records of each range as a block of their own.
inline void add_closed(formats::ScanTable& scan, const Instrument& instrument,
                       const std::vector<double>& gains, int count, std::uint64_t seed) {
  std::mt19937_64 random(seed ^ 0x5eedULL);
  const auto first = static_cast<std::int64_t>(scan.size());
  for (double gain : gains)
    for (int k = 0; k < count; ++k)
      add_record(scan, instrument, random, 0, 0, scan.wavelength_nm.front(), open_axis, open_axis,
                 gain, 0.0, false);
  scan.blocks.push_back({"shutter", first, static_cast<std::int64_t>(scan.size()) - 1, {}});
}

/// Appends the records of `more` as a block.
inline void append(formats::ScanTable& scan, const formats::ScanTable& more,
                   const std::string& block,
                   std::vector<std::pair<std::string, std::string>> settings = {}) {
  const auto first = static_cast<std::int64_t>(scan.size());
  const double start = scan.time_s.empty() ? 0.0 : scan.time_s.back();
  const auto join = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (std::size_t i = 0; i < more.size(); ++i) {
    scan.index.push_back(first + static_cast<std::int64_t>(i));
    scan.time_s.push_back(start + more.time_s[i]);
  }
  join(scan.theta_i_deg, more.theta_i_deg);
  join(scan.theta_r_deg, more.theta_r_deg);
  join(scan.phi_r_deg, more.phi_r_deg);
  join(scan.wavelength_nm, more.wavelength_nm);
  join(scan.polarizer_deg, more.polarizer_deg);
  join(scan.analyzer_deg, more.analyzer_deg);
  join(scan.direction, more.direction);
  join(scan.gain, more.gain);
  join(scan.x_v, more.x_v);
  join(scan.y_v, more.y_v);
  join(scan.x_se_v, more.x_se_v);
  join(scan.y_se_v, more.y_se_v);
  join(scan.monitor_v, more.monitor_v);
  join(scan.saturated, more.saturated);
  join(scan.shutter_open, more.shutter_open);
  scan.blocks.push_back(
      {block, first, static_cast<std::int64_t>(scan.size()) - 1, std::move(settings)});
}

/// A block without a sample: stray light alone, at several exit angles.
inline void add_no_sample(formats::ScanTable& scan, Instrument instrument, const Plan& plan,
                          std::uint64_t seed) {
  append(scan, make_scan(instrument, lambertian(0.0), plan, seed ^ 0xbacULL), "no_sample",
         {{"sample_removed", "1"}});
}

inline formats::ScanTable make_white(const Instrument& instrument, double rho, Plan plan,
                                     std::uint64_t seed, double dhr_u = 0.0) {
  formats::ScanTable scan = make_scan(instrument, lambertian(rho), plan, seed);
  scan.set_key("role", "white");
  for (double wavelength : plan.wavelengths)
    scan.set_key("reference_dhr_" + std::to_string(static_cast<int>(wavelength)),
                 std::to_string(rho));
  scan.set_key("reference_dhr_u", std::to_string(dhr_u));
  scan.set_key("reference_shape_u", "0");  // this one is Lambertian and depolarises indeed
  scan.set_key("reference_polarization_u", "0");
  return scan;
}

}  // namespace umov::calibrate::test
