// Reduction with a polarisation calibration, and the Mueller elements that come of it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>

#include <Eigen/Dense>

#include "host/calibrate/calibration_file.hpp"
#include "host/calibrate/mueller.hpp"
#include "host/calibrate/reduce.hpp"
#include "host/optics/realisability.hpp"
#include "tests/unit/calibrate/synthetic_mirror.hpp"

namespace umov::calibrate {
namespace {

using namespace test;

/// Linear block of a sample with a gloss lobe: mirror-symmetric, odd elements zero in plane.
optics::Mueller<double> sample_mueller(double theta_r, bool odd) {
  optics::Mueller<double> m = optics::zero_mueller<double>();
  const double lobe = std::exp(-std::pow((theta_r - 40) / 15, 2)), f = 0.02 + lobe;
  const double o = odd ? lobe : 0;
  const std::array<double, 9> block = {f,         0.4 * lobe, 0.04 * o, 0.4 * lobe, 0.75 * lobe,
                                       -0.05 * o, 0.03 * o,   0.06 * o, -0.6 * lobe};
  for (int k = 0; k < 9; ++k)
    optics::set_element(m, k / 3, k % 3, block[static_cast<std::size_t>(k)]);
  return m;
}

const std::vector<std::pair<double, double>> linear_states = {
    {0, 0},    {0, 90}, {90, 0},  {90, 90}, {0, open_axis}, {45, 45},
    {45, -45}, {0, 45}, {90, 45}, {45, 0},  {-45, 90},      {-45, 45}};
const std::vector<std::pair<double, double>> axis_states = {
    {0, 0}, {0, 90}, {0, open_axis}, {90, 90}, {90, 0}};

constexpr double gain_constant = 760, noise_relative = 3e-4;

formats::ScanTable make_sample(const Bench& bench,
                               const std::vector<std::pair<double, double>>& states, double phi,
                               std::uint64_t seed, bool white = false) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Instrument instrument;
  instrument.base_v = 1e-9;
  instrument.adc_v = 1e-8;
  instrument.shot_v = 0;
  instrument.relative = noise_relative;
  instrument.source_relative = 1e-4;  // seen by the monitor too
  formats::ScanTable scan;
  scan.set_key("solid_angle_sr", "1e-4");
  for (const auto& [polarizer, analyzer] : states)
    for (double theta_r = -75; theta_r <= 75.1; theta_r += 5) {
      if (phi != 0 && theta_r < 0) continue;
      optics::Mueller<double> m = optics::depolarizer<double>() * (0.99 / std::numbers::pi);
      if (!white) m = sample_mueller(theta_r, phi != 0);
      const auto beam = bench.source(polarizer, 0);
      const double seen = bench.detected(optics::apply(m, beam), analyzer, 0) / bench.monitor(beam);
      add_record(scan, instrument, random, white ? 0 : 40, theta_r, 532, polarizer, analyzer, 1,
                 gain_constant * seen * std::cos(theta_r * degree) * 1e-4, true);
      scan.phi_r_deg.back() = phi;
      // Light on the monitor differs with the polariser, and cancels.
      const double light = bench.monitor(beam);
      for (auto* column : {&scan.monitor_v, &scan.x_v, &scan.y_v, &scan.x_se_v, &scan.y_se_v})
        column->back() *= light;
    }
  if (white) {
    scan.set_key("role", "white");
    scan.set_key("reference_dhr_532", "0.99");
    scan.set_key("reference_dhr_u", "0");
    scan.set_key("reference_shape_u", "0");
    scan.set_key("reference_polarization_u", "0.01");
  }
  return scan;
}

/// Both ranges and dark are those of these scans: nothing to doubt.
Calibration calibrate_bench(const Bench& bench, std::uint64_t seed, bool with_mirror) {
  const auto white = make_sample(bench, axis_states, 0, seed + 100, true);
  const StandardScan standard{white, ReferenceStandard::from_keys(white), "white", ""};
  CalibrateOptions options;
  options.checks = false;
  if (with_mirror) {
    MirrorPlan plan;
    plan.wavelengths = {532};
    PolarizationOptions mirror;
    mirror.position_u_deg = 0;
    options.polarization = find_polarization(make_mirror(bench, plan, seed + 200), mirror);
  }
  return calibrate(std::span(&standard, 1), {}, options);
}

Bench misaligned() {
  return {{0.5, -0.4, 5e-4, 1e-3, 0.01, 0.012, 0.05, 25, 0}};
}

double ideal_value(double theta_r, bool odd, double polarizer, double analyzer) {
  const auto source = std::isnan(polarizer) ? optics::unpolarized<double>()
                                            : optics::polarizer_stokes<double>(polarizer);
  const auto row = std::isnan(analyzer) ? optics::unpolarized<double>()
                                        : optics::analyzer_stokes<double>(analyzer);
  return optics::contract(row, sample_mueller(theta_r, odd), source);
}

struct Pulls {
  double squares = 0, worst_relative = 0;
  std::size_t count = 0;
  double rms() const { return std::sqrt(squares / static_cast<double>(count)); }
};

Pulls pulls_of(const formats::BrdfTable& table, bool odd) {
  Pulls pulls;
  const auto& p = table.points;
  for (std::size_t i = 0; i < p.size(); ++i) {
    double variance = p.brdf_u[i] * p.brdf_u[i];
    for (const auto& factor : table.factors) variance += std::pow(factor.per_point[i], 2);
    const double truth = ideal_value(p.theta_r_deg[i], odd, p.polarizer_deg[i], p.analyzer_deg[i]);
    pulls.squares += std::pow(p.brdf_per_sr[i] - truth, 2) / variance;
    const double m00 = ideal_value(p.theta_r_deg[i], odd, open_axis, open_axis);
    pulls.worst_relative = std::max(pulls.worst_relative, std::abs(p.brdf_per_sr[i] - truth) / m00);
    ++pulls.count;
  }
  return pulls;
}

TEST(ReductionWithTrueStates, RefersToIdealElements) {
  const Bench bench = misaligned();
  const auto scan = make_sample(bench, axis_states, 0, 7);
  const auto plain = reduce(scan, calibrate_bench(bench, 1, false));
  const auto corrected = reduce(scan, calibrate_bench(bench, 1, true));
  EXPECT_GT(pulls_of(plain.table, false).worst_relative, 0.008) << "or there is nothing to correct";
  EXPECT_LT(pulls_of(corrected.table, false).worst_relative, 0.002);
}

TEST(ReductionWithTrueStates, HasHonestUncertainties) {
  const Bench bench = misaligned();
  double squares = 0;
  std::size_t count = 0;
  constexpr int seeds = 10;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const auto found =
        reduce(make_sample(bench, axis_states, 0, 1000 + seed), calibrate_bench(bench, seed, true));
    const Pulls pulls = pulls_of(found.table, false);
    squares += pulls.squares;
    count += pulls.count;
  }
  const double rms = std::sqrt(squares / static_cast<double>(count));
  // Scatter that the standard's records seem to have counts as noise of every record: some of these
  // benches are given more of it than they have.
  EXPECT_GT(rms, 0.5);
  EXPECT_LT(rms, 1.3);
}

