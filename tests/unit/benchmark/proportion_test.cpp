#include "host/gap/benchmark/proportion.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace umov::gap::benchmark {
namespace {

// Published intervals: R. Newcombe 1998, Statistics in Medicine 17, 857, table I, method 5.
TEST(Proportion, exact_intervals_are_those_of_the_literature) {
  struct Known {
    std::size_t hits, n;
    double lo, hi;
  };
  for (const Known& k : {Known{81, 263, 0.2527, 0.3676}, Known{15, 148, 0.0578, 0.1617},
                         Known{0, 20, 0.0, 0.1684}, Known{1, 29, 0.0009, 0.1776}}) {
    const Interval i = clopper_pearson(k.hits, k.n);
    EXPECT_NEAR(i.lo, k.lo, 6e-5);
    EXPECT_NEAR(i.hi, k.hi, 6e-5);
    EXPECT_DOUBLE_EQ(i.value, static_cast<double>(k.hits) / static_cast<double>(k.n));
  }
}

TEST(Proportion, four_hundred_cases_without_an_alarm_bound_one_per_cent) {
  const Interval i = clopper_pearson(0, 400);
  EXPECT_NEAR(i.hi, 1 - std::pow(0.025, 1.0 / 400), 1e-12);
  EXPECT_LT(i.hi, 0.01);
  EXPECT_DOUBLE_EQ(clopper_pearson(400, 400).hi, 1);
}

TEST(Proportion, no_cases_say_nothing) {
  const Interval i = clopper_pearson(0, 0);
  EXPECT_TRUE(std::isnan(i.value));
  EXPECT_EQ(i.lo, 0);
  EXPECT_EQ(i.hi, 1);
}

TEST(Proportion, a_bootstrap_of_a_mean_is_as_wide_as_its_standard_error) {
  const std::size_t n = 400;
  const auto mean = [](std::span<const std::size_t> picks) {
    double sum = 0;
    for (const std::size_t p : picks) sum += p % 2 == 0 ? 1.0 : 0.0;
    return sum / static_cast<double>(picks.size());
  };
  const Interval i = bootstrap(n, mean, 2000, 3);
  EXPECT_DOUBLE_EQ(i.value, 0.5);
  EXPECT_NEAR(i.hi - i.lo, 2 * 1.96 * 0.5 / 20, 0.006);
}

TEST(Proportion, quantiles_lie_between_the_values) {
  EXPECT_DOUBLE_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_DOUBLE_EQ(quantile({0, 10}, 0.1), 1);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

std::vector<Forecast> forecasts(double probability, int came, int n) {
  std::vector<Forecast> all;
  for (int i = 0; i < n; ++i) all.push_back({probability, i < came});
  return all;
}

TEST(Calibration, one_probability_errs_by_its_distance_from_the_share_that_came) {
  EXPECT_NEAR(calibration_error(forecasts(0.8, 60, 100)), 0.2, 1e-12);
  EXPECT_NEAR(calibration_error(forecasts(0.6, 60, 100)), 0.0, 1e-12);
}

TEST(Calibration, errors_of_different_sign_do_not_cancel_between_bins) {
  auto all = forecasts(0.2, 20, 50);         // .4 came
  const auto high = forecasts(0.8, 30, 50);  // .6 came
  all.insert(all.end(), high.begin(), high.end());
  EXPECT_NEAR(calibration_error(all, 2), 0.2, 1e-12);
  EXPECT_NEAR(calibration_error(all, 1), 0.0, 1e-12);
}

TEST(Calibration, the_floor_is_what_right_probabilities_would_err_by) {
  // Two tosses of a coin: |k/2 - 1/2| is 1/2 half of the time.
  EXPECT_NEAR(calibration_floor(forecasts(0.5, 0, 2), 1, 20000, 1), 0.25, 0.01);
  // Many: the mean modulus of a normal deviate, √(2/π) √(p(1-p)/n).
  EXPECT_NEAR(calibration_floor(forecasts(0.3, 0, 1000), 1, 4000, 2),
              std::sqrt(2 / M_PI) * std::sqrt(0.21 / 1000), 4e-4);
  EXPECT_NEAR(calibration_floor(forecasts(1.0, 10, 10), 10, 10, 1), 0, 1e-12);
}

}  // namespace
}  // namespace umov::gap::benchmark
