// The engine of the diagnosis on a telescope's pointing: terms that the base model leaves out.
#include <cmath>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/errors/error.hpp"
#include "host/gap/engine/diagnosis.hpp"
#include "host/gap/pointing/pointing_model.hpp"
#include "tests/unit/optional_data.hpp"

namespace umov::gap {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr double degree = 3.14159265358979323846 / 180;

/// A run over the whole sky, 60 stars, with errors in arc seconds and 1 arc second of noise.
template <class Error>
formats::PointingRun run_with(std::uint64_t seed, Error error) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise;
  std::uniform_real_distribution<double> altitude(15, 85), azimuth(0, 360);
  formats::PointingRun run;
  for (int i = 0; i < 60; ++i) {
    const double e = altitude(random), a = azimuth(random);
    const auto [de, da] = error(e * degree, a * degree);
    run.true_altitude_deg.push_back(e);
    run.true_azimuth_deg.push_back(a);
    run.encoder_altitude_deg.push_back(e - (de + noise(random)) / 3600);
    run.encoder_azimuth_deg.push_back(a - (da + noise(random)) / 3600 / std::cos(e * degree));
  }
  return run;
}

TEST(Pointing, AWellModelledTelescopeNeedsNothing) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const PointingModel model(run_with(seed,
                                       [](double, double) {
                                         return std::pair{12.0, 0.0};
                                       }),
                              {});
    const Diagnosis d = diagnose(model);
    EXPECT_EQ(d.verdict, Verdict::none_needed) << seed;
    EXPECT_THAT(d.causes, SizeIs(0)) << seed;
  }
}

TEST(Pointing, AWithheldTiltAndFlexureAreNamedWithTheirSizes) {
  const PointingModel model(
      run_with(
          7,
          [](double e, double a) {
            return std::pair{-9 * std::sin(a) - 14 * std::cos(e), 9 * std::cos(a) * std::sin(e)};
          }),
      {});
  const Diagnosis d = diagnose(model);
  EXPECT_EQ(d.verdict, Verdict::explained);
  ASSERT_THAT(d.causes, SizeIs(2));
  EXPECT_GT(d.closed_fraction.value, 0.95);
  EXPECT_NEAR(d.causes[0].share + d.causes[1].share, 1, 1e-6);
  for (const Cause& cause : d.causes) {
    EXPECT_GT(cause.probability, 0.95);
    const bool tilt = cause.effect == "azimuth_axis_tilt";
    EXPECT_TRUE(tilt || cause.effect == "tube_flexure") << cause.effect;
    const Interval& size = cause.parameters[tilt ? 1 : 0].interval;
    const double truth = tilt ? -9 : -14;
    EXPECT_LT(size.lo, truth);
    EXPECT_GT(size.hi, truth);
  }
}

TEST(Pointing, ATermInTheBaseIsNotACause) {
  const PointingModel model(run_with(3,
                                     [](double e, double) {
                                       return std::pair{-14 * std::cos(e), 0.0};
                                     }),
                            {"tube_flexure"});
  EXPECT_EQ(diagnose(model).verdict, Verdict::none_needed);
}

TEST(Pointing, UnknownTermsAndShortRunsAreRefused) {
  auto run = run_with(1, [](double, double) { return std::pair{0.0, 0.0}; });
  EXPECT_THROW(PointingModel(run, {"sag"}), Error);
  run = {};
  try {
    PointingModel(run, {});
    FAIL() << "an empty run was taken";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("too few"));
  }
}

// The real runs, where the folder of optional measurements holds them: residual RMS in arc seconds
// with nothing but offsets, and with all that was named, as published for these runs.
TEST(Pointing, RealRunsNameTheirTerms) {
  const auto folder = umov::testing::optional_data("mmt_pointing");
  if (!folder) GTEST_SKIP() << "no mmt_pointing/: name its folder in UMOV_DATA";
  struct Case {
    const char* file;
    double before, after;
    std::vector<std::string> named;
  };
  const Case cases[] = {{"point_20210821.dat", 10.5, 1.4, {"azimuth_axis_tilt", "tube_flexure"}},
                        {"point_20230702.dat", 21.2, 1.45, {"azimuth_axis_tilt", "collimation"}}};
  for (const Case& c : cases) {
    const PointingModel model(formats::read_pointing_run(*folder / c.file), {});
    const Diagnosis d = diagnose(model);
    const auto rms = [&](const Refit& fit) {
      const Eigen::VectorXd left = model.observations().value - fit.mean;
      return std::sqrt(2 * left.squaredNorm() / static_cast<double>(left.size()));
    };
    EXPECT_NEAR(rms(d.search.hypotheses[d.search.base].refit), c.before, 0.05) << c.file;
    EXPECT_LT(rms(d.search.hypotheses.front().refit), c.after) << c.file;
    std::vector<std::string> named;
    for (const Cause& cause : d.causes) named.push_back(cause.effect);
    for (const std::string& name : c.named) EXPECT_THAT(named, Contains(name)) << c.file;
  }
}

}  // namespace
}  // namespace umov::gap
