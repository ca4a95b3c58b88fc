// An instrument with leaky, misaligned elements, written with 4 × 4 Mueller matrices apart from the
// program's own formulas, and its scans of a wafer and of samples with a known Mueller matrix.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "host/formats/scan_table.hpp"
#include "host/optics/fresnel.hpp"
#include "host/optics/mueller.hpp"
#include "host/optics/refractive_index.hpp"
#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate::test {

struct TruePolarization {
  double polarizer_axis_deg = 0, analyzer_axis_deg = 0;
  double polarizer_extinction = 0, analyzer_extinction = 0;
  double detector_bias = 0, monitor_bias = 0;
  double source_degree = 0, source_axis_deg = 25;
  double play_deg = 0;
};

/// A dichroic sheet: diag(1, √e) in its own Jones frame.
inline optics::Mueller<double> sheet(double axis_deg, double extinction) {
  // In the frame whose first axis is the transmitting one: Q' along it.
  optics::Mueller<double> own = optics::zero_mueller<double>();
  const double mean = 0.5 * (1 + extinction), half = 0.5 * (1 - extinction);
  optics::set_element(own, 0, 0, mean);
  optics::set_element(own, 1, 1, mean);
  optics::set_element(own, 0, 1, half);
  optics::set_element(own, 1, 0, half);
  optics::set_element(own, 2, 2, std::sqrt(extinction));
  optics::set_element(own, 3, 3, std::sqrt(extinction));
  // The first axis is s there: at the angle axis - 90 deg from it towards -p, so turned by it.
  const double turn = (90.0 - axis_deg) * degree;
  const auto in = optics::rotation(turn), out = optics::rotation(-turn);
  return optics::product(out, optics::product(own, in));
}

struct Bench {
  TruePolarization truth;
  optics::Stokes<double> source(double polarizer_deg, int direction) const {
    const double a = 2 * truth.source_axis_deg * degree, d = truth.source_degree;
    const optics::Stokes<double> laser(1.0, -d * std::cos(a), d * std::sin(a), 0.0);
    if (std::isnan(polarizer_deg)) return laser;
    return optics::apply(
        sheet(polarizer_deg + truth.polarizer_axis_deg - 0.5 * direction * truth.play_deg,
              truth.polarizer_extinction),
        laser);
  }
  /// What the detector shows of the light `beam` behind the analyser.
  double detected(const optics::Stokes<double>& beam, double analyzer_deg, int direction) const {
    optics::Stokes<double> behind = beam;
    if (!std::isnan(analyzer_deg))
      behind = optics::apply(
          sheet(analyzer_deg + truth.analyzer_axis_deg - 0.5 * direction * truth.play_deg,
                truth.analyzer_extinction),
          beam);
    return behind[0] + truth.detector_bias * behind[1];
  }
  double monitor(const optics::Stokes<double>& beam) const {
    return beam[0] + truth.monitor_bias * beam[1];
  }
};

struct MirrorPlan {
  std::vector<double> wavelengths = {532, 814};
  std::vector<double> theta_i = {25, 45, 60, 70, 75, 80};
  std::vector<std::pair<double, double>> bright = {{0, 0},    {90, 90},  {0, 45},  {0, -45},
                                                   {90, 45},  {90, -45}, {45, 0},  {45, 90},
                                                   {-45, 90}, {-45, 0},  {45, 45}, {45, -45}};
  std::vector<std::pair<double, double>> dark = {{0, 90}, {90, 0}, {0, 84}, {0, 96},  {90, -6},
                                                 {90, 6}, {84, 0}, {96, 0}, {-6, 90}, {6, 90}};
  double incidence_offset_deg = 0, tilt_out_of_plane_deg = 0;
  double slow_noise = 0.002;  ///< relative, a record
  double drift = 0.003;       ///< of the scale, from one angle to the next
};

/// Bright states with little light, then the dark ones twice with a hundred times as much.
inline formats::ScanTable make_mirror(const Bench& bench, const MirrorPlan& plan,
                                      std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::chi_squared_distribution<double> chi2(9);
  const auto table = optics::IndexTable::embedded("Ge_Jellison");
  formats::ScanTable scan;
  scan.set_key("role", "mirror");
  scan.set_key("sample", "germanium");
  double last_polarizer = -200, last_analyzer = -200;
  int polarizer_direction = 1, analyzer_direction = 1;
  const auto record = [&](double wavelength, double theta, std::pair<double, double> state,
                          double light, double scale) {
    const auto& [polarizer, analyzer] = state;
    if (polarizer != last_polarizer) polarizer_direction = polarizer > last_polarizer ? 1 : -1;
    if (analyzer != last_analyzer) analyzer_direction = analyzer > last_analyzer ? 1 : -1;
    last_polarizer = polarizer;
    last_analyzer = analyzer;
    const double true_theta = (theta + plan.incidence_offset_deg) * degree;
    const double lean = plan.tilt_out_of_plane_deg * degree;
    const auto reflection = optics::reflection_mueller(
        table.n(wavelength * 1e-3), table.kappa(wavelength * 1e-3), std::cos(true_theta));
    const auto in = optics::rotation(-lean / std::sin(true_theta));
    const auto out = optics::rotation(-lean * std::cos(2 * true_theta) / std::sin(true_theta));
    const auto beam = bench.source(polarizer, polarizer_direction);
    const auto reflected = optics::apply(out, optics::apply(reflection, optics::apply(in, beam)));
    const double source = light * (1 + 0.003 * normal(random));
    const double s = 500.0 * scale * source * (1 + plan.slow_noise * normal(random)) *
                     bench.detected(reflected, analyzer, analyzer_direction);
    const double gain = auto_range(s);
    const double sd = std::hypot(3e-7, 1e-5 / gain);
    scan.index.push_back(static_cast<std::int64_t>(scan.index.size()));
    scan.time_s.push_back(static_cast<double>(scan.index.size()));
    scan.theta_i_deg.push_back(theta);
    scan.theta_r_deg.push_back(theta);
    scan.phi_r_deg.push_back(0);
    scan.wavelength_nm.push_back(wavelength);
    scan.polarizer_deg.push_back(polarizer);
    scan.analyzer_deg.push_back(analyzer);
    scan.direction.push_back(1);
    scan.gain.push_back(gain);
    scan.x_v.push_back(s + sd * normal(random));
    scan.y_v.push_back(sd * normal(random));
    scan.x_se_v.push_back(sd * std::sqrt(chi2(random) / 9));
    scan.y_se_v.push_back(sd * std::sqrt(chi2(random) / 9));
    scan.monitor_v.push_back(source * bench.monitor(beam));
    scan.saturated.push_back(0);
    scan.shutter_open.push_back(1);
  };
  const auto take = [&](const auto& states, double light) {
    for (double wavelength : plan.wavelengths)
      for (double theta : plan.theta_i) {
        const double scale = 1 + plan.drift * normal(random);
        for (const auto& state : states) record(wavelength, theta, state, light, scale);
      }
  };
  take(plan.bright, 1e-3);
  const auto first = static_cast<std::int64_t>(scan.size());
  take(plan.dark, 1e-1);
  take(plan.dark, 1e-1);
  if (!plan.dark.empty())
    scan.blocks.push_back({"repeat", first, static_cast<std::int64_t>(scan.size()) - 1, {}});
  return scan;
}

}  // namespace umov::calibrate::test
