// The signal chain of a scan as a forward model.
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "host/formats/scan_csv.hpp"
#include "host/gap/engine/refit.hpp"
#include "host/gap/scan/effect_list.hpp"
#include "host/gap/scan/scan_model.hpp"

namespace umov::gap::scan {
namespace {

const ScanModel& model() {
  static const ScanModel shared({formats::read_scan_csv(std::filesystem::path(UMOV_TEST_DATA) /
                                                        "foreign_scans" / "scan_07_part.csv")});
  return shared;
}

TEST(ScanModel, KnowsEveryCanonicalEffectOnce) {
  for (const Effect& effect : model().effects()) {
    EXPECT_FALSE(effect.name.empty());
    EXPECT_FALSE(effect.physics.empty()) << effect.name;
    EXPECT_FALSE(effect.source.empty()) << effect.name;
    EXPECT_FALSE(effect.parameters.empty()) << effect.name;
    for (const auto& group : effect.probes)
      for (const Probe& probe : group)
        EXPECT_EQ(probe.size(), effect.parameters.size()) << effect.name << effect.family;
  }
}

TEST(ScanModel, EveryEffectDoesNothingWhereItIsAbsent) {
  const Explanation base = base_explanation(model());
  Eigen::VectorXd plain, with;
  model().predict(base, plain, nullptr);
  for (std::size_t e = 0; e < model().effects().size(); ++e) {
    const Effect& effect = model().effects()[e];
    if (effect.probes.empty()) continue;
    std::vector<double> alpha = effect.probes[0][0];
    for (std::size_t i = 0; i < alpha.size(); ++i)
      if (!effect.parameters[i].shape && !effect.parameters[i].choice)
        alpha[i] = effect.parameters[i].absent;
    model().predict(with_effect(base, e, alpha), with, nullptr);
    // The longest tails that count as none change the lobe by their square.
    const double allowed = effect.family == "ggx" ? 1e-3 : 1e-9;
    EXPECT_LT((with - plain).cwiseAbs().maxCoeff(), allowed * plain.cwiseAbs().maxCoeff())
        << effect.name << ' ' << effect.family;
  }
}

TEST(ScanModel, BehindALongPassOnlyLongerWavelengthsAreSeen) {
  std::vector<Record> seen;
  for (const Record& r : model().records().records)
    if (r.wavelength == 0 && r.shutter_open && !r.saturated) seen.push_back(r);
  ASSERT_FALSE(seen.empty());
  for (Record& r : seen) r.long_pass = true;
  const ScanModel behind = model().with_records(seen);
  const auto& nm = behind.records().wavelengths_nm;
  ASSERT_GE(nm.size(), 2U);
  const Explanation base = base_explanation(behind);
  const auto n = static_cast<Eigen::Index>(behind.used());
  const auto signal = [&](EffectId id, std::vector<double> alpha) {
    Eigen::VectorXd mean;
    behind.predict(with_effect(base, number(id), alpha), mean, nullptr);
    return Eigen::VectorXd(mean.head(n));
  };
  const Eigen::VectorXd leak = signal(EffectId::laser_crosstalk, {1e-3, nm[0], nm[1]});
  EXPECT_GT(leak.minCoeff(), 0);
  EXPECT_LT((signal(EffectId::laser_crosstalk, {2e-3, nm[0], nm[1]}) - 2 * leak).norm(),
            1e-12 * leak.norm());
  EXPECT_GT(signal(EffectId::fluorescence, {1e-3}).minCoeff(), 0);
  // What is of the laser's own wavelength, or leaks into another laser, is not seen.
  EXPECT_EQ(signal(EffectId::laser_crosstalk, {1e-3, nm[1], nm[0]}).norm(), 0);
  EXPECT_EQ(signal(EffectId::stray_light, {1e-3}).norm(), 0);
  EXPECT_EQ(signal(EffectId::stray_forward, {1e-3, 20.0}).norm(), 0);
}

TEST(ScanModel, DerivativesOfEveryEffectAreThoseOfThePrediction) {
  const Explanation base = base_explanation(model());
  Eigen::VectorXd mean, up, down;
  Eigen::MatrixXd jacobian;
  for (std::size_t e = 0; e < model().effects().size(); ++e) {
    const Effect& effect = model().effects()[e];
    if (effect.probes.empty()) continue;
    const Explanation at = with_effect(base, e, effect.probes.back()[0]);
    model().predict(at, mean, &jacobian);
    for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
      if (effect.parameters[i].choice) continue;
      const double value = at.alpha[0][i];
      const double step = 1e-4 * std::max(std::abs(value), 1e-3);
      Explanation shifted = at;
      shifted.alpha[0][i] = value + step;
      model().predict(shifted, up, nullptr);
      shifted.alpha[0][i] = value - step;
      model().predict(shifted, down, nullptr);
      const Eigen::VectorXd expected = (up - down) / (2 * step);
      const auto column = static_cast<Eigen::Index>(model().base().size() + i);
      EXPECT_LT((jacobian.col(column) - expected).norm(),
                1e-4 * expected.norm() + 1e-9 * mean.norm() / step)
          << effect.name << ' ' << effect.family << ' ' << effect.parameters[i].name;
    }
  }
}

}  // namespace
}  // namespace umov::gap::scan
