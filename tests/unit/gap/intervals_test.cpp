// Intervals where a fit's curvature alone would mislead.
#include "host/gap/engine/intervals.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace umov::gap {
namespace {

/// A level, and a bell on it of which an effect sets the size: `turn` by its parameter's square,
/// `shift` in proportion, `shadow` by the quotient of height and width.
class Quotient final : public ForwardModel {
 public:
  enum Kind : std::size_t { turn, shift, shadow };

  explicit Quotient(double size) {
    base_ = {{"level", "1", "", 1.0, 0.0, 5.0}};
    effects_ = {{"turn", "polarisation", "", "-", {{"angle", "1", "", 0, -5, 5, 1}}},
                {"shift", "geometry", "", "-", {{"size", "1", "", 0, -5, 5, 1}}},
                {"shadow",
                 "geometry",
                 "",
                 "-",
                 {{"height", "1", "", 0, 0, 20, 5}, {"width", "1", "", 1.25, 0.5, 2.0, 0.43}}}};
    effects_[shadow].parameters[1].shape = true;
    std::mt19937_64 random(11);
    std::normal_distribution<double> normal;
    seen_.value.resize(points);
    for (Eigen::Index i = 0; i < points; ++i)
      seen_.value[i] = 1 + size * bell(i) + sigma * normal(random);
  }

  const Observations& observations() const override { return seen_; }
  const std::vector<Parameter>& base() const override { return base_; }
  const std::vector<Effect>& effects() const override { return effects_; }
  void predict(const Explanation& e, Eigen::VectorXd& mean, Eigen::MatrixXd* jacobian,
               const std::vector<bool>&) const override {
    mean = Eigen::VectorXd::Constant(points, e.base[0]);
    const auto extra = e.alpha.empty() ? 0 : static_cast<Eigen::Index>(e.alpha[0].size());
    if (jacobian != nullptr) *jacobian = Eigen::MatrixXd::Ones(points, 1 + extra);
    if (extra == 0) return;
    const std::vector<double>& a = e.alpha[0];
    double size = a[0], by_first = 1, by_second = 0;
    if (e.effects[0] == turn) {
      size = a[0] * a[0];
      by_first = 2 * a[0];
    } else if (e.effects[0] == shadow) {
      size = a[0] / a[1];
      by_first = 1 / a[1];
      by_second = -size / a[1];
    }
    for (Eigen::Index i = 0; i < points; ++i) {
      mean[i] += size * bell(i);
      if (jacobian == nullptr) continue;
      (*jacobian)(i, 1) = by_first * bell(i);
      if (extra > 1) (*jacobian)(i, 2) = by_second * bell(i);
    }
  }
  NoiseShape noise(const Eigen::VectorXd& mean) const override {
    NoiseShape shape{Eigen::VectorXd::Constant(mean.size(), sigma), mean, {}};
    for (Eigen::Index i = 0; i < mean.size(); ++i) shape.order.push_back(i);
    return shape;
  }

 private:
  static constexpr Eigen::Index points = 200;
  static constexpr double sigma = 0.05;
  static double bell(Eigen::Index i) {
    const double x = 0.05 * static_cast<double>(i - 100);
    return std::exp(-0.5 * x * x);
  }

  Observations seen_;
  std::vector<Parameter> base_;
  std::vector<Effect> effects_;
};

std::vector<NamedValue> fitted(const Quotient& model, std::size_t effect,
                               const std::vector<double>& start) {
  Eigen::VectorXd mean;
  model.predict(base_explanation(model), mean, nullptr, {});
  const Whitening whitening(model.noise(mean));
  const Refit fit = refit(model, with_effect(base_explanation(model), effect, start), whitening);
  return effect_parameters(model, fit, 0, whitening);
}

TEST(Intervals, OfASquareHoldBothSigns) {
  const Interval angle = fitted(Quotient(0.64), Quotient::turn, {-0.5})[0].interval;
  EXPECT_NEAR(angle.value, -0.8, 0.05);
  EXPECT_LT(angle.lo, -0.8);
  EXPECT_GT(angle.hi, 0.8);
  EXPECT_NEAR(angle.hi, -angle.lo, 0.02);
}

TEST(Intervals, OfASizeWithASignAreThoseOfTheCurvature) {
  const Interval size = fitted(Quotient(-0.64), Quotient::shift, {-0.5})[0].interval;
  EXPECT_LT(size.lo, -0.64);
  EXPECT_GT(size.hi, -0.64);
  EXPECT_LT(size.hi - size.lo, 0.1);
}

TEST(Intervals, BesideAShapeReachAsFarAsTheShape) {
  // Only height over width shows, 0.9: any width of its range will do.
  const Interval height = fitted(Quotient(0.9), Quotient::shadow, {1.0, 1.1})[0].interval;
  EXPECT_LT(height.lo, 0.5);
  EXPECT_GT(height.lo, 0.35);
  EXPECT_GT(height.hi, 1.7);
  EXPECT_LT(height.hi, 2.1);
}

TEST(Intervals, OfAHeldParameterThereIsNoMove) {
  const Quotient model(0.9);
  Eigen::VectorXd mean;
  model.predict(base_explanation(model), mean, nullptr, {});
  const Whitening whitening(model.noise(mean));
  const Refit fit = refit(model, with_effect(base_explanation(model), Quotient::shift, {0.2}),
                          whitening, 40, nullptr, {1});
  EXPECT_EQ(fit.explanation.alpha[0][0], 0.2);
  EXPECT_GT(fit.explanation.base[0], 1.05);  // the level takes up what it can
  EXPECT_EQ(std::count(fit.free.begin(), fit.free.end(), 1), 0);
}

}  // namespace
}  // namespace umov::gap
