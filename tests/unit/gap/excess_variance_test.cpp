// Scatter as a cause: told from slow noise, from misfits, and from fresh noise where places repeat.
#include "host/gap/engine/excess_variance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "host/gap/engine/diagnosis.hpp"
#include "host/gap/engine/search.hpp"

namespace umov::gap {
namespace {

constexpr std::size_t rows = 30, in_a_row = 40;
constexpr double known_relative = 2e-3, known_floor = 5e-4;

/// Signals of a smooth lobe in rows, whose height is the base and whose place may be off.
class Lobe : public ForwardModel {
 public:
  /// `twice`: the second half of the rows looks where the first did.
  explicit Lobe(bool twice = false, bool known = true) : known_(known) {
    Effect shift{"shift", "geometry", "", "", {{"by", "1", "", 0, -1, 1, 0.05}}};
    shift.probes = {{{0.001}}};
    Effect grains{"grains", "sample", "", "", {{"contrast", "1", "", 0, 0, 0.5, 3e-3}}};
    grains.scatter = true;
    effects_ = {shift, grains};
    base_ = {{"height", "1", "", 1.0}};
    observations_.axes = {{"place", "1", {}}};
    observations_.channels = {""};
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t k = 0; k < in_a_row; ++k) {
        at_.push_back(-1 + 2 * static_cast<double>(k) / (in_a_row - 1));
        observations_.row.push_back(static_cast<int>(r));
        observations_.axes[0].value.push_back(at_.back());
        observations_.channel.push_back(0);
      }
    }
    for (std::size_t i = 0; twice && i < at_.size() / 2; ++i)
      same_place_.push_back(
          {static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i + at_.size() / 2)});
    observations_.value = signals(1.0, 0.0);
  }

  const Observations& observations() const override { return observations_; }
  const std::vector<Parameter>& base() const override { return base_; }
  const std::vector<Effect>& effects() const override { return effects_; }
  bool noise_is_known() const override { return known_; }

  void predict(const Explanation& e, Eigen::VectorXd& mean, Eigen::MatrixXd* jacobian,
               const std::vector<bool>&) const override {
    double by = 0;
    for (std::size_t k = 0; k < e.effects.size(); ++k)
      if (e.effects[k] == 0) by = e.alpha[k][0];
    mean = signals(e.base[0], by);
    if (jacobian == nullptr) return;
    jacobian->setZero(mean.size(), static_cast<Eigen::Index>(1 + e.effects.size()));
    jacobian->col(0) = mean / e.base[0];
    constexpr double step = 1e-5;
    for (std::size_t k = 0; k < e.effects.size(); ++k)
      if (e.effects[k] == 0)
        jacobian->col(static_cast<Eigen::Index>(1 + k)) =
            (signals(e.base[0], by + step) - signals(e.base[0], by - step)) / (2 * step);
  }

  NoiseShape noise(const Eigen::VectorXd& mean) const override {
    NoiseShape shape;
    shape.sigma =
        (known_relative * known_relative * mean.array().square() + known_floor * known_floor)
            .sqrt();
    shape.relative = mean;
    for (Eigen::Index i = 0; i < mean.size(); ++i) shape.order.push_back(i);
    shape.same_place = same_place_;
    shape.doubt = 0.05 * known_relative * known_relative;
    return shape;
  }

  Eigen::VectorXd signals(double height, double by) const {
    Eigen::VectorXd s(static_cast<Eigen::Index>(at_.size()));
    for (std::size_t i = 0; i < at_.size(); ++i) {
      const double x = at_[i] - by;
      s[static_cast<Eigen::Index>(i)] = height * (0.2 + std::exp(-4 * x * x));
    }
    return s;
  }

  void set(const Eigen::VectorXd& value) { observations_.value = value; }

 private:
  bool known_;
  std::vector<double> at_;
  Observations observations_;
  std::vector<Parameter> base_;
  std::vector<Effect> effects_;
  std::vector<std::vector<Eigen::Index>> same_place_;
};