TEST(ReductionWithTrueStates, OutOfPlaneKeepsTheDoubtOfElementsThatPAndSDoNotShow) {
  const Bench bench = misaligned();
  const auto calibration = calibrate_bench(bench, 3, true);
  const auto in_plane = reduce(make_sample(bench, axis_states, 0, 8), calibration);
  const auto beside = reduce(make_sample(bench, axis_states, 30, 8), calibration);
  const auto doubts = [](const formats::BrdfTable& table) {
    int count = 0;
    for (const auto& factor : table.factors)
      count += factor.name.starts_with("undetermined m0") ? 1 : 0;
    return count;
  };
  EXPECT_EQ(doubts(in_plane.table), 0);
  EXPECT_EQ(doubts(beside.table), 1);
  EXPECT_LT(pulls_of(beside.table, true).rms(), 1.3) << "the doubt covers what is not corrected";
}

TEST(ReductionWithTrueStates, WorksTheSameThroughTheCalibrationFile) {
  const Bench bench = misaligned();
  Calibration calibration = calibrate_bench(bench, 2, true);
  calibration.polarization->notes.push_back("a note");
  const auto path = std::filesystem::temp_directory_path() / "umov_polarization_round_trip.h5";
  write_calibration(path, calibration, {});
  const Calibration again = read_calibration(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(again.polarization);
  const auto &a = *calibration.polarization, &b = *again.polarization;
  EXPECT_EQ(a.covariance, b.covariance);
  ASSERT_EQ(a.wavelengths.size(), b.wavelengths.size());
  EXPECT_EQ(a.wavelengths[0].values(), b.wavelengths[0].values());
  EXPECT_EQ(a.wavelengths[0].records, b.wavelengths[0].records);
  EXPECT_EQ(a.tilt_out_of_plane_deg, b.tilt_out_of_plane_deg);
  EXPECT_EQ(a.index, b.index);
  EXPECT_EQ(a.mirror, b.mirror);
  EXPECT_EQ(a.notes, b.notes);
  EXPECT_EQ(calibration.wavelengths[0].polarization_shift, again.wavelengths[0].polarization_shift);
  const auto scan = make_sample(bench, axis_states, 0, 7);
  EXPECT_EQ(reduce(scan, calibration).table.points.brdf_per_sr,
            reduce(scan, again).table.points.brdf_per_sr);
}

TEST(ReductionWithTrueStates, CountsTheDetectorBiasOnce) {
  // The standard's own polarisation may be .01; the wafer knows better, and both together best.
  const Bench bench = misaligned();
  const auto alone = calibrate_bench(bench, 4, false), both = calibrate_bench(bench, 4, true);
  const auto& wafer = both.polarization->wavelengths[0];
  const auto& entry = both.wavelengths[0];
  EXPECT_TRUE(entry.bias_active);
  EXPECT_NEAR(entry.detector_bias, 0.01, 4 * entry.detector_bias_u);
  EXPECT_LE(entry.detector_bias_u, 1.05 * wafer.detector_bias_u);
  EXPECT_GT(entry.detector_bias_u,
            0.9 / std::sqrt(1 / std::pow(wafer.detector_bias_u, 2) + 1 / 1e-4))
      << "no more than both sources know";
  EXPECT_LT(entry.detector_bias_u, alone.wavelengths[0].detector_bias_u);
  const auto reduced = reduce(make_sample(bench, axis_states, 0, 9), both);
  int bias_factors = 0;
  for (const auto& factor : reduced.table.factors)
    bias_factors += factor.name == "detector bias 532 nm" ? 1 : 0;
  EXPECT_LE(bias_factors, 1);
}

TEST(MuellerReflectometry, FindsTheLinearPartWithItsCovariance) {
  const Bench bench = misaligned();
  double squares = 0, chi2 = 0, dof = 0;
  std::size_t count = 0, below = 0, directions = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const auto found = reduce(make_sample(bench, linear_states, 30, 2000 + seed),
                              calibrate_bench(bench, seed, true));
    ASSERT_TRUE(found.table.mueller);
    const auto& m = *found.table.mueller;
    EXPECT_EQ(found.summary.mueller.complete, m.size());
    EXPECT_TRUE(found.summary.mueller.undetermined.empty());
    for (std::size_t n = 0; n < m.size(); ++n) {
      const auto truth = sample_mueller(m.theta_r_deg[n], true);
      std::array<double, 9> linear{};
      for (std::size_t k = 0; k < 9; ++k)
        linear[k] = optics::element(truth, static_cast<int>(k / 3), static_cast<int>(k % 3));
      ASSERT_GT(optics::linear_realisability(linear).least_eigenvalue, 0) << "the sample itself";
      Eigen::Matrix<double, 9, 9> covariance;
      Eigen::Matrix<double, 9, 1> error;
      for (std::size_t k = 0; k < 9; ++k) {
        error(static_cast<Eigen::Index>(k)) =
            m.mueller[9 * n + k] -
            optics::element(truth, static_cast<int>(k / 3), static_cast<int>(k % 3));
        for (std::size_t l = 0; l < 9; ++l)
          covariance(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)) =
              m.covariance[m.covariance_at(n, k, l)];
        EXPECT_NEAR(m.mueller_u[9 * n + k], std::sqrt(m.covariance[m.covariance_at(n, k, k)]),
                    1e-12);
      }
      squares += error.dot(covariance.ldlt().solve(error));
      count += 9;
      below += m.realisable_z[n] < -3 ? 1 : 0;
      ++directions;
      chi2 += m.chi2[n];
      dof += m.dof[n];
    }
  }
  EXPECT_GT(squares / static_cast<double>(count), 0.4) << "all nine with their covariance";
  EXPECT_LT(squares / static_cast<double>(count), 1.3) << "all nine with their covariance";
  EXPECT_GT(chi2 / dof, 0.4);
  EXPECT_LT(chi2 / dof, 1.3);
  EXPECT_LE(below * 50, directions) << "a physical sample is not called unphysical";
}

