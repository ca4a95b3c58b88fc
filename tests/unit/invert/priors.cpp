// Knowledge from elsewhere: in the objective, in the intervals, in the file, and refused.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "host/errors/error.hpp"
#include "host/invert/invert.hpp"
#include "host/invert/limited_profile.hpp"
#include "host/invert/prior.hpp"
#include "tests/unit/invert/synthetic_measurement.hpp"

namespace umov::invert {
namespace {

TEST(Priors, OneActsLikeOneMoreMeasurement) {
  test::Scene scene;
  scene.model = "lambertian";
  scene.wavelengths_nm = {532};
  scene.truth = {{0.5}};
  scene.relative_noise = 0.05;
  const auto made = test::make(scene, 1);
  Options options = test::quick(scene);
  const auto alone = invert(made.table, options).find("rho")->estimates[0];
  options.priors = {parse_prior("rho=0.51±0.002")};
  const auto fit = invert(made.table, options);
  const auto both = fit.find("rho")->estimates[0];
  const double a = 1 / std::pow(alone.standard_error, 2), b = 1 / std::pow(0.002, 2);
  EXPECT_NEAR(both.value, (a * alone.value + b * 0.51) / (a + b), 1e-6);
  EXPECT_NEAR(both.standard_error, 1 / std::sqrt(a + b), 1e-3 / std::sqrt(a + b));
  EXPECT_EQ(fit.priors, (std::vector<std::string>{"rho = 0.51 ± 0.002"}));
  const double expected = fit.chi2 + std::pow((both.value - 0.51) / 0.002, 2);
  EXPECT_NEAR(fit.objective, expected, 1e-6 * expected);
  EXPECT_EQ(formats::fit_from_json(formats::fit_to_json(fit), "fit").priors, fit.priors);
}

TEST(Priors, AnOrderHoldsTheWeakExtinctionsDownAndLeavesTheStrongOneAlone) {
  test::Scene scene = test::black_paint();
  scene.truth[0][1] = 0.6;
  scene.truth[1][1] = 0.0;
  scene.relative_noise = 0.02;
  const auto made = test::make(scene, 3);
  Options options = test::quick(scene);
  const auto alone = invert(made.table, options);
  options.priors = {parse_prior("0.kappa-order")};
  const auto fit = invert(made.table, options);
  const auto& weak = fit.find("0.kappa")->estimates[1];
  EXPECT_LT(weak.hi, 0.4);
  EXPECT_LE(weak.hi, alone.find("0.kappa")->estimates[1].hi + 1e-9);
  const auto& strong = fit.find("0.kappa")->estimates[0];
  EXPECT_LE(strong.lo, 0.6);
  EXPECT_GE(strong.hi, 0.6);
}

TEST(Priors, AnOrderThatTheDataContradictCostsWhatItSays) {
  const test::Scene scene = test::black_paint();  // 0.30 at 532 nm, 0.20 at 814 nm: not threefold
  const auto made = test::make(scene, 2);
  Options options = test::quick(scene);
  options.robust_sigma = 0;  // the objective is then chi² and what the prior adds
  const auto free = invert(made.table, options);
  options.priors = {parse_prior("0.kappa-order@532=3")};
  const auto held = invert(made.table, options);
  const auto excess = [](const formats::FitResult& fit) {
    const auto& kappa = fit.find("0.kappa")->estimates;
    return (9 * kappa[1].value * kappa[1].value - kappa[0].value * kappa[0].value) / 0.01;
  };
  EXPECT_GT(held.objective, free.objective);
  EXPECT_LT(excess(held), excess(free));
  EXPECT_NEAR(held.objective, held.chi2 + std::pow(std::max(excess(held), 0.0), 2),
              1e-6 * held.objective);
  // The other order is no news to the data.
  options.priors = {parse_prior("0.kappa-order@814=0.1")};
  EXPECT_NEAR(invert(made.table, options).objective, free.objective, 1e-6 * free.objective);
}

TEST(Priors, AHingeShapesTheProfileAsASearchOfThePlaneDoes) {
  const Eigen::Matrix2d covariance = (Eigen::Matrix2d() << 1, 0.6, 0.6, 2).finished();
  const Eigen::Vector2d centre(0.4, -0.3);
  const Hinge hinge{-0.5, Eigen::Vector2d(1.5, -0.7)};
  const Eigen::Vector2d far = Eigen::Vector2d::Constant(1e9);
  const LimitedProfile profile(covariance, centre, -far, far, {hinge});
  ASSERT_TRUE(profile.limited());
  const Eigen::Matrix2d precision = covariance.inverse();
  const auto chi2 = [&](const Eigen::Vector2d& x) {
    const double over = std::max(0.0, hinge.value + hinge.slope.dot(x));
    return (x - centre).dot(precision * (x - centre)) + over * over;
  };
  constexpr int n = 1200;
  double least = 1e300;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      least = std::min(least, chi2({-8 + 16.0 * i / n, -8 + 16.0 * j / n}));
    }
  }
  for (const Eigen::Vector2d& gradient : {Eigen::Vector2d(1, 0), Eigen::Vector2d(0.3, 1)}) {
    double lo = 1e300, hi = -1e300;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const Eigen::Vector2d x(-8 + 16.0 * i / n, -8 + 16.0 * j / n);
        if (chi2(x) > least + 3.841458820694124) continue;
        lo = std::min(lo, gradient.dot(x));
        hi = std::max(hi, gradient.dot(x));
      }
    }
    EXPECT_NEAR(profile.extreme(gradient, +1, 3.841458820694124), hi, 0.03);
    EXPECT_NEAR(profile.extreme(gradient, -1, 3.841458820694124), lo, 0.03);
  }
}

