#include "host/gap/benchmark/ceiling.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include "host/gap/engine/refit.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::gap {
namespace {

/// Share of a signature's squared length that a refit of the base must leave.
constexpr double least_survival = 1e-6;

}  // namespace

NamingRates& NamingRates::operator+=(const NamingRates& other) {
  drawn += other.drawn;
  named += other.named;
  in_set += other.in_set;
  set_size += other.set_size;
  for (const auto& [pair, n] : other.taken_for) taken_for[pair] += n;
  return *this;
}

NamingCeiling::NamingCeiling(const ForwardModel& model, const Explanation& at,
                             const Whitening& whitening)
    : model_(model) {
  Eigen::VectorXd mean;
  Eigen::MatrixXd jacobian;
  model.predict(at, mean, &jacobian);
  const auto fitted = static_cast<Eigen::Index>(model.base().size());
  Eigen::MatrixXd basis(mean.size() + fitted, fitted);
  basis.topRows(mean.size()) = whitening.apply(jacobian);
  basis.bottomRows(fitted).setZero();
  for (Eigen::Index i = 0; i < fitted; ++i) {
    const double u = model.base()[static_cast<std::size_t>(i)].prior_u;
    if (std::isfinite(u)) basis(mean.size() + i, i) = 1 / u;
    const double length = basis.col(i).norm();
    if (length > 0) basis.col(i) /= length;
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor(basis);
  const Eigen::MatrixXd q =
      factor.householderQ() * Eigen::MatrixXd::Identity(basis.rows(), factor.rank());

  std::vector<Eigen::VectorXd> columns;
  std::vector<double> precision;
  const auto& effects = model.effects();
  for (std::size_t e = 0; e < effects.size(); ++e) {
    if (effects[e].structural || effects[e].scatter) continue;
    for (const auto& group : effects[e].probes) {
      Shape shape{e, {}, group.size() == 1};
      bool seen = true;
      for (const Probe& probe : group) {
        double units = 0;
        bool bounded = false;
        for (std::size_t i = 0; i < probe.size(); ++i) {
          const Parameter& p = effects[e].parameters[i];
          if (p.shape || p.choice) continue;
          units = std::max(units, std::abs(probe[i] - p.absent) / p.prior_u);
          bounded = bounded || (probe[i] != p.absent && (p.lo >= p.absent || p.hi <= p.absent));
        }
        shape.one_sided = shape.one_sided && bounded;
        Eigen::VectorXd moved;
        model.predict(with_effect(at, e, probe), moved, nullptr);
        Eigen::VectorXd s = Eigen::VectorXd::Zero(basis.rows());
        s.head(mean.size()) = whitening.apply(moved - mean);
        const double whole = s.squaredNorm();
        for (int twice = 0; twice < 2; ++twice) s -= q * (q.transpose() * s);
        seen = seen && s.allFinite() && s.squaredNorm() > least_survival * whole;
        shape.columns.push_back(static_cast<Eigen::Index>(columns.size()));
        columns.push_back(std::move(s));
        precision.push_back(units * units);
      }
      if (seen) {
        shapes_.push_back(std::move(shape));
      } else {
        columns.resize(columns.size() - group.size());
        precision.resize(columns.size());
      }
    }
  }
  Eigen::MatrixXd matrix(basis.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i)
    matrix.col(static_cast<Eigen::Index>(i)) = columns[i];
  gram_ = matrix.transpose() * matrix;
  prior_precision_ = Eigen::Map<const Eigen::VectorXd>(precision.data(),
                                                       static_cast<Eigen::Index>(precision.size()));
  // In units of each signature's length: their sizes differ by more than rounding would bear.
  const Eigen::VectorXd unit = gram_.diagonal().cwiseSqrt();
  const Eigen::VectorXd inverse = unit.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(inverse.asDiagonal() * gram_ * inverse.asDiagonal()));
  root_ = unit.asDiagonal() * eigen.eigenvectors() *
          eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/// ln of the evidence of one shape against the base, for the pulls `right` on all signatures.
double NamingCeiling::log_evidence(const Shape& shape, const Eigen::VectorXd& right) const {
  const Eigen::VectorXd unit =
      prior_precision_(shape.columns).cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd matrix =
      unit.asDiagonal() * gram_(shape.columns, shape.columns) * unit.asDiagonal();
  matrix.diagonal().array() += 1;
  const Eigen::VectorXd pull = unit.cwiseProduct(right(shape.columns));
  const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
  const Eigen::VectorXd c = factor.solve(pull);
  const Eigen::MatrixXd lower = factor.matrixL();
  double value = 0.5 * pull.dot(c) - lower.diagonal().array().log().sum();
  if (shape.one_sided)
    value += std::log(std::max(1e-300, std::erfc(-c[0] * lower(0, 0) / std::numbers::sqrt2)));
  return value;
}

/// One effect at one visibility, many times.
NamingRates NamingCeiling::trial(std::size_t effect, double rho, int trials,
                                 std::uint64_t seed) const {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<const Shape*> own;
  for (const Shape& shape : shapes_)
    if (shape.effect == effect) own.push_back(&shape);
  NamingRates rates;
  Eigen::VectorXd noise(root_.cols());
  for (int t = 0; t < trials && !own.empty(); ++t) {
    const Shape& shape = *own[random() % own.size()];
    // A direction within the shape (the phase of a harmonic), then its size.
    Eigen::VectorXd mix(static_cast<Eigen::Index>(shape.columns.size()));
    for (double& m : mix) m = normal(random);
    if (shape.one_sided) mix = mix.cwiseAbs();
    const Eigen::MatrixXd block = gram_(shape.columns, shape.columns);
    mix *= rho / std::sqrt(mix.dot(block * mix));
    for (double& x : noise) x = normal(random);
    const Eigen::VectorXd right = gram_(Eigen::all, shape.columns) * mix + root_ * noise;
    std::map<std::size_t, double> best;
    for (const Shape& other : shapes_) {
      const double value = log_evidence(other, right);
      const auto [place, fresh] = best.emplace(other.effect, value);
      if (!fresh) place->second = std::max(place->second, value);
    }
    const auto first = std::max_element(
        best.begin(), best.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    ++rates.drawn;
    if (first->first == effect) {
      ++rates.named;
    } else {
      ++rates.taken_for[{model_.effects()[effect].name, model_.effects()[first->first].name}];
    }
    if (2 * (first->second - best[effect]) < ambiguous) ++rates.in_set;
    for (const auto& [e, value] : best)
      rates.set_size += 2 * (first->second - value) < ambiguous ? 1 : 0;
  }
  return rates;
}

NamingRates NamingCeiling::rates(double rho, int trials, std::uint64_t seed, int threads) const {
  std::vector<NamingRates> parts(model_.effects().size());
  for_each_index(parts.size(), threads,
                 [&](std::size_t e) { parts[e] = trial(e, rho, trials, seed + 1000 * e); });
  NamingRates sum;
  for (const NamingRates& part : parts) sum += part;
  return sum;
}

}  // namespace umov::gap