/// The known noise, and errors in proportion to the signal of the given kinds.
Eigen::VectorXd errors(const Lobe& lobe, const RelativeNoise& kinds, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const Eigen::VectorXd mean = lobe.signals(1, 0);
  const NoiseShape shape = lobe.noise(mean);
  Eigen::VectorXd pattern(mean.size());
  for (double& p : pattern) p = kinds.pattern * normal(random);
  for (const auto& group : shape.same_place) pattern[group[1]] = pattern[group[0]];
  Eigen::VectorXd e(mean.size());
  double slow = kinds.slow * normal(random);
  for (Eigen::Index i = 0; i < e.size(); ++i) {
    e[i] = shape.sigma[i] * normal(random) +
           mean[i] * (kinds.white * normal(random) + pattern[i] + slow);
    slow = kinds.memory * slow +
           kinds.slow * std::sqrt(1 - kinds.memory * kinds.memory) * normal(random);
  }
  return e;
}

ExcessVariance weighed(const Lobe& lobe, const Eigen::VectorXd& residual) {
  const NoiseShape shape = lobe.noise(lobe.signals(1, 0));
  const Leftover leftover{residual, Eigen::VectorXd::Ones(residual.size()), 1.0};
  const RelativeNoise learned = learn_relative_noise(shape, residual, leftover.kept);
  return weigh_excess(lobe, lobe.effects()[1], shape, leftover, learned, std::log(0.03));
}

TEST(Whitening, OfAPatternThatComesBackIsThatOfItsCovariance) {
  NoiseShape shape;
  shape.sigma = Eigen::VectorXd::LinSpaced(7, 0.5, 1.1);
  shape.relative = Eigen::VectorXd::LinSpaced(7, 2.0, -1.0);
  shape.order = {0, 1, 2, 3, 4, 5, 6};
  shape.same_place = {{0, 3, 6}, {1, 5}};
  const RelativeNoise noise{0.3, 0, 0, 0.7};
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(7, 7);
  for (const auto& group : shape.same_place)
    for (const auto i : group)
      for (const auto j : group) covariance(i, j) = 0.49 * shape.relative[i] * shape.relative[j];
  for (Eigen::Index i = 0; i < 7; ++i)
    covariance(i, i) =
        shape.sigma[i] * shape.sigma[i] + (0.49 + 0.09) * shape.relative[i] * shape.relative[i];
  const Whitening whitening(shape, noise);
  const Eigen::MatrixXd root = covariance.llt().matrixL();
  const Eigen::MatrixXd white = whitening.apply(root);
  EXPECT_LT((white * white.transpose() - Eigen::MatrixXd::Identity(7, 7)).norm(), 1e-10);
  EXPECT_NEAR(whitening.ln_determinant(), root.diagonal().array().log().sum(), 1e-10);
}

TEST(ExcessVariance, IsNotSeenWhereTheNoiseIsAsItSays) {
  const Lobe lobe;
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    EXPECT_LT(weighed(lobe, errors(lobe, {}, seed)).joint_probability(), 0.5) << seed;
}

TEST(ExcessVariance, WithoutRepeatsIsGrainsOrFreshNoise) {
  const Lobe lobe;
  const ExcessVariance found = weighed(lobe, errors(lobe, {0, 0, 0, 2e-3}, 1));
  EXPECT_GT(found.joint_probability(), 0.99);
  EXPECT_TRUE(found.confirmed());
  EXPECT_TRUE(found.ambiguous(6));
  EXPECT_GT(found.probability, found.fresh_probability);
}

TEST(ExcessVariance, HoldsTheTrueContrastInNineteenOfTwentyIntervals) {
  const Lobe lobe;
  int held = 0;
  constexpr int all = 60;
  for (int seed = 1; seed <= all; ++seed) {
    const ExcessVariance found =
        weighed(lobe, errors(lobe, {0, 0, 0, 2e-3}, static_cast<std::uint64_t>(seed)));
    if (found.lo <= 2e-3 && 2e-3 <= found.hi) ++held;
  }
  // Binomial of 60 at .95: fewer than 51 once in three thousand.
  EXPECT_GE(held, 51);
  EXPECT_LE(held, all);
}

TEST(ExcessVariance, ThatComesBackIsGrains) {
  const Lobe twice(true);
  const ExcessVariance found = weighed(twice, errors(twice, {0, 0, 0, 2e-3}, 2));
  EXPECT_GT(found.probability, 0.99);
  EXPECT_FALSE(found.ambiguous(6));
  EXPECT_NEAR(found.size, 2e-3, 3e-4);
}

TEST(ExcessVariance, ThatDoesNotComeBackIsNone) {
  const Lobe twice(true);
  const ExcessVariance found = weighed(twice, errors(twice, {2e-3, 0, 0, 0}, 3));
  EXPECT_LT(found.probability, 0.05);
  EXPECT_GT(found.fresh_probability, 0.95);
}

