// Curves out of a reduced measurement, a fit against the truth, and the bench that runs on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "host/brdf/model.hpp"
#include "host/cli/study/bench.hpp"
#include "host/cli/study/reduced.hpp"

namespace umov::study {
namespace {

using testing::ElementsAre;

constexpr double open = std::numeric_limits<double>::quiet_NaN();

void add(formats::BrdfTable& table, double theta_r, double polarizer, double analyzer, double value,
         int used = 1, double phi = 0) {
  auto& p = table.points;
  p.theta_i_deg.push_back(30);
  p.theta_r_deg.push_back(theta_r);
  p.phi_r_deg.push_back(phi);
  p.wavelength_nm.push_back(532);
  p.polarizer_deg.push_back(polarizer);
  p.analyzer_deg.push_back(analyzer);
  p.brdf_per_sr.push_back(value);
  p.brdf_u.push_back(0.3);
  p.used.push_back(used);
}

TEST(UnpolarisedCurve, IsTheMeanOfBothIncidencesWhereBothAreThere) {
  formats::BrdfTable table;
  add(table, 20, 0, open, 1);
  add(table, -10, 0, open, 3);
  add(table, -10, 90, open, 5);
  add(table, 20, 90, open, 2);
  add(table, 40, 0, open, 7);        // no S
  add(table, 20, 0, 0, 100);         // another state
  add(table, 20, 90, open, 100, 0);  // unusable
  add(table, 20, 90, open, 100, 1, 90);
  const Curve curve = unpolarised_curve(table, 532, 30);
  EXPECT_THAT(curve.theta_r_deg, ElementsAre(-10, 20));
  EXPECT_THAT(curve.value, ElementsAre(4, 1.5));
  EXPECT_NEAR(curve.u[0], 0.3 / std::sqrt(2), 1e-12);
}

/// A fit that was made of nothing but the emulator's true parameters.
formats::FitResult true_fit(const emulator::SampleTruth& truth, double k_uds_factor) {
  formats::FitResult fit;
  fit.model = "li-torrance";
  fit.wavelengths_nm = {633};
  const auto model = brdf::Model::by_name(fit.model);
  for (const auto& p : model.parameters()) {
    formats::FitParameter parameter;
    parameter.name = p.name;
    parameter.shared = false;
    parameter.estimates.resize(1);
    parameter.estimates[0].value =
        truth.parameter(p.name, 633) * (p.name == "k_uds" ? k_uds_factor : 1);
    fit.parameters.push_back(parameter);
  }
  return fit;
}

TEST(HemisphereError, OfTheTrueModelIsNothing) {
  const emulator::SampleTruth truth("red-gloss");
  const auto error = hemisphere_error(true_fit(truth, 1), truth, 633, 30);
  EXPECT_GT(error.directions, 1000u);
  EXPECT_LT(error.max, 1e-4) << "two programs of the same formula";
}

TEST(HemisphereError, OfAWrongDiffusePartIsThatPartsShare) {
  const emulator::SampleTruth truth("red-gloss");
  const auto error = hemisphere_error(true_fit(truth, 1.05), truth, 633, 30);
  EXPECT_GT(error.max, 0.03);
  EXPECT_LT(error.max, 0.05 + 1e-6) << "all of the light cannot err more than its part";
  EXPECT_GT(std::hypot(error.max_theta_r_deg - 30, error.max_phi_r_deg), 10)
      << "away from the lobe";
  EXPECT_LE(error.median, error.p90);
  EXPECT_LE(error.p90, error.max);
  const auto both = together({error, hemisphere_error(true_fit(truth, 1), truth, 633, 30)});
  EXPECT_EQ(both.directions, 2 * error.directions);
  EXPECT_EQ(both.max, error.max);
}

TEST(SampleTruth, KnowsWhatTheSampleFilesSay) {
  const emulator::SampleTruth paint("red-gloss"), white("white-70");
  EXPECT_DOUBLE_EQ(paint.parameter("k_udf", 633), 0.0030);
  EXPECT_NEAR(white.dhr(0, 814), 0.62, 1e-4);
  EXPECT_GT(paint.dhr(30, 532), paint.dhr(30, 532, false) - 1e-12);
  EXPECT_GT(paint.dolp(30, 30, 0, 532), paint.dolp(30, 30, 0, 633));
  emulator::BenchOptions bench;
  bench.sample = "germanium";
  bench.preset = "realistic";
  const emulator::EmulatedInstrument instrument(bench);
  EXPECT_DOUBLE_EQ(emulator::polarizer_truth(instrument).extinction, 1e-4);
  EXPECT_NE(emulator::polarizer_truth(instrument).axis_deg,
            emulator::analyzer_truth(instrument).axis_deg);
}

TEST(Bench, MeasuresOneSampleAfterTheOtherAndTimeGoesOn) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("umov-bench-" + std::to_string(getpid()));
  Options options;
  options.seed = 3;
  std::vector<double> shares;
  options.progress = [&](double share, const std::string&) { shares.push_back(share); };
  Bench bench(options, folder, "ideal", "white-99");
  bench.wait(5);
  const std::string plan =
      "sample = \"x\"\nwavelengths_nm = [633]\ntheta_i_deg = [30]\ntheta_r_deg = [-20, 0, 20]\n"
      "states = [[\"open\", \"open\"]]\ndwell_ms = 10\n[[block]]\nmenu = \"no_sample\"\n";
  const auto white = bench.measure("white", plan, "white-99", 0, 0.5);
  const auto black = bench.measure("black", plan, "black-matte", 0.5, 1);
  EXPECT_EQ(bench.records(), static_cast<std::size_t>(2 * (3 + 2)));
  EXPECT_EQ(white.key("device"), black.key("device")) << "one instrument";
  EXPECT_GT(white.x_v[0] / white.monitor_v[0], 10 * black.x_v[0] / black.monitor_v[0]);
  EXPECT_LT(std::abs(white.x_v[3]), 1e-3 * white.x_v[1]) << "the empty stage";
  EXPECT_GE(*std::max_element(shares.begin(), shares.end()), 0.9);
  options.keep_going = [] { return false; };
  EXPECT_THROW(bench.measure("again", plan, "white-99", 0, 1), Stopped);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace umov::study
