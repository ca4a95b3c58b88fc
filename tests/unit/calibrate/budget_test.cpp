#include "host/calibrate/budget.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>

#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

using namespace test;

struct Case {
  Calibration calibration;
  Reduction reduction;
};

Case small_case() {
  Instrument instrument;
  Plan plan;
  plan.step = 12;
  auto white = make_white(instrument, 0.9, plan, 1, 0.005);
  white.set_key("reference_shape_u", "0.1");
  add_closed(white, instrument, {10, 100}, 12, 1);
  const StandardScan standard{white, ReferenceStandard::from_keys(white), "white", ""};
  CalibrateOptions options;
  options.declared.theta_r_zero_u_deg = 0.05;
  options.declared.theta_i_zero_u_deg = 0.05;
  options.linearity = Linearity{};
  options.linearity->ranges.ranges = {{10, 0, 0, false}, {100, 0, 2e-3, true}};
  options.linearity->ranges.covariance = Eigen::Vector2d(0, 4e-6).asDiagonal();
  options.linearity->nonlinearity.kappa_u_per_v = 0.05;
  options.linearity->nonlinearity.with_ranges = Eigen::Vector2d::Zero();
  options.linearity->nonlinearity.dof = 7;
  options.linearity->nonlinearity.measured = true;
  Case result;
  result.calibration = calibrate(std::span(&standard, 1), {}, options);
  const auto gloss = depolarising(
      [](double theta_r, double) { return 0.05 + 0.5 * std::exp(-std::pow(theta_r / 20, 2)); });
  result.reduction = reduce(make_scan(instrument, gloss, plan, 2), result.calibration);
  return result;
}

TEST(Budget, CombinesToExactlyWhatTheTableHas) {
  const Case c = small_case();
  const auto budget = budget_of(c.reduction, c.calibration);
  ASSERT_EQ(budget.size(), c.reduction.table.points.size());
  for (const PointBudget& point : budget) {
    const std::size_t i = point.point;
    double variance = std::pow(c.reduction.table.points.brdf_u[i], 2), sum = 0;
    for (const auto& factor : c.reduction.table.factors)
      variance += factor.per_point[i] * factor.per_point[i];
    for (const Contribution& part : point.contributions) sum += part.u_per_sr * part.u_per_sr;
    EXPECT_NEAR(point.combined_u, std::sqrt(variance), 1e-12 * point.combined_u);
    EXPECT_NEAR(point.combined_u * point.combined_u, sum, 1e-9 * sum);
    EXPECT_DOUBLE_EQ(point.expanded_u, point.coverage_factor * point.combined_u);
  }
}

TEST(Budget, NamesItsContributionsWithTypeUnitAndSensitivity) {
  const Case c = small_case();
  const auto budget = budget_of(c.reduction, c.calibration);
  const auto find = [&](std::size_t point, const std::string& name) -> const Contribution* {
    for (const Contribution& part : budget[point].contributions)
      if (part.name == name) return &part;
    return nullptr;
  };
  for (const char* name :
       {"noise", "gain", "reference standard", "reference shape", "dark range 10", "gain range 100",
        "detector nonlinearity", "detector zero"})
    EXPECT_NE(find(3, name), nullptr) << name;
  const double f = c.reduction.table.points.brdf_per_sr[3];
  const Contribution& standard = *find(3, "reference standard");
  EXPECT_EQ(standard.type, 'B');
  EXPECT_NEAR(std::abs(standard.sensitivity), f, 1e-9);  // the BRDF goes with the scale
  EXPECT_NEAR(standard.input_u, 0.005 / 0.9, 1e-9);
  EXPECT_TRUE(std::isinf(standard.dof));
  const Contribution& law = *find(3, "detector nonlinearity");
  EXPECT_EQ(law.type, 'A');
  EXPECT_EQ(law.unit, "1/V");
  EXPECT_EQ(law.dof, 7);
  EXPECT_NEAR(law.u_per_sr, std::abs(law.sensitivity) * law.input_u, 1e-12);
  EXPECT_EQ(find(3, "dark range 10")->dof, 11);
  EXPECT_EQ(find(3, "noise")->sensitivity, 1);
}

TEST(Budget, FewDegreesOfFreedomWidenTheCoverage) {
  EXPECT_NEAR(coverage_factor_95(std::numeric_limits<double>::infinity()), 1.959964, 1e-6);
  EXPECT_NEAR(coverage_factor_95(10), 2.228139, 1e-6);
  EXPECT_NEAR(coverage_factor_95(4), 2.776445, 1e-6);
  Case c = small_case();
  // Nearly all of the variance on the seven degrees of freedom of the nonlinearity.
  for (auto& factor : c.reduction.table.factors)
    if (factor.name == "detector nonlinearity")
      for (double& shift : factor.per_point) shift = 1.0;
  const auto budget = budget_of(c.reduction, c.calibration);
  EXPECT_NEAR(budget[0].effective_dof, 7, 0.01);
  EXPECT_NEAR(budget[0].coverage_factor, 2.3646, 1e-3);
}

TEST(Budget, NamesOfFactorsLoseColumnsAndWavelengthsButNotRanges) {
  EXPECT_EQ(contribution_name("gain 532 nm"), "gain");
  EXPECT_EQ(contribution_name("instrument function 532 nm 3"), "instrument function");
  EXPECT_EQ(contribution_name("stray light 4"), "stray light");
  EXPECT_EQ(contribution_name("gain range 100"), "gain range 100");
  EXPECT_EQ(contribution_name("scan dark range 1000"), "scan dark range 1000");
  EXPECT_EQ(contribution_name("polarizer axis 632.8 nm"), "polarizer axis");
  EXPECT_EQ(contribution_name("reference standard"), "reference standard");
  EXPECT_EQ(contribution_name("detector stop -85"), "detector stop");
  EXPECT_EQ(contribution_name("source 532 nm 30"), "source");
}

TEST(Budget, IsWrittenAsCsvAndJsonWithACombinedLineAPoint) {
  const Case c = small_case();
  const auto budget = budget_of(c.reduction, c.calibration);
  const std::string folder = ::testing::TempDir();
  write_budget(folder + "/budget.csv", c.reduction, budget);
  std::ifstream csv(folder + "/budget.csv");
  std::string line;
  std::size_t combined = 0, columns = 0;
  while (std::getline(csv, line)) {
    if (line.starts_with("point,"))
      columns = static_cast<std::size_t>(std::count(line.begin(), line.end(), ','));
    if (line.starts_with("#") || columns == 0) continue;
    EXPECT_EQ(static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')), columns) << line;
    combined += line.find(",combined,") != std::string::npos;
  }
  EXPECT_EQ(combined, budget.size());
  write_budget(folder + "/budget.json", c.reduction, budget,
               std::vector<double>(budget.size(), 0.5));
  std::ifstream file(folder + "/budget.json");
  const auto parsed = nlohmann::json::parse(file);
  ASSERT_EQ(parsed["points"].size(), budget.size());
  EXPECT_NEAR(parsed["points"][2]["expanded_u_per_sr"].get<double>(), budget[2].expanded_u, 1e-12);
  EXPECT_EQ(parsed["points"][2]["monte_carlo_u_per_sr"], 0.5);
}

}  // namespace
}  // namespace umov::calibrate