TEST(MuellerReflectometry, SaysWhichElementsTheStatesLeaveOpen) {
  const Bench bench;
  const auto calibration = calibrate_bench(bench, 5, false);
  auto states = axis_states;
  states.emplace_back(45, 0);
  const auto found = reduce(make_sample(bench, states, 0, 3), calibration);
  ASSERT_TRUE(found.table.mueller);
  const auto& m = *found.table.mueller;
  EXPECT_EQ(found.summary.mueller.complete, 0u);
  // 45/P shows m02 - m12 only: neither of the two, and nothing of the last row.
  EXPECT_EQ(found.summary.mueller.undetermined,
            (std::vector<std::string>{"m02", "m12", "m20", "m21", "m22"}));
  for (std::size_t k : {0UL, 1UL, 3UL, 4UL}) EXPECT_FALSE(std::isnan(m.mueller[k]));
  for (std::size_t k : {2UL, 5UL, 6UL, 7UL, 8UL}) EXPECT_TRUE(std::isnan(m.mueller[k]));
  EXPECT_TRUE(std::isnan(m.realisable_z[0]));
}

TEST(MuellerReflectometry, OfPAndSStatesAloneIsMadeOnDemand) {
  const Bench bench;
  const auto calibration = calibrate_bench(bench, 6, false);
  const auto scan = make_sample(bench, axis_states, 0, 3);
  const auto plain = reduce(scan, calibration);
  EXPECT_FALSE(plain.table.mueller);
  EXPECT_EQ(plain.summary.mueller.left_out, 31u);
  ReduceOptions options;
  options.mueller_partial = true;
  const auto partial = reduce(scan, calibration, options);
  ASSERT_TRUE(partial.table.mueller);
  EXPECT_NEAR(partial.table.mueller->mueller[0], ideal_value(-75, false, open_axis, open_axis),
              1e-4);
}

