#include "host/calibrate/monte_carlo.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/calibrate/budget.hpp"
#include "host/errors/error.hpp"
#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

using namespace test;

CampaignScan named(formats::ScanTable table, const std::string& name, const std::string& role) {
  table.set_key("role", role);
  table.set_key("sample", name);
  return {std::move(table), name + ".h5", name, role, name};
}

/// A campaign of a white standard with a curved instrument function, dark signal and unmeasured
/// ranges, and a sample with power steps and a part without a sample.
struct SmallCampaign {
  SmallCampaign() {
    Instrument instrument;
    instrument.instrument_function = [](double t) { return 1 + 0.15 * std::pow(t / 85, 2); };
    instrument.source_relative = 1e-3;
    Plan plan;
    plan.step = 12;
    auto white = make_white(instrument, 0.9, plan, 1, 0.004);
    white.set_key("reference_shape_u", "0.02");
    add_closed(white, instrument, {10, 100}, 10, 1);
    const auto sample = depolarising([](double theta_r, double) {
      return 0.05 + 0.4 * std::exp(-std::pow((theta_r - 20) / 25, 2));
    });
    auto scan = make_scan(instrument, sample, plan, 2);
    for (double power : {0.3, 0.1}) {
      Instrument dimmed = instrument;
      dimmed.power = power;
      append(scan, make_scan(dimmed, sample, plan, 3 + static_cast<std::uint64_t>(100 * power)),
             "nd");
    }
    Plan empty = plan;
    empty.gain = 1000;
    add_no_sample(scan, instrument, empty, 5);
    add_closed(scan, instrument, {100, 1000}, 10, 6);
    scans = {named(white, "white", "white"), named(scan, "gloss", "sample")};
    options.max_degree = 2;
    options.stray.tolerance_per_sr = 1e-3;
    options.declared.theta_r_zero_u_deg = 0.05;
    options.declared.theta_r_eccentricity_u_deg = 0.03;
    options.declared.source_relative_u = 0.002;
    campaign = evaluate_campaign(scans, options);
    reduce_options.dolp = false;
    reduction = reduce(scans[1].table, campaign.calibration, reduce_options);
    for (const auto& point : budget_of(reduction, campaign.calibration))
      propagated.push_back(point.combined_u);
  }
  std::vector<CampaignScan> scans;
  CampaignOptions options;
  Campaign campaign;
  ReduceOptions reduce_options;
  Reduction reduction;
  std::vector<double> propagated;
};

MonteCarlo draw(const SmallCampaign& c, std::size_t draws, std::uint64_t seed, int threads = 2) {
  MonteCarloOptions options;
  options.draws = draws;
  options.seed = seed;
  options.threads = threads;
  return monte_carlo(c.scans, c.options, c.campaign, c.scans[1], c.reduction, c.reduce_options,
                     options);
}

TEST(MonteCarlo, AgreesWithThePropagationAndSeesADroppedFactor) {
  const SmallCampaign c;
  const MonteCarlo draws = draw(c, 300, 7);
  EXPECT_EQ(draws.failed, 0U);
  const auto& used = c.reduction.table.points.used;
  const auto agreement = compare_with_draws(draws, c.propagated, used);
  RecordProperty("mean_ratio", std::to_string(agreement.mean_ratio));
  RecordProperty("smallest", std::to_string(agreement.smallest_ratio));
  RecordProperty("largest", std::to_string(agreement.largest_ratio));
  EXPECT_TRUE(agreement.agrees) << agreement.mean_ratio << " " << agreement.smallest_ratio << " "
                                << agreement.largest_ratio << " outside " << agreement.outside;
  EXPECT_NEAR(agreement.mean_ratio, 1, 0.1);

  // A budget that forgets the standard's scale must be found out.
  Reduction without = c.reduction;
  std::erase_if(without.table.factors,
                [](const auto& factor) { return factor.name == "reference standard"; });
  ASSERT_LT(without.table.factors.size(), c.reduction.table.factors.size());
  std::vector<double> too_small;
  for (const auto& point : budget_of(without, c.campaign.calibration))
    too_small.push_back(point.combined_u);
  EXPECT_FALSE(compare_with_draws(draws, too_small, used).agrees);
  // And one that counts a contribution twice.
  std::vector<double> too_large = c.propagated;
  for (double& u : too_large) u *= 1.5;
  EXPECT_FALSE(compare_with_draws(draws, too_large, used).agrees);
}

TEST(MonteCarlo, DoesNotDependOnTheNumberOfThreads) {
  const SmallCampaign c;
  const MonteCarlo one = draw(c, 12, 3, 1), three = draw(c, 12, 3, 3), other = draw(c, 12, 4, 1);
  EXPECT_EQ(one.u_per_sr, three.u_per_sr);
  EXPECT_EQ(one.shift_per_sr, three.shift_per_sr);
  EXPECT_NE(one.u_per_sr, other.u_per_sr);
}

TEST(MonteCarlo, StopsWhereItIsToldAndRefusesTooFewDraws) {
  const SmallCampaign c;
  MonteCarloOptions options;
  options.draws = 100;
  options.threads = 1;
  options.progress = [](std::size_t done, std::size_t) { return done < 3; };
  EXPECT_THROW(monte_carlo(c.scans, c.options, c.campaign, c.scans[1], c.reduction,
                           c.reduce_options, options),
               Error);
  options.draws = 2;
  EXPECT_THROW(monte_carlo(c.scans, c.options, c.campaign, c.scans[1], c.reduction,
                           c.reduce_options, options),
               Error);
}

}  // namespace
}  // namespace umov::calibrate