TEST(ExcessVariance, OfBothKindsIsPartedByRepeats) {
  const Lobe twice(true);
  const ExcessVariance found = weighed(twice, errors(twice, {3e-3, 0, 0, 2.5e-3}, 4));
  EXPECT_GT(found.probability, 0.9);
  EXPECT_GT(found.fresh_probability, 0.9);
  EXPECT_LT(found.lo, 2.5e-3);
  EXPECT_GT(found.hi, 2.5e-3);
  EXPECT_NEAR(found.with.white, 3e-3, 5e-4);
}

TEST(ExcessVariance, SlowNoiseIsNone) {
  const Lobe lobe;
  const ExcessVariance found = weighed(lobe, errors(lobe, {0, 3e-3, 0.95, 0}, 5));
  EXPECT_FALSE(found.confirmed() && found.joint_probability() >= 0.5);
}

TEST(ExcessVariance, AMisfitAlongTheRowsIsNone) {
  const Lobe lobe;
  Eigen::VectorXd residual = errors(lobe, {}, 6);
  const Eigen::VectorXd mean = lobe.signals(1, 0);
  for (Eigen::Index i = 0; i < residual.size(); ++i)
    residual[i] += 4e-3 * mean[i] * std::sin(0.5 * static_cast<double>(i % in_a_row));
  const ExcessVariance found = weighed(lobe, residual);
  EXPECT_FALSE(found.confirmed());
}

TEST(ExcessVariance, OfNoiseKnownUpToAFactorNeedsRepeats) {
  const Lobe once(false, false), twice(true, false);
  EXPECT_LT(weighed(once, errors(once, {0, 0, 0, 4e-3}, 7)).probability, 0.5);
  EXPECT_GT(weighed(twice, errors(twice, {0, 0, 0, 4e-3}, 7)).probability, 0.9);
}

DiagnoseOptions short_search() {
  DiagnoseOptions options;
  options.draws = 200;
  options.search.folds = 6;
  options.search.threads = 1;
  return options;
}

TEST(DiagnosisOfScatter, NamesItsShareBesideAShift) {
  Lobe lobe(true);
  lobe.set(lobe.signals(1, 0.004) + errors(lobe, {0, 0, 0, 3e-3}, 8));
  const Diagnosis d = diagnose(lobe, short_search());
  EXPECT_EQ(d.verdict, Verdict::explained);
  ASSERT_EQ(d.causes.size(), 2u);
  double whole = 0;
  for (const Cause& c : d.causes) {
    EXPECT_GT(c.share, 0.02);
    whole += c.share;
    const double truth = c.effect == "grains" ? 3e-3 : 0.004;
    EXPECT_LT(c.parameters[0].interval.lo, truth) << c.effect;
    EXPECT_GT(c.parameters[0].interval.hi, truth) << c.effect;
  }
  EXPECT_NEAR(whole, 1, 1e-3);
  EXPECT_GT(d.before.g2, 1);
  EXPECT_LT(std::abs(d.after.g2), 0.2);
}

TEST(DiagnosisOfScatter, LeavesItUnexplainedWhereItIsNotAllowed) {
  Lobe lobe;
  lobe.set(lobe.signals(1, 0) + errors(lobe, {0, 0, 0, 3e-3}, 9));
  DiagnoseOptions options = short_search();
  const Diagnosis named = diagnose(lobe, options);
  ASSERT_EQ(named.causes.size(), 1u);
  EXPECT_EQ(named.causes[0].effect, "grains");
  ASSERT_EQ(named.ambiguity_sets.size(), 1u);
  EXPECT_EQ(named.ambiguity_sets[0], (std::vector<std::string>{"grains", unseen_noise}));
  options.search.without = {1};
  const Diagnosis without = diagnose(lobe, options);
  EXPECT_EQ(without.verdict, Verdict::unexplained);
  EXPECT_TRUE(without.causes.empty());
}

TEST(DiagnosisOfScatter, NeedsNoneWhereThereIsNoise) {
  Lobe lobe;
  lobe.set(lobe.signals(1, 0) + errors(lobe, {}, 10));
  EXPECT_EQ(diagnose(lobe, short_search()).verdict, Verdict::none_needed);
}

}  // namespace
}  // namespace umov::gap
