// Recovery of known parameters from made-up measurements.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/invert/invert.hpp"
#include "host/invert/prediction.hpp"
#include "tests/unit/invert/synthetic_measurement.hpp"

namespace umov::invert {
namespace {

using formats::FitResult;

TEST(JointFit, NoiseFreePaintGivesItsParametersBack) {
  const test::Scene scene = test::red_gloss();
  const auto made = test::make(scene, 1, 0);
  const FitResult fit = invert(made.table, test::quick(scene, 4));
  EXPECT_LT(fit.chi2, 1e-6);
  EXPECT_TRUE(fit.converged);
  for (std::size_t i = 0; i < fit.parameters.size(); ++i) {
    for (std::size_t w = 0; w < fit.parameters[i].estimates.size(); ++w) {
      const double truth = scene.truth[w][i];
      EXPECT_NEAR(fit.parameters[i].estimates[w].value, truth, 2e-3 * truth)
          << fit.parameters[i].name << " at wavelength " << w;
    }
  }
}

TEST(JointFit, ParametersAreSharedOrSpectralAsTheModelSays) {
  const test::Scene scene = test::red_gloss();
  const FitResult fit = invert(test::make(scene, 2).table, test::quick(scene, 4));
  EXPECT_TRUE(fit.find("n")->shared);
  EXPECT_EQ(fit.find("n")->estimates.size(), 1U);
  EXPECT_FALSE(fit.find("k_uds")->shared);
  EXPECT_EQ(fit.find("k_uds")->estimates.size(), 3U);
}

TEST(JointFit, SharingSplittingFixingAndStartingFollowTheUser) {
  const test::Scene scene = test::black_paint();
  const auto made = test::make(scene, 3);
  Options options = test::quick(scene, 4);
  options.share = {"1.rho_d2"};
  options.spectral = {"0.slope_rms"};
  options.fix = {{"0.n", std::nullopt, 1.5}, {"0.kappa", 814, 0.2}};
  const FitResult fit = invert(made.table, options);
  EXPECT_EQ(fit.find("1.rho_d2")->estimates.size(), 1U);
  EXPECT_EQ(fit.find("0.slope_rms")->estimates.size(), 2U);
  EXPECT_TRUE(fit.find("0.n")->fixed);
  EXPECT_DOUBLE_EQ(fit.find("0.n")->estimates[0].value, 1.5);
  EXPECT_DOUBLE_EQ(fit.find("0.n")->estimates[0].hi, 1.5);
  EXPECT_DOUBLE_EQ(fit.find("0.kappa")->estimates[1].value, 0.2);
  EXPECT_GT(fit.find("0.kappa")->estimates[0].hi, fit.find("0.kappa")->estimates[0].lo);
  EXPECT_TRUE(fit.find("0.bias")->fixed) << "the model holds the scale of its lobe";
  options.free = {"0.bias"};
  EXPECT_FALSE(invert(made.table, options).find("0.bias")->fixed);
}

TEST(JointFit, UnusedPointsHaveNoSay) {
  const test::Scene scene = test::black_paint();
  auto made = test::make(scene, 4);
  const FitResult before = invert(made.table, test::quick(scene, 4));
  auto& p = made.table.points;
  for (std::size_t i = 0; i < p.size(); i += 10) {
    for (auto* column : {&p.theta_i_deg, &p.theta_r_deg, &p.phi_r_deg, &p.wavelength_nm,
                         &p.polarizer_deg, &p.analyzer_deg}) {
      column->push_back((*column)[i]);
    }
    p.brdf_per_sr.push_back(1e3);
    p.brdf_u.push_back(0);
    p.used.push_back(0);
  }
  const FitResult after = invert(made.table, test::quick(scene, 4));
  EXPECT_EQ(after.points, before.points);
  EXPECT_DOUBLE_EQ(after.chi2, before.chi2);
}

TEST(JointFit, ResultDoesNotDependOnTheNumberOfThreads) {
  const test::Scene scene = test::red_gloss();
  const auto made = test::make(scene, 5);
  Options options = test::quick(scene, 4);
  options.starts = 6;
  options.dhr = true;
  const FitResult one = invert(made.table, options);
  for (const int threads : {2, 3}) {
    options.threads = threads;
    FitResult many = invert(made.table, options);
    many.seconds = one.seconds;
    many.phase_seconds = one.phase_seconds;
    EXPECT_EQ(formats::fit_to_json(many), formats::fit_to_json(one)) << threads << " threads";
  }
}

TEST(JointFit, OneInAHundredWildPointsMovesNothingBeyondItsInterval) {
  test::Scene scene = test::black_paint();
  scene.outlier_share = 0.01;
  int inside = 0, all = 0;
  for (const std::uint64_t seed : {6, 7, 8}) {
    const FitResult fit = invert(test::make(scene, seed).table, test::quick(scene, 4));
    EXPECT_GE(fit.outliers, 2U);
    EXPECT_LT(fit.interval_scale, 1.3);
    for (std::size_t i = 0; i < fit.parameters.size(); ++i) {
      if (fit.parameters[i].fixed) continue;
      for (std::size_t w = 0; w < fit.parameters[i].estimates.size(); ++w) {
        const auto& e = fit.parameters[i].estimates[w];
        const double half = 0.5 * (e.hi - e.lo);
        EXPECT_NEAR(e.value, scene.truth[w][i], 2 * half) << fit.parameters[i].name;
        inside += scene.truth[w][i] >= e.lo && scene.truth[w][i] <= e.hi;
        ++all;
      }
    }
  }
  EXPECT_GE(inside, all - 4);
}

TEST(JointFit, WithoutTheRobustLossTheSameWildPointsWidenTheIntervals) {
  test::Scene scene = test::black_paint();
  scene.outlier_share = 0.01;
  const auto made = test::make(scene, 6);
  const FitResult robust = invert(made.table, test::quick(scene, 4));
  Options plain = test::quick(scene, 4);
  plain.robust_sigma = 0;
  const FitResult squares = invert(made.table, plain);
  EXPECT_GT(squares.interval_scale, 2 * robust.interval_scale);
}

TEST(JointFit, AModelThatCannotFitSaysSoAndWidensItsIntervals) {
  const auto made = test::make(test::red_gloss(), 9);
  Options options;
  options.model = "lambertian";
  options.dhr = false;
  const FitResult fit = invert(made.table, options);
  EXPECT_GT(fit.interval_scale, 5);
  EXPECT_TRUE(std::any_of(fit.notes.begin(), fit.notes.end(), [](const std::string& note) {
    return note.find("misses the data") != std::string::npos;
  }));
  ASSERT_TRUE(fit.g2_held_out);
  EXPECT_GT(*fit.g2_held_out, 25);
}

TEST(JointFit, HeldOutRowsOfARightModelShowNoGap) {
  const test::Scene scene = test::black_paint();
  Options options = test::quick(scene, 4);
  options.held_out = true;
  double mean = 0;
  for (std::uint64_t seed = 20; seed < 30; ++seed) {
    const FitResult fit = invert(test::make(scene, seed).table, options);
    ASSERT_TRUE(fit.g2_held_out);
    mean += *fit.g2_held_out / 10;
  }
  // 93 held-out points each: one fit's gap scatters by 0.15.
  EXPECT_NEAR(mean, 0, 0.15);
}

TEST(JointFit, AFloorStandsForWhatTheModelLeavesOut) {
  const auto made = test::make(test::red_gloss(), 11);
  Options options;
  options.model = "microfacet+nef";
  options.dhr = false;
  options.held_out = false;
  const double without = invert(made.table, options).interval_scale;
  options.floor_relative = 0.1;
  const FitResult with = invert(made.table, options);
  EXPECT_LT(with.interval_scale, 0.5 * without);
  EXPECT_DOUBLE_EQ(with.floor_relative, 0.1);
}

TEST(JointFit, PaperObjectiveEndsAtTheSameOptimumWithoutNoise) {
  const test::Scene scene = test::black_paint();
  const auto made = test::make(scene, 12, 0);
  Options options = test::quick(scene, 4);
  const FitResult weighted = invert(made.table, options);
  options.objective = Objective::paper;
  options.max_iterations = 1000;
  const FitResult paper = invert(made.table, options);
  EXPECT_EQ(paper.objective_kind, "paper");
  EXPECT_LT(paper.objective, 1e-6);
  for (const auto& parameter : weighted.parameters) {
    for (std::size_t w = 0; w < parameter.estimates.size(); ++w) {
      const double value = parameter.estimates[w].value;
      EXPECT_NEAR(paper.find(parameter.name)->estimates[w].value, value, 2e-3 * value)
          << parameter.name;
    }
  }
}

TEST(JointFit, PaperObjectiveIsTheMeanOverWavelengthsOfSquaredRelativeDeviations) {
  const test::Scene scene = test::black_paint();
  const auto made = test::make(scene, 13);
  Options options = test::quick(scene, 4);
  options.objective = Objective::paper;
  const FitResult fit = invert(made.table, options);
  const Prediction prediction = predict(fit, made.table);
  double sum = 0;
  for (std::size_t i = 0; i < made.table.points.size(); ++i) {
    const double y = made.table.points.brdf_per_sr[i];
    if (y > 0) sum += std::pow((prediction.brdf_per_sr[i] - y) / y, 2);
  }
  EXPECT_NEAR(fit.objective, sum / 2, 1e-9 * fit.objective);
}

TEST(JointFit, PredictionAndResidualsRebuildChiSquare) {
  test::Scene scene = test::black_paint();
  scene.gain_sigma = 0.01;
  const auto made = test::make(scene, 14);
  const FitResult fit = invert(made.table, test::quick(scene, 4));
  const Prediction prediction = predict(fit, made.table);
  double chi2 = 0;
  for (const double r : prediction.residual) chi2 += r * r;
  for (const auto& factor : fit.factors) chi2 += factor.value * factor.value;
  EXPECT_NEAR(chi2, fit.chi2, 1e-8 * chi2);
}

}  // namespace
}  // namespace umov::invert
