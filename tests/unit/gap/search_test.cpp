// Effects that the linear view misjudges must be found all the same.
#include "host/gap/engine/search.hpp"

#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "host/gap/engine/beam.hpp"

namespace umov::gap {
namespace {

/// A slope that is fitted, a bump of free height and place, and a polynomial that can be bent to
/// follow it roughly.
class Bumpy final : public ForwardModel {
 public:
  Bumpy(double height, double place) {
    base_ = {{"level", "1", "", 1.0, 0.0, 5.0}};
    Effect bump{"bump",
                "sample",
                "a bump",
                "-",
                {{"height", "1", "", 0, 0, 10, 0.3}, {"place", "1", "", 0, -3, 3, 1.7}}};
    bump.parameters[1].shape = true;
    for (const double at : {-2.0, 0.0, 2.0}) bump.probes.push_back({{0.01, at}});
    Effect bent{"bent", "sample", "a polynomial", "-", {}};
    bent.structural = true;
    bent.family = "polynomial";
    for (int k = 0; k < terms; ++k) {
      bent.parameters.push_back({"term", "1", "", 0, -3, 3, 0.3});
      Probe probe(terms, 0.0);
      probe[static_cast<std::size_t>(k)] = 0.01;
      if (k == 0) bent.probes.emplace_back();
      bent.probes.front().push_back(probe);
    }
    effects_ = {bump, bent};
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    seen_.value.resize(points);
    seen_.channels = {"all"};
    seen_.axes = {{"x", "1", {}}};
    for (Eigen::Index i = 0; i < points; ++i) {
      seen_.value[i] = 1 + height * shape(x(i) - place) + sigma * normal(random);
      seen_.row.push_back(static_cast<int>(i / 20));
      seen_.channel.push_back(0);
      seen_.axes[0].value.push_back(x(i));
    }
  }

  const Observations& observations() const override { return seen_; }
  const std::vector<Parameter>& base() const override { return base_; }
  const std::vector<Effect>& effects() const override { return effects_; }
  void predict(const Explanation& e, Eigen::VectorXd& mean, Eigen::MatrixXd* jacobian,
               const std::vector<bool>&) const override {
    mean = Eigen::VectorXd::Constant(points, e.base[0]);
    Eigen::Index columns = 1;
    for (const auto& alpha : e.alpha) columns += static_cast<Eigen::Index>(alpha.size());
    if (jacobian != nullptr) *jacobian = Eigen::MatrixXd::Ones(points, columns);
    Eigen::Index first = 1;
    for (std::size_t k = 0; k < e.effects.size(); ++k) {
      const std::vector<double>& a = e.alpha[k];
      for (Eigen::Index i = 0; i < points; ++i) {
        if (e.effects[k] == 0) {
          const double off = x(i) - a[1], bell = shape(off);
          mean[i] += a[0] * bell;
          if (jacobian == nullptr) continue;
          (*jacobian)(i, first) = bell;
          (*jacobian)(i, first + 1) = a[0] * bell * off / (width * width);
          continue;
        }
        for (int t = 0; t < terms; ++t) {
          const double value = std::cos((t + 1) * std::acos(x(i) / 3.001));
          mean[i] += a[static_cast<std::size_t>(t)] * value;
          if (jacobian != nullptr) (*jacobian)(i, first + t) = value;
        }
      }
      first += static_cast<Eigen::Index>(a.size());
    }
  }
  NoiseShape noise(const Eigen::VectorXd& mean) const override {
    NoiseShape shape{Eigen::VectorXd::Constant(mean.size(), sigma), mean, {}};
    for (Eigen::Index i = 0; i < mean.size(); ++i) shape.order.push_back(i);
    return shape;
  }

 private:
  static constexpr Eigen::Index points = 601;
  static constexpr int terms = 9;
  static constexpr double sigma = 0.02, width = 0.45;
  static double x(Eigen::Index i) { return -3 + 0.01 * static_cast<double>(i); }
  static double shape(double off) { return std::exp(-0.5 * off * off / (width * width)); }

  Observations seen_;
  std::vector<Parameter> base_;
  std::vector<Effect> effects_;
};

TEST(Search, FindsAShapeFarFromItsProbesBehindAStructureThatFollowsIt) {
  for (const double place : {-1.3, 0.7, 1.25}) {
    const Bumpy model(0.08, place);
    SearchOptions options;
    options.threads = 1;
    const SearchResult found = search(model, options);
    const Explanation& best = found.hypotheses.front().refit.explanation;
    ASSERT_EQ(best.effects, std::vector<std::size_t>{0}) << place;
    EXPECT_NEAR(best.alpha[0][0], 0.08, 0.02) << place;
    EXPECT_NEAR(best.alpha[0][1], place, 0.1) << place;
  }
}

/// Waves of several lengths, all of them there and large: a crowd. Any number of points will do.
class Crowd final : public ForwardModel {
 public:
  explicit Crowd(Eigen::Index step = 1) : step_(step) {
    base_ = {{"level", "1", "", 1.0, 0.0, 5.0}};
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      Effect wave{"wave " + std::to_string(k),
                  "sample",
                  "a wave",
                  "-",
                  {{"size", "1", "", 0, -10, 10, 0.3}}};
      wave.probes = {{{0.01}}};
      effects_.push_back(wave);
    }
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    std::vector<double> value;
    for (Eigen::Index i = 0; i < points; ++i) {
      double v = 1 + sigma * normal(random);
      for (std::size_t k = 0; k < sizes.size(); ++k) v += sizes[k] * wave(k, i);
      if (i % step_ != 0) continue;
      value.push_back(v);
      place_.push_back(i);
      seen_.row.push_back(static_cast<int>(i / 100));
      seen_.channel.push_back(0);
    }
    seen_.value =
        Eigen::Map<Eigen::VectorXd>(value.data(), static_cast<Eigen::Index>(value.size()));
    seen_.channels = {"all"};
  }

