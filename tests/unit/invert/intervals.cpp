// What the intervals promise: coverage, calibration, bounds, confusions named.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>

#include "host/brdf/dhr.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/h5_header.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/invert/invert.hpp"
#include "host/invert/prediction.hpp"
#include "tests/unit/invert/synthetic_measurement.hpp"

namespace umov::invert {
namespace {

using formats::FitResult;

struct Coverage {
  int inside = 0, all = 0;
  std::map<std::string, std::pair<int, int>> by_name;
  void count(const std::string& name, bool hit) {
    inside += hit;
    ++all;
    by_name[name].first += hit;
    ++by_name[name].second;
  }
  double share() const { return static_cast<double>(inside) / all; }
};

Coverage coverage_of(const test::Scene& scene, const Options& options, int seeds) {
  Coverage out;
  for (int seed = 0; seed < seeds; ++seed) {
    const auto made = test::make(scene, 1000 + static_cast<std::uint64_t>(seed));
    const FitResult fit = invert(made.table, options);
    for (std::size_t i = 0; i < fit.parameters.size(); ++i) {
      if (fit.parameters[i].fixed) continue;
      for (std::size_t w = 0; w < fit.parameters[i].estimates.size(); ++w) {
        const auto& e = fit.parameters[i].estimates[w];
        if (!e.identifiable) continue;
        const double truth = scene.truth[w][i];
        out.count(fit.parameters[i].name, truth >= e.lo && truth <= e.hi);
      }
    }
    for (const auto& dhr : fit.dhr) {
      const auto w = *fit.wavelength_index(dhr.wavelength_nm);
      const double truth = brdf::dhr(brdf::Model::by_name(scene.model), scene.truth[w],
                                     dhr.wavelength_nm * 1e-3, optics::radians(dhr.theta_i_deg))
                               .unpolarized;
      out.count("dhr", truth >= dhr.lo && truth <= dhr.hi);
    }
  }
  return out;
}

void print(const char* what, const Coverage& coverage) {
  std::cout << what << ": " << coverage.inside << "/" << coverage.all << " = " << coverage.share();
  for (const auto& [name, counts] : coverage.by_name) {
    std::cout << "; " << name << " " << counts.first << "/" << counts.second;
  }
  std::cout << "\n";
}

TEST(Intervals, CoverTheTruthAsOftenAsTheyPromise) {
  test::Scene scene = test::black_paint();
  scene.gain_sigma = 0.005;
  Options options = test::quick(scene);
  options.dhr = true;
  options.dhr_theta_i_deg = {30};
  const Coverage coverage = coverage_of(scene, options, 60);
  print("microfacet+nef", coverage);
  EXPECT_GT(coverage.share(), 0.92);
  EXPECT_LT(coverage.share(), 0.98);
}

TEST(Intervals, CoverTheTruthForTheFourCoefficientModelToo) {
  test::Scene scene = test::red_gloss();
  scene.gain_sigma = 0.005;
  scene.theta_r_step = 4;
  Options options = test::quick(scene);
  options.dhr = true;
  options.dhr_theta_i_deg = {30};
  const Coverage coverage = coverage_of(scene, options, 40);
  print("li-torrance", coverage);
  EXPECT_GT(coverage.share(), 0.90);
  EXPECT_LT(coverage.share(), 0.98);
}

TEST(Intervals, CoverTheTruthUnderThePapersObjectiveToo) {
  test::Scene scene = test::black_paint();
  scene.gain_sigma = 0.005;
  scene.floor_per_sr = 2e-5;  // relative deviations need a signal everywhere
  Options options = test::quick(scene);
  options.objective = Objective::paper;
  const Coverage coverage = coverage_of(scene, options, 40);
  print("paper objective", coverage);
  EXPECT_GT(coverage.share(), 0.91);
  EXPECT_LT(coverage.share(), 0.985);
}

TEST(Intervals, GainErrorWidensWhatScalesWithItAndNothingElse) {
  test::Scene scene = test::black_paint();
  Options options = test::quick(scene);
  options.free = {"0.bias"};  // with its scale free the lobe cannot tell the gain
  options.spectral = {"0.bias"};
  const FitResult sharp = invert(test::make(scene, 1).table, options);
  scene.gain_sigma = 0.02;
  const FitResult wide = invert(test::make(scene, 1).table, options);
  const auto width = [](const FitResult& fit, const char* name) {
    const auto& e = fit.find(name)->estimates[0];
    return (e.hi - e.lo) / e.value;
  };
  // One sigma of 2 % in quadrature with the noise.
  const double noise = width(sharp, "1.rho_d2");
  EXPECT_NEAR(width(wide, "1.rho_d2"), std::hypot(noise, 2 * 1.96 * 0.02), 0.2 * 2 * 1.96 * 0.02);
  EXPECT_NEAR(width(wide, "0.slope_rms"), width(sharp, "0.slope_rms"),
              0.2 * width(sharp, "0.slope_rms"));
}

TEST(Intervals, AGainErrorDoesNotPullTheModelDown) {
  // Scaling the noisy data instead of the model would lower it by the number of points times the
  // square of the gain's uncertainty: to a fraction, here.
  test::Scene scene;
  scene.model = "lambertian";
  scene.wavelengths_nm = {532};
  scene.truth = {{0.5}};
  scene.relative_noise = 0.1;
  scene.gain_sigma = 0.05;
  scene.theta_r_step = 1;
  auto made = test::make(scene, 3);
  const FitResult fit = invert(made.table, test::quick(scene));
  const double expected = 0.5 * (1 + scene.gain_sigma * made.gains[0]);
  EXPECT_NEAR(fit.find("rho")->estimates[0].value, expected, 0.015 * expected);
  EXPECT_LE(fit.find("rho")->estimates[0].lo, 0.5);
  EXPECT_GE(fit.find("rho")->estimates[0].hi, 0.5);
  ASSERT_EQ(fit.factors.size(), 1U);
  EXPECT_NEAR(fit.factors[0].value, 0, 0.2);
  EXPECT_NEAR(fit.factors[0].standard_error, 1, 0.1);
}

TEST(Intervals, AnAdditiveCommonErrorIsTakenAsOne) {
  test::Scene scene = test::black_paint();
  scene.wavelengths_nm = {532};
  scene.truth = {{1.5, 0.30, 0.12, 1, 0.010, 0.0040}};
  auto made = test::make(scene, 4);
  formats::BrdfTable::Factor stray{"stray light", {}};
  for (std::size_t i = 0; i < made.table.points.size(); ++i) {
    stray.per_point.push_back(0.002);
    made.table.points.brdf_per_sr[i] += 1.5 * 0.002;
  }
  made.table.factors.push_back(stray);
  const Observations data = observations(made.table, 0);
  EXPECT_FALSE(data.spectra[0].common[0].relative);
  Options options = test::quick(scene);
  // Only the diffuse level is confused with it, and that is fixed here.
  options.fix = {{"1.rho_d1", std::nullopt, 0.010}};
  const FitResult fit = invert(made.table, options);
  EXPECT_NEAR(fit.factors[0].value, 1.5, 3 * fit.factors[0].standard_error);
  EXPECT_LT(fit.factors[0].standard_error, 0.2);
}

TEST(Intervals, HeightAndLengthOfARoughSurfaceAreNamedAsConfused) {
  test::Scene scene = test::red_gloss();
  scene.relative_noise = 0.02;
  for (auto& values : scene.truth) {
    values[2] = 4;  // phase variance in the thousands: geometrical optics
    values[3] = 60;
  }
  const FitResult fit = invert(test::make(scene, 2).table, test::quick(scene));
  const auto pair =
      std::find_if(fit.correlations.begin(), fit.correlations.end(),
                   [](const auto& c) { return c.first == "sigma_um" && c.second == "tau_um"; });
  ASSERT_NE(pair, fit.correlations.end());
  EXPECT_GT(pair->coefficient, 0.99);
  EXPECT_FALSE(fit.find("sigma_um")->estimates[0].identifiable);
  EXPECT_TRUE(std::any_of(
      fit.identifiability.begin(), fit.identifiability.end(),
      [](const std::string& s) { return s.find("the slope 2 sigma/tau") != std::string::npos; }));
  const auto& slope = fit.find("slope_2sigma_over_tau")->estimates[0];
  EXPECT_NEAR(slope.value, 2 * 4.0 / 60, 0.01 * slope.value);
  EXPECT_LE(slope.lo, 2 * 4.0 / 60);
  EXPECT_GE(slope.hi, 2 * 4.0 / 60);
}

TEST(Intervals, TheTwoDiffuseCoefficientsAreNamedAsConfusedAndTheirSumIsGiven) {
  const test::Scene scene = test::red_gloss();
  const FitResult fit = invert(test::make(scene, 3).table, test::quick(scene));
  const auto pair =
      std::find_if(fit.correlations.begin(), fit.correlations.end(), [](const auto& c) {
        return c.first == "k_udf" && c.second == "k_uds" && c.first_wavelength_nm == 532.0;
      });
  ASSERT_NE(pair, fit.correlations.end());
  EXPECT_LT(pair->coefficient, -0.95);
  EXPECT_TRUE(
      std::any_of(fit.identifiability.begin(), fit.identifiability.end(), [](const std::string& s) {
        return s.find(
                   "k_udf and k_uds are hard to separate at 532 nm by polarised data in the plane "
                   "of incidence: correlation -0.99") == 0 &&
               s.find("their sum") != std::string::npos;
      }));
  const auto& sum = fit.find("k_udf+k_uds")->estimates;
  for (std::size_t w = 0; w < 3; ++w) {
    const double truth = scene.truth[w][5] + scene.truth[w][6];
    EXPECT_NEAR(sum[w].value, truth, 4 * sum[w].standard_error);
    EXPECT_LT(sum[w].hi - sum[w].lo,
              0.8 * (fit.find("k_udf")->estimates[w].hi - fit.find("k_udf")->estimates[w].lo));
  }
}

TEST(Intervals, AnAbsentTermEndsAtItsBoundWithAnUpperLimit) {
  test::Scene scene = test::black_paint();
  for (auto& values : scene.truth) values[5] = 0;
  int at_bound = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const FitResult fit = invert(test::make(scene, seed).table, test::quick(scene));
    for (const auto& e : fit.find("1.rho_d2")->estimates) {
      EXPECT_EQ(e.lo, 0);
      EXPECT_GT(e.hi, 0);
      EXPECT_LT(e.hi, 1e-3);
      EXPECT_FALSE(e.identifiable);
      if (e.at_bound == "lower") {
        ++at_bound;
        EXPECT_EQ(e.value, 0);
      }
    }
  }
  EXPECT_GE(at_bound, 1);
  EXPECT_LE(at_bound, 7);
}

TEST(Intervals, AUserBoundIsKeptAndReported) {
  const test::Scene scene = test::black_paint();
  Options options = test::quick(scene);
  options.bound = {{"0.slope_rms", std::nullopt, 0.13, 0.3}};
  const FitResult fit = invert(test::make(scene, 5).table, options);
  EXPECT_DOUBLE_EQ(fit.find("0.slope_rms")->estimates[0].value, 0.13);
  EXPECT_EQ(fit.find("0.slope_rms")->estimates[0].at_bound, "lower");
  EXPECT_NE(std::find(fit.at_bound.begin(), fit.at_bound.end(), "0.slope_rms"), fit.at_bound.end());
}

TEST(Intervals, AnOptimumOnALimitIsTheOneWithTheParameterFixedThere) {
  const test::Scene scene = test::black_paint();
  const auto made = test::make(scene, 5);
  Options limited = test::quick(scene), fixed = test::quick(scene);
  limited.bound = {{"0.slope_rms", std::nullopt, 0.13, 0.3}, {"1.rho_d1", std::nullopt, 0, 0.012}};
  fixed.fix = {{"0.slope_rms", std::nullopt, 0.13}, {"1.rho_d1", 814, 0.012}};
  const FitResult a = invert(made.table, limited), b = invert(made.table, fixed);
  EXPECT_EQ(a.find("1.rho_d1")->estimates[1].at_bound, "upper");
  EXPECT_NEAR(a.chi2, b.chi2, 1e-5 * b.chi2);
  for (const char* name : {"0.n", "0.kappa", "1.rho_d2"}) {
    const auto &e = a.find(name)->estimates[0], &f = b.find(name)->estimates[0];
    EXPECT_NEAR(e.value, f.value, 0.02 * (f.hi - f.lo)) << name;
  }
}

TEST(Intervals, ReflectanceIsTheModelsAndItsIntervalFollowsTheGain) {
  test::Scene scene = test::red_gloss();
  scene.gain_sigma = 0.01;
  Options options = test::quick(scene);
  options.dhr = true;
  options.dhr_theta_i_deg = {0, 30};
  const FitResult fit = invert(test::make(scene, 6).table, options);
  ASSERT_EQ(fit.dhr.size(), 6U);
  for (const auto& dhr : fit.dhr) {
    const auto w = *fit.wavelength_index(dhr.wavelength_nm);
    const double value = brdf::dhr(brdf::Model::by_name(fit.model), fit.values_at(w),
                                   dhr.wavelength_nm * 1e-3, optics::radians(dhr.theta_i_deg))
                             .unpolarized;
    EXPECT_NEAR(dhr.value, value, 1e-5);
    EXPECT_NEAR((dhr.hi - dhr.lo) / dhr.value, 2 * 1.96 * 0.01, 0.15 * 2 * 1.96 * 0.01);
  }
}

TEST(Intervals, HemisphereCarriesTheUncertaintyOfTheFit) {
  test::Scene scene = test::red_gloss();
  scene.gain_sigma = 0.01;
  const FitResult fit = invert(test::make(scene, 7).table, test::quick(scene));
  const Hemisphere h = hemisphere(fit, 532, 30, 10, 30);
  ASSERT_EQ(h.theta_r_deg.size(), 9U);
  ASSERT_EQ(h.phi_r_deg.size(), 12U);
  ASSERT_EQ(h.brdf_per_sr.size(), 108U);
  for (std::size_t i = 0; i < h.brdf_per_sr.size(); ++i) {
    EXPECT_GT(h.brdf_per_sr[i], 0);
    EXPECT_GT(h.brdf_u[i], 0.0099 * h.brdf_per_sr[i]) << "at least the gain's";
    EXPECT_LT(h.brdf_u[i], 0.10 * h.brdf_per_sr[i]);
  }
  const std::string path = testing::TempDir() + "umov_hemisphere_test.h5";
  formats::Provenance provenance;
  provenance.program = "umov test";
  provenance.command = "umov invert brdf.h5";
  write_hemispheres_hdf5(path, {h}, provenance, {{"data_sha256", "0123"}});
  const formats::Hdf5Reader file(formats::read_whole_file(path), path);
  formats::Keys keys;
  EXPECT_EQ(formats::read_h5_header(file, "umov hemisphere h5", keys).command, provenance.command);
  EXPECT_EQ(keys, (formats::Keys{{"data_sha256", "0123"}}));
  std::size_t rows = 0, columns = 0;
  EXPECT_EQ(file.matrix("/hemisphere_532_30/brdf_per_sr", rows, columns), h.brdf_per_sr);
  EXPECT_EQ(rows, 9U);
  EXPECT_EQ(columns, 12U);
  EXPECT_EQ(file.doubles("/hemisphere_532_30/theta_r_deg"), h.theta_r_deg);
  std::filesystem::remove(path);
  // A fit read back from its file says the same.
  const Hemisphere again =
      hemisphere(formats::fit_from_json(formats::fit_to_json(fit), "fit"), 532, 30, 10, 30);
  EXPECT_EQ(again.brdf_u, h.brdf_u);
}

}  // namespace
}  // namespace umov::invert
