// Something known that is not as constant as it should be.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "host/gap/engine/diagnosis.hpp"
#include "host/gap/engine/variation.hpp"
#include "tests/unit/gap/bell.hpp"

namespace umov::gap {
namespace {

Variation variation_of(const Bell& model) {
  const Whitening whitening(model.noise(model.observations().value));
  const Refit fit = refit(model, base_explanation(model), whitening);
  return strongest_variation(model, fit, whitening, 12, 1);
}

TEST(Variation, NoiseAloneSeldomLooksLikeOne) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed)
    alarms += variation_of(Bell(seed)).p_global < 0.05 ? 1 : 0;
  // Of forty at 5 %: more than seven would be one in a thousand.
  EXPECT_LE(alarms, 7);
}

TEST(Variation, ZeroThatDependsOnASettingIsNamedWithIt) {
  Bell model(3);
  model.measure([](double, double setting, double) { return setting > 0 ? 0.002 : -0.002; });
  const Variation v = variation_of(model);
  EXPECT_EQ(v.what, "zero");
  EXPECT_EQ(v.with, "setting");
  EXPECT_EQ(v.kind, Variation::Kind::level);
  EXPECT_LT(v.p_global, 1e-4);
}

TEST(Variation, ZeroThatStepsInMidScanIsDated) {
  Bell model(4);
  model.measure([](double time, double, double) { return time < 0.62 ? 0.0 : 0.004; });
  const Variation v = variation_of(model);
  EXPECT_EQ(v.what, "zero");
  EXPECT_EQ(v.kind, Variation::Kind::step);
  EXPECT_NEAR(v.at, 0.62, 0.1);
}

TEST(Variation, GradationThatRepeatsAlongAnAxisIsSeen) {
  Bell model(5);
  model.measure(
      [](double, double, double place) { return 0.002 * std::sin(2 * M_PI * place / 0.3); });
  const Variation v = variation_of(model);
  EXPECT_EQ(v.what, "zero");
  EXPECT_EQ(v.with, "place");
  EXPECT_EQ(v.kind, Variation::Kind::swing);
  EXPECT_NEAR(v.at, 0.3, 0.02);
}

TEST(Variation, CauseThatStoodInForItIsNotNamed) {
  Bell model(6);
  model.measure([](double time, double, double) { return time < 0.5 ? 0.0 : 0.006; });
  const Diagnosis d = diagnose(model);
  // On the whole the zero is off by half of the step: without the step's sign it would be named.
  EXPECT_TRUE(varies(d));
  EXPECT_LT(d.unexplained_p, 0.01);
  EXPECT_EQ(d.variation.what, "zero");
  for (const Cause& c : d.causes) EXPECT_NE(c.effect, "zero") << c.probability;
  EXPECT_EQ(d.verdict, Verdict::unexplained);
}

TEST(Variation, SourceThatWandersIsNotTakenForNoise) {
  Bell steady(7), wandering(7);
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  double state = 0;
  wandering.modulate([&](Eigen::Index) {
    state = 0.99 * state + 0.003 * std::sqrt(1 - 0.99 * 0.99) * normal(random);
    return 1 + state;
  });
  EXPECT_FALSE(varies(diagnose(steady)));
  const Diagnosis d = diagnose(wandering);
  EXPECT_TRUE(varies(d));
  EXPECT_EQ(d.variation.what, "signal");
}

TEST(Diagnosis, GoesOnWhereTheWholeBaseIsHeldAtItsBounds) {
  Bell model(9);
  // Far more than height and width can follow.
  model.modulate([](Eigen::Index i) {
    return 8.0 + 20.0 * std::pow(static_cast<double>(i % 61 - 30) / 30.0, 2);
  });
  const Diagnosis d = diagnose(model);
  EXPECT_EQ(d.base[0].interval.value, 2.0);
  EXPECT_EQ(d.base[1].interval.value, 2.0);
  EXPECT_NE(d.verdict, Verdict::none_needed);
  EXPECT_NE(d.verdict, Verdict::explained);
}

}  // namespace
}  // namespace umov::gap