  const Observations& observations() const override { return seen_; }
  const std::vector<Parameter>& base() const override { return base_; }
  const std::vector<Effect>& effects() const override { return effects_; }
  std::unique_ptr<ForwardModel> thinned(std::size_t most) const override {
    ++asked_;
    const auto step = (place_.size() + most - 1) / most;
    return step < 2 ? nullptr : std::make_unique<Crowd>(static_cast<Eigen::Index>(step));
  }
  void predict(const Explanation& e, Eigen::VectorXd& mean, Eigen::MatrixXd* jacobian,
               const std::vector<bool>&) const override {
    mean = Eigen::VectorXd::Constant(seen_.value.size(), e.base[0]);
    if (jacobian != nullptr)
      *jacobian =
          Eigen::MatrixXd::Ones(mean.size(), 1 + static_cast<Eigen::Index>(e.effects.size()));
    for (std::size_t k = 0; k < e.effects.size(); ++k)
      for (std::size_t i = 0; i < place_.size(); ++i) {
        const double value = wave(e.effects[k], place_[i]);
        const auto row = static_cast<Eigen::Index>(i);
        mean[row] += e.alpha[k][0] * value;
        if (jacobian != nullptr) (*jacobian)(row, 1 + static_cast<Eigen::Index>(k)) = value;
      }
  }
  NoiseShape noise(const Eigen::VectorXd& mean) const override {
    NoiseShape shape{Eigen::VectorXd::Constant(mean.size(), sigma), mean, {}};
    for (Eigen::Index i = 0; i < mean.size(); ++i) shape.order.push_back(i);
    return shape;
  }

  static constexpr Eigen::Index points = 9600;
  /// The last two are too small for a quarter of the points.
  static constexpr std::array<double, 7> sizes{0.3, 0.2, 0.12, 0.1, 0.08, 0.0012, 0.0};
  int times_thinned() const { return asked_; }

 private:
  static constexpr double sigma = 0.02;
  static double wave(std::size_t k, Eigen::Index i) {
    return std::cos(0.0007 * static_cast<double>(i) * (1.0 + 1.3 * static_cast<double>(k)));
  }

  Eigen::Index step_;
  mutable int asked_ = 0;
  std::vector<Eigen::Index> place_;
  Observations seen_;
  std::vector<Parameter> base_;
  std::vector<Effect> effects_;
};

TEST(Search, FindsItsWayThroughACrowdWithFewPointsAndEndsWithAll) {
  const Crowd model;
  SearchOptions options;
  options.threads = 1;
  const SearchResult found = search(model, options);
  EXPECT_GT(model.times_thinned(), 0);
  const Refit& best = found.hypotheses.front().refit;
  EXPECT_EQ(best.residual.size(), Crowd::points);
  // Of amplitude .0012 over 9,600 points of σ = .02: 4 σ, which a quarter of the points hides.
  EXPECT_EQ(best.explanation.effects, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5}));
  for (std::size_t k = 0; k < best.explanation.effects.size(); ++k)
    EXPECT_NEAR(best.explanation.alpha[k][0], Crowd::sizes[best.explanation.effects[k]], 1.5e-3);
  EXPECT_GT(found.null_99, 0);
}

TEST(Refit, WorthByTheCurvatureIsWhatLeavingAnEffectOutCosts) {
  const Crowd model(8);
  Explanation all = base_explanation(model);
  for (std::size_t e = 0; e < 5; ++e) all = with_effect(all, e, {0.01});
  Eigen::VectorXd mean;
  model.predict(all, mean, nullptr, {});
  const Whitening whitening(model.noise(mean));
  const Refit fit = refit(model, all, whitening);
  for (std::size_t k = 0; k < 5; ++k) {
    const Refit without = refit(model, without_effect(fit.explanation, k), whitening);
    const double rise = without.chi2 + without.penalty - fit.chi2 - fit.penalty;
    EXPECT_NEAR(worth_by_curvature(model, fit, k), rise, 1e-3 * rise);  // a linear model
  }
}

TEST(Search, NoiseNeedsNeither) {
  const Bumpy model(0, 0);
  const SearchResult found = search(model, {});
  EXPECT_TRUE(found.hypotheses.front().refit.explanation.effects.empty());
}

TEST(Proposals, GatherTheWaysToOneSetOfEffects) {
  const Bumpy model(0.08, 0.9);
  Explanation start = base_explanation(model);
  Eigen::VectorXd mean;
  model.predict(start, mean, nullptr, {});
  const Whitening whitening(model.noise(mean));
  const LinearView view(model, refit(model, start, whitening), whitening, {}, true, 1);
  const SearchOptions options;
  Beam beam(view, options, log_prior_odds(model), 0);
  const std::vector<ScoredSet> scored = beam.run();
  const std::vector<Proposal> found = proposals(view, scored, 3, 2);
  ASSERT_FALSE(found.empty());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_LE(found[i].starts.size(), 2U);
    for (std::size_t k = 1; k < found[i].starts.size(); ++k)
      EXPECT_LE(found[i].starts[k].score, found[i].starts[k - 1].score);
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(found[i].effects, found[j].effects);
  }
  // Three probes of the bump: two ways to it alone.
  const auto bump = std::find_if(found.begin(), found.end(), [](const Proposal& p) {
    return p.effects == std::vector<std::size_t>{0};
  });
  ASSERT_NE(bump, found.end());
  EXPECT_EQ(bump->starts.size(), 2U);
}

}  // namespace
}  // namespace umov::gap
