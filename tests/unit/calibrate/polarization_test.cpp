#include "host/calibrate/polarization.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/errors/error.hpp"
#include "tests/unit/calibrate/synthetic_mirror.hpp"

namespace umov::calibrate {
namespace {

using namespace test;
using ::testing::HasSubstr;

Bench leaky_bench() {
  return {{0.3, -0.25, 1e-4, 2e-4, -0.006, 0.008, 0.06, 25, 0.02}};
}

PolarizationOptions without_position() {
  PolarizationOptions options;
  options.position_u_deg = 0;
  return options;
}

std::string refusal(const formats::ScanTable& scan) {
  try {
    find_polarization(scan);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(PolarizationVectors, AreThoseOfTheMatricesOfSheetsInARow) {
  const Bench bench = leaky_bench();
  PolarizationVector parameters;
  const double a = 2 * bench.truth.source_axis_deg * degree, d = bench.truth.source_degree;
  parameters << 0.3, -0.25, 1e-4, 2e-4, -0.006, 0.008, -d * std::cos(a), d * std::sin(a), 1.0;
  for (double axis : {0.0, 90.0, 45.0, -45.0, 84.0, open_axis}) {
    Bench still = bench;
    still.truth.play_deg = 0;
    const auto beam = still.source(axis, 1);
    const Eigen::Vector3d expected =
        Eigen::Vector3d(beam[0], beam[1], beam[2]) / still.monitor(beam);
    EXPECT_LT((source_vector(parameters, axis) - expected).norm(), 1e-12) << axis;
    for (int k = 0; k < 3; ++k) {
      optics::Stokes<double> unit(0.0);
      unit[k] = 1;
      EXPECT_NEAR(analyzer_vector(parameters, axis)(k), still.detected(unit, axis, 1), 1e-12)
          << axis << " " << k;
    }
  }
}

TEST(PolarizationVectors, OfPerfectElementsAreTheIdealOnes) {
  PolarizationVector perfect = PolarizationVector::Zero();
  for (double axis : {0.0, 90.0, 30.0, open_axis}) {
    EXPECT_LT((source_vector(perfect, axis) - ideal_source_vector(axis)).norm(), 1e-15);
    EXPECT_LT((analyzer_vector(perfect, axis) - ideal_analyzer_vector(axis)).norm(), 1e-15);
  }
}

TEST(MirrorScan, GivesAxesExtinctionAndBiasWithHonestUncertainty) {
  const Bench bench = leaky_bench();
  MirrorPlan plan;
  plan.incidence_offset_deg = 0.05;
  plan.tilt_out_of_plane_deg = -0.04;
  const double a = 2 * bench.truth.source_axis_deg * degree, d = bench.truth.source_degree;
  PolarizationVector truth;
  truth << 0.3, -0.25, 1e-4, 2e-4, -0.006, 0.008, -d * std::cos(a), d * std::sin(a), 1.0;
  PolarizationVector squares = PolarizationVector::Zero();
  double geometry = 0;
  constexpr int seeds = 12;
  int count = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto found = find_polarization(make_mirror(bench, plan, static_cast<std::uint64_t>(seed)),
                                         without_position());
    ASSERT_EQ(found.wavelengths.size(), 2u);
    for (std::size_t w = 0; w < 2; ++w) {
      const auto& entry = found.wavelengths[w];
      EXPECT_NEAR(entry.polarizer_axis_deg, 0.3, 0.03);
      EXPECT_NEAR(entry.analyzer_axis_deg, -0.25, 0.03);
      EXPECT_NEAR(entry.polarizer_extinction, 1e-4, 1e-5);
      EXPECT_NEAR(entry.analyzer_extinction, 2e-4, 2e-5);
      // Half of the play is doubt of its own: at a new approach it may lie on either side.
      const Eigen::MatrixXd block = found.block(w);
      PolarizationVector variance = block.diagonal();
      variance(0) -= 0.25 * found.polarizer_play_deg * found.polarizer_play_deg;
      variance(1) -= 0.25 * found.analyzer_play_deg * found.analyzer_play_deg;
      squares += (entry.values() - truth).cwiseAbs2().cwiseQuotient(variance);
      ++count;
    }
    geometry += std::pow((found.tilt_out_of_plane_deg + 0.04) / found.tilt_out_of_plane_u_deg, 2);
    EXPECT_NEAR(found.polarizer_play_deg, 0.02, 0.006);
    EXPECT_NEAR(found.analyzer_play_deg, 0.02, 0.006);
  }
  // 24 pulls of nearly normal errors: rms within .6 … 1.4 at four standard errors.
  for (Eigen::Index k : {0, 1, 2, 3, 4, 5}) {
    const double rms = std::sqrt(squares(k) / count);
    EXPECT_GT(rms, 0.5) << name_of(static_cast<PolarizationParameter>(k));
    EXPECT_LT(rms, 1.5) << name_of(static_cast<PolarizationParameter>(k));
  }
  EXPECT_LT(std::sqrt(geometry / seeds), 1.8);
}

TEST(MirrorScan, OfPerfectElementsFindsNoErrors) {
  const auto found = find_polarization(make_mirror(Bench{}, MirrorPlan{}, 3));
  for (const auto& entry : found.wavelengths) {
    EXPECT_LT(std::abs(entry.polarizer_axis_deg), 4 * entry.polarizer_axis_u_deg);
    EXPECT_LT(entry.polarizer_extinction, 1e-6 + 4 * entry.polarizer_extinction_u);
    EXPECT_LT(entry.analyzer_extinction, 1e-6 + 4 * entry.analyzer_extinction_u);
    EXPECT_LT(std::abs(entry.detector_bias), 4 * entry.detector_bias_u);
  }
}

TEST(MirrorScan, SeesAWaferWithAnOxideFilmAsAChangeOfItsIndex) {
  // The axes come from symmetry, so a wrong handbook index must not move them.
  PolarizationOptions silicon = without_position();
  const auto scan = make_mirror(leaky_bench(), MirrorPlan{}, 5);
  silicon.n_relative_u = 0.03;
  const auto wide = find_polarization(scan, silicon), plain = find_polarization(scan);
  EXPECT_NEAR(wide.wavelengths[0].polarizer_axis_deg, plain.wavelengths[0].polarizer_axis_deg,
              0.003);
  EXPECT_GT(wide.wavelengths[0].index_n_u, 0);
}

TEST(MirrorScan, WithTooFewStatesSaysWhichAreMissing) {
  MirrorPlan plan;
  plan.dark = {{0, 90}};
  plan.bright = {{0, 0}, {90, 90}, {0, 45}};
  const std::string said = refusal(make_mirror(leaky_bench(), plan, 1));
  EXPECT_THAT(said, HasSubstr("S/P"));
  EXPECT_THAT(said, HasSubstr("analyser on both sides"));
  EXPECT_THAT(said, HasSubstr("polariser on both sides"));
  EXPECT_THAT(said, ::testing::Not(HasSubstr("P/P")));
  EXPECT_THAT(said, ::testing::Not(HasSubstr("S/S")));
}

TEST(MirrorScan, NeedsGrazingAnglesAndTheMirrorDirection) {
  MirrorPlan plan;
  plan.theta_i = {20, 30, 40, 50};
  EXPECT_THAT(refusal(make_mirror(leaky_bench(), plan, 1)), HasSubstr("none from 60 deg up"));
  auto scan = make_mirror(leaky_bench(), MirrorPlan{}, 1);
  for (double& theta_r : scan.theta_r_deg) theta_r -= 5;
  EXPECT_THAT(refusal(scan), HasSubstr("no usable record in the mirror direction"));
  scan.set_key("role", "white");
  EXPECT_THAT(refusal(scan), HasSubstr("role `white`"));
}

}  // namespace
}  // namespace umov::calibrate