TEST(MuellerReflectometry, FlagsATableThatNoLightCanHave) {
  // Channels of a matrix with more polarised light than light.
  formats::BrdfTable table;
  for (const auto& [polarizer, analyzer] : linear_states) {
    optics::Mueller<double> m = optics::depolarizer<double>();
    optics::set_element(m, 1, 1, 0.9);
    optics::set_element(m, 2, 2, 0.9);
    optics::set_element(m, 1, 0, 0.5);
    const auto source = optics::polarizer_stokes<double>(polarizer);
    const auto row = std::isnan(analyzer) ? optics::unpolarized<double>()
                                          : optics::analyzer_stokes<double>(analyzer);
    auto& p = table.points;
    p.theta_i_deg.push_back(30);
    p.theta_r_deg.push_back(30);
    p.phi_r_deg.push_back(0);
    p.wavelength_nm.push_back(532);
    p.polarizer_deg.push_back(polarizer);
    p.analyzer_deg.push_back(analyzer);
    p.brdf_per_sr.push_back(optics::contract(row, m, source));
    p.brdf_u.push_back(1e-3);
    p.used.push_back(1);
  }
  MuellerSummary summary;
  const auto found = find_mueller(table, false, summary);
  ASSERT_TRUE(found);
  EXPECT_LT(found->realisable_z[0], -10);
  EXPECT_EQ(summary.unphysical, 1u);
}

}  // namespace
}  // namespace umov::calibrate
