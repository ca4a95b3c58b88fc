// Something known that is not as constant as it should be.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "host/gap/engine/diagnosis.hpp"
#include "host/gap/engine/variation.hpp"

namespace umov::gap {
namespace {

/// A bell scanned twenty times under two settings in turn: its height and width are fitted, its
/// place may be off, a constant may be added.
class Bell final : public ForwardModel {
 public:
  explicit Bell(std::uint64_t seed) {
    height_and_width_ = {{"height", "1", "", 1.0, 0.5, 2.0}, {"width", "1", "", 1.0, 0.5, 2.0}};
    Effect zero{
        "zero", "geometry", "the bell is elsewhere", "-", {{"zero", "1", "", 0, -1, 1, 0.01}}};
    Effect offset{"offset", "detector", "a constant", "-", {{"offset", "1", "", 0, -1, 1, 0.01}}};
    zero.probes = {{{0.002}}};
    offset.probes = {{{0.002}}};
    effects_ = {zero, offset};
    Circumstance time{{"time", "1", {}}}, setting{{"setting", "1", {}}},
        place{{"place", "1", {}}, true, "geometry"};
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    constexpr int rows = 20, points = 61;
    seen_.value.resize(rows * points);
    for (int i = 0; i < rows * points; ++i) {
      place.axis.value.push_back(-3 + 0.1 * (i % points));
      time.axis.value.push_back(static_cast<double>(i) / (rows * points));
      setting.axis.value.push_back((i / points) % 2);
      seen_.row.push_back(i / points);
      seen_.channel.push_back(0);
      noise_.push_back(sigma * normal(random));
    }
    seen_.channels = {"all"};
    seen_.axes = {place.axis, time.axis};
    seen_.circumstances = {time, setting, place};
    measure([](double, double, double) { return 0.0; });
  }

  /// The bell's place is off by `zero` of time, setting and place.
  template <class F>
  void measure(const F& zero) {
    for (Eigen::Index i = 0; i < seen_.value.size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const auto& c = seen_.circumstances;
      const double off = zero(c[0].axis.value[k], c[1].axis.value[k], c[2].axis.value[k]);
      seen_.value[i] = bell(place(i) - off, 1, 1) + noise_[k];
    }
  }
  /// Multiplies what was measured.
  template <class F>
  void modulate(const F& factor) {
    for (Eigen::Index i = 0; i < seen_.value.size(); ++i)
      seen_.value[i] += (factor(i) - 1) * bell(place(i), 1, 1);
  }

  const Observations& observations() const override { return seen_; }
  const std::vector<Parameter>& base() const override { return height_and_width_; }
  const std::vector<Effect>& effects() const override { return effects_; }
  void predict(const Explanation& e, Eigen::VectorXd& mean, Eigen::MatrixXd* jacobian,
               const std::vector<bool>&) const override {
    double alpha[2] = {0, 0};
    for (std::size_t k = 0; k < e.effects.size(); ++k) alpha[e.effects[k]] = e.alpha[k][0];
    mean.resize(seen_.value.size());
    if (jacobian != nullptr)
      jacobian->resize(mean.size(), 2 + static_cast<Eigen::Index>(e.effects.size()));
    for (Eigen::Index i = 0; i < mean.size(); ++i) {
      const double x = place(i) - alpha[0], w = e.base[1];
      const double shape = bell(x, 1, w);
      mean[i] = e.base[0] * shape + alpha[1];
      if (jacobian == nullptr) continue;
      (*jacobian)(i, 0) = shape;
      (*jacobian)(i, 1) = e.base[0] * shape * x * x / (w * w * w);
      for (std::size_t k = 0; k < e.effects.size(); ++k)
        (*jacobian)(i, 2 + static_cast<Eigen::Index>(k)) =
            e.effects[k] == 0 ? e.base[0] * shape * x / (w * w) : 1.0;
    }
  }
  NoiseShape noise(const Eigen::VectorXd& mean) const override {
    NoiseShape shape{Eigen::VectorXd::Constant(mean.size(), sigma), mean, {}};
    for (Eigen::Index i = 0; i < mean.size(); ++i) shape.order.push_back(i);
    return shape;
  }

  static constexpr double sigma = 0.003;

 private:
  static double bell(double x, double height, double width) {
    return height * std::exp(-0.5 * x * x / (width * width));
  }
  double place(Eigen::Index i) const {
    return seen_.circumstances[2].axis.value[static_cast<std::size_t>(i)];
  }

  Observations seen_;
  std::vector<Parameter> height_and_width_;
  std::vector<Effect> effects_;
  std::vector<double> noise_;
};

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

}  // namespace
}  // namespace umov::gap