TEST(Priors, AreReadFromTextInEveryForm) {
  for (const char* text : {"n=1.5±0.02", "n=1.5+-0.02", "n=1.5+/-0.02"}) {
    const Prior prior = parse_prior(text);
    EXPECT_EQ(prior.name, "n");
    EXPECT_EQ(prior.value, 1.5);
    EXPECT_EQ(prior.u, 0.02);
    EXPECT_FALSE(prior.wavelength_nm);
  }
  EXPECT_EQ(parse_prior("kappa@532=0.3±0.1").wavelength_nm, 532.0);
  EXPECT_EQ(parse_prior("kappa-order").name, "kappa");
  EXPECT_EQ(parse_prior("0.kappa-order@814=5").ratio, 5);
  for (const char* text : {"", "n", "n=1.5", "=1±1", "n=a±1", "kappa-order=-2", "n@x=1±1"}) {
    EXPECT_THROW(parse_prior(text), Error) << text;
  }
}

TEST(Priors, AreRefusedWhereTheyCannotAct) {
  const test::Scene scene = test::black_paint();
  const auto made = test::make(scene, 1);
  const auto refusal = [&](const char* text, auto change) {
    Options options = test::quick(scene);
    options.priors = {parse_prior(text)};
    change(options);
    try {
      invert(made.table, options);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto nothing = [](Options&) {};
  EXPECT_NE(refusal("sigma_um=1±1", nothing).find("no parameter"), std::string::npos);
  EXPECT_NE(refusal("0.n=1.5±0", nothing).find("width"), std::string::npos);
  EXPECT_NE(refusal("0.bias=1±0.1", nothing).find("fixed"), std::string::npos);
  EXPECT_NE(refusal("0.n@532=1.5±0.1", nothing).find("shared"), std::string::npos);
  EXPECT_NE(refusal("0.kappa@700=1±0.1", nothing).find("wavelength"), std::string::npos);
  EXPECT_NE(refusal("0.kappa-order", [](Options& o) { o.share = {"0.kappa"}; }).find("order"),
            std::string::npos);
  EXPECT_NE(
      refusal("0.n=1.5±0.1", [](Options& o) { o.objective = Objective::paper; }).find("relative"),
      std::string::npos);
}

}  // namespace
}  // namespace umov::invert
