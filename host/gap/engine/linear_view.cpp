#include "host/gap/engine/linear_view.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include "host/parallel/for_each_index.hpp"

namespace umov::gap {
namespace {

/// Share of a signature's squared length that must survive the projection: below it, rounding and
/// the linearisation itself are larger than the signature.
constexpr double smallest_survival = 1e-9;

/// ln of the standard normal distribution function.
double ln_normal_cdf(double x) {
  if (x > -30) return std::log(0.5 * std::erfc(-x / std::numbers::sqrt2));
  return -0.5 * x * x - std::log(-x) - 0.5 * std::log(2 * std::numbers::pi);
}

/// Of how many prior sigmas of the effect is this probe?
double prior_units(const Effect& effect, const Probe& probe) {
  double units = 0;
  for (std::size_t i = 0; i < probe.size(); ++i) {
    const Parameter& p = effect.parameters[i];
    if (!p.shape && !p.choice) units = std::max(units, std::abs(probe[i] - p.absent) / p.prior_u);
  }
  return units;
}

/// True where the effect exists on one side of `absent` only, and the probe is one of its kind.
bool exists_one_way(const Effect& effect, const std::vector<Probe>& group) {
  if (group.size() != 1) return false;
  for (std::size_t i = 0; i < group[0].size(); ++i) {
    const Parameter& p = effect.parameters[i];
    if (p.shape || p.choice || group[0][i] == p.absent) continue;
    if (p.lo >= p.absent || p.hi <= p.absent) return true;
  }
  return false;
}

/// d mean / d parameter of an effect that is not in an explanation yet, where it is absent.
Eigen::MatrixXd linear_signatures(const ForwardModel& model, const Refit& at, std::size_t effect) {
  std::vector<double> absent;
  for (const Parameter& p : model.effects()[effect].parameters) absent.push_back(p.absent);
  const Explanation with = with_effect(at.explanation, effect, absent);
  std::vector<bool> wanted(with.base.size(), false);
  Eigen::Index first = 0;
  for (std::size_t k = 0; k < with.effects.size(); ++k) {
    if (with.effects[k] == effect) first = static_cast<Eigen::Index>(wanted.size());
    wanted.insert(wanted.end(), with.alpha[k].size(), with.effects[k] == effect);
  }
  Eigen::VectorXd mean;
  Eigen::MatrixXd jacobian;
  model.predict(with, mean, &jacobian, wanted);
  return jacobian.middleCols(first, static_cast<Eigen::Index>(absent.size()));
}

double ln_det(const Eigen::LDLT<Eigen::MatrixXd>& factor) {
  return factor.vectorD().cwiseAbs().array().max(1e-300).log().sum();
}

}  // namespace

LinearView::LinearView(const ForwardModel& model, const Refit& at, const Whitening& whitening,
                       const std::vector<int>& fold, bool with_candidates, int threads,
                       const LinearView* near)
    : model_(model) {
  const Eigen::Index observations = at.residual.size();
  fitted_ = static_cast<Eigen::Index>(at.free.size());

  const std::size_t effects = with_candidates ? model.effects().size() : 0;
  for (std::size_t e = 0; e < effects; ++e) {
    const Effect& effect = model.effects()[e];
    if (std::find(at.explanation.effects.begin(), at.explanation.effects.end(), e) !=
        at.explanation.effects.end())
      continue;
    for (std::size_t g = 0; g < effect.probes.size(); ++g) {
      Candidate candidate{e, {}};
      for (const Probe& probe : effect.probes[g]) {
        const double units = prior_units(effect, probe);
        members_.push_back({e, probe, exists_one_way(effect, effect.probes[g]), units * units});
        candidate.columns.push_back(static_cast<Eigen::Index>(members_.size()) - 1);
      }
      candidates_.push_back(std::move(candidate));
    }
  }

  const Eigen::Index probes = static_cast<Eigen::Index>(members_.size());
  Eigen::MatrixXd columns(observations, fitted_ + probes);
  columns.leftCols(fitted_) = at.jacobian(Eigen::all, at.free);
  std::vector<bool> known(members_.size(), false);
  if (near != nullptr) {
    for (std::size_t m = 0; m < members_.size(); ++m) {
      const auto same =
          std::find_if(near->members_.begin(), near->members_.end(), [&](const Member& other) {
            return other.effect == members_[m].effect && other.probe == members_[m].probe;
          });
      known[m] = same != near->members_.end();
      if (known[m])
        columns.col(fitted_ + static_cast<Eigen::Index>(m)) =
            near->signatures_.col(same - near->members_.begin());
    }
  }
  // Signatures in proportion to their parameters are derivatives, all of an effect at once.
  std::vector<std::size_t> linear;
  for (std::size_t e = 0; e < effects; ++e) {
    bool wanted = false;
    for (std::size_t m = 0; m < members_.size(); ++m)
      wanted = wanted || (members_[m].effect == e && !known[m]);
    if (model.effects()[e].linear && wanted) linear.push_back(e);
  }
  for_each_index(linear.size(), threads, [&](std::size_t i) {
    const Eigen::MatrixXd derivatives = linear_signatures(model, at, linear[i]);
    for (std::size_t m = 0; m < members_.size(); ++m) {
      if (members_[m].effect != linear[i]) continue;
      const Eigen::Map<const Eigen::VectorXd> probe(
          members_[m].probe.data(), static_cast<Eigen::Index>(members_[m].probe.size()));
      const Eigen::VectorXd signature = whitening.apply(derivatives * probe);
      columns.col(fitted_ + static_cast<Eigen::Index>(m)) =
          signature.allFinite() ? signature : Eigen::VectorXd(Eigen::VectorXd::Zero(observations));
    }
  });
  for_each_index(members_.size(), threads, [&](std::size_t i) {
    if (known[i] || model.effects()[members_[i].effect].linear) return;
    Eigen::VectorXd shifted;
    model.predict(with_effect(at.explanation, members_[i].effect, members_[i].probe), shifted,
                  nullptr);
    const Eigen::VectorXd signature = whitening.apply(shifted - at.mean);
    // A probe outside of what the model can compute is as good as none.
    columns.col(fitted_ + static_cast<Eigen::Index>(i)) =
        signature.allFinite() ? signature : Eigen::VectorXd(Eigen::VectorXd::Zero(observations));
  });
  signatures_ = columns.rightCols(probes);
  const Eigen::VectorXd& residual = at.residual;

  const int count = fold.empty() ? 0 : *std::max_element(fold.begin(), fold.end()) + 1;
  std::vector<std::vector<Eigen::Index>> rows(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < fold.size(); ++i)
    rows[static_cast<std::size_t>(fold[i])].push_back(static_cast<Eigen::Index>(i));
  all_.matrix = Eigen::MatrixXd::Zero(fitted_, fitted_);
  // A minimum of the whole: what the data pull is what the priors hold.
  all_.right = Eigen::VectorXd::Zero(fitted_);
  for (const auto& list : rows) {
    folds_.push_back(normal_of(columns.leftCols(fitted_), residual, list));
    all_.matrix += folds_.back().matrix;
  }

  all_.matrix.diagonal() += at.prior_precision(at.free);

  // What the fitted parameters leave of the signatures, by orthogonal projection (normal equations
  // would lose half of the digits). Priors are further observations, of the parameters themselves.
  const Eigen::MatrixXd q = followed_directions(at);
  Eigen::MatrixXd left = Eigen::MatrixXd::Zero(q.rows(), probes);
  left.topRows(observations) = columns.rightCols(probes);
  left -= q * (q.transpose() * left);
  left -= q * (q.transpose() * left);
  reduced_ = Eigen::MatrixXd::Zero(probes, probes);
  reduced_.selfadjointView<Eigen::Lower>().rankUpdate(left.transpose());
  reduced_ = Eigen::MatrixXd(reduced_.selfadjointView<Eigen::Lower>());
  reduced_right_ = left.topRows(observations).transpose() * residual;
  for (Eigen::Index i = 0; i < probes; ++i) {
    const double full = columns.col(fitted_ + i).squaredNorm();
    if (reduced_(i, i) < smallest_survival * full || !(full > 0)) {
      // Absorbed: it can neither be seen nor help.
      reduced_.row(i).setZero();
      reduced_.col(i).setZero();
      reduced_right_[i] = 0;
    }
  }
  residual_ = residual;
  kept_by_fit_ = Eigen::VectorXd::Ones(observations);
  kept_by_fit_ -= q.topRows(observations).rowwise().squaredNorm();
  fitted_rank_ = static_cast<double>(q.cols());
  for (Eigen::Index i = 0; i < probes; ++i) {
    const double size = left.col(i).norm();
    if (reduced_(i, i) > 0) {
      left.col(i) /= size;
    } else {
      left.col(i).setZero();
    }
  }
  left_ = left.topRows(observations);
}

LinearView::Left LinearView::left_by_everything() const {
  // An observation that decides a parameter by itself says nothing of the noise.
  constexpr double least_kept = 0.05;
  Eigen::VectorXd kept = kept_by_fit_.cwiseMax(least_kept);
  if (left_.cols() == 0) return {residual_, std::move(kept), fitted_rank_};
  // Series of many terms would follow slow noise too.
  constexpr std::size_t many = 15;
  std::vector<Eigen::Index> used;
  for (const Candidate& c : candidates_)
    if (c.columns.size() < many) used.insert(used.end(), c.columns.begin(), c.columns.end());
  if (used.empty()) return {residual_, std::move(kept), fitted_rank_};
  // Signatures of alternatives repeat each other.
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> catalogue(Eigen::MatrixXd(left_(Eigen::all, used)));
  catalogue.setThreshold(1e-4);
  const Eigen::MatrixXd span =
      catalogue.householderQ() * Eigen::MatrixXd::Identity(left_.rows(), catalogue.rank());
  kept = (kept - span.rowwise().squaredNorm()).cwiseMax(least_kept);
  return {residual_ - span * (span.transpose() * residual_), std::move(kept),
          fitted_rank_ + static_cast<double>(catalogue.rank())};
}

LinearView::Normal LinearView::normal_of(const Eigen::MatrixXd& columns,
                                         const Eigen::VectorXd& residual,
                                         const std::vector<Eigen::Index>& rows) const {
  const Eigen::MatrixXd part = columns(rows, Eigen::all);
  const Eigen::VectorXd r = residual(rows);
  Normal normal;
  normal.matrix = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
  normal.matrix.selfadjointView<Eigen::Lower>().rankUpdate(part.transpose());
  normal.matrix = Eigen::MatrixXd(normal.matrix.selfadjointView<Eigen::Lower>());
  normal.right = part.transpose() * r;
  normal.square = r.squaredNorm();
  normal.observations = r.size();
  return normal;
}

std::vector<Eigen::Index> LinearView::columns_of(std::span<const std::size_t> set) const {
  std::vector<Eigen::Index> columns;
  for (const std::size_t s : set)
    columns.insert(columns.end(), candidates_[s].columns.begin(), candidates_[s].columns.end());
  return columns;
}

LinearFit LinearView::fit(std::span<const std::size_t> set, const Eigen::VectorXd& pull) const {
  const std::vector<Eigen::Index> columns = columns_of(set);
  const auto n = static_cast<Eigen::Index>(columns.size());
  LinearFit result;
  result.coefficient = Eigen::VectorXd::Zero(n);
  if (n == 0) return result;

  Eigen::VectorXd prior(n);
  for (Eigen::Index i = 0; i < n; ++i)
    prior[i] =
        members_[static_cast<std::size_t>(columns[static_cast<std::size_t>(i)])].prior_precision;

  // Columns whose sign would be unphysical leave, one at a time, the worst first.
  std::vector<Eigen::Index> active(static_cast<std::size_t>(n));
  for (Eigen::Index i = 0; i < n; ++i) active[static_cast<std::size_t>(i)] = i;
  const auto wrong_sign = [&](Eigen::Index i, double c) {
    return members_[static_cast<std::size_t>(columns[static_cast<std::size_t>(i)])].one_sided &&
           c < 0;
  };
  // In units of the prior: coefficients there are of order one whatever the probe.
  const Eigen::VectorXd unit = prior.cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  while (!active.empty()) {
    std::vector<Eigen::Index> chosen;
    for (const Eigen::Index a : active) chosen.push_back(columns[static_cast<std::size_t>(a)]);
    const Eigen::VectorXd u = unit(active);
    Eigen::MatrixXd matrix = u.asDiagonal() * reduced_(chosen, chosen) * u.asDiagonal();
    const Eigen::VectorXd right = u.cwiseProduct(pull(chosen));
    Eigen::MatrixXd with_prior = matrix;
    with_prior.diagonal().array() += 1.0;
    const Eigen::LDLT<Eigen::MatrixXd> factor(with_prior);
    const Eigen::VectorXd c = factor.solve(right);

    Eigen::Index worst = -1;
    for (std::size_t k = 0; k < active.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      if (wrong_sign(active[k], c[i]) && (worst < 0 || c[i] < c[worst])) worst = i;
    }
    if (worst >= 0) {
      // The half of its prior that is left lies at zero: no more evidence than without it.
      active.erase(active.begin() + worst);
      result.ln_evidence -= std::numbers::ln2;
      continue;
    }
    result.ln_evidence += 0.5 * right.dot(c) - 0.5 * ln_det(factor);
    const Eigen::MatrixXd covariance = factor.solve(Eigen::MatrixXd::Identity(c.size(), c.size()));
    for (std::size_t k = 0; k < active.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      const Eigen::Index column = columns[static_cast<std::size_t>(active[k])];
      if (members_[static_cast<std::size_t>(column)].one_sided)
        result.ln_evidence += std::numbers::ln2 + ln_normal_cdf(c[i] / std::sqrt(covariance(i, i)));
      result.coefficient[active[k]] = c[i] * u[i];
    }
    matrix.diagonal().array() += 1e-9 * (matrix.diagonal().maxCoeff() + 1e-300);
    result.gain = right.dot(matrix.ldlt().solve(right));
    break;
  }
  return result;
}

std::vector<double> LinearView::alpha(std::size_t candidate,
                                      const Eigen::VectorXd& coefficient) const {
  const Candidate& c = candidates_[candidate];
  const Effect& effect = model_.effects()[c.effect];
  // The shape parameters of the member that counts most, the rest in proportion.
  std::size_t most = 0;
  for (std::size_t i = 1; i < c.columns.size(); ++i)
    if (std::abs(coefficient[static_cast<Eigen::Index>(i)]) >
        std::abs(coefficient[static_cast<Eigen::Index>(most)]))
      most = i;
  std::vector<double> alpha = members_[static_cast<std::size_t>(c.columns[most])].probe;
  // Alternatives of different size say that the effect is not in proportion to its parameter: far
  // from the probe the straight line is no guide.
  const bool bends = effect.probes.size() > 1 && effect.probes[0].size() == 1 &&
                     effect.probes[0][0][0] != effect.probes[1][0][0];
  for (std::size_t p = 0; p < alpha.size(); ++p) {
    const Parameter& parameter = effect.parameters[p];
    if (parameter.shape || parameter.choice) continue;
    double value = parameter.absent;
    for (std::size_t i = 0; i < c.columns.size(); ++i) {
      const auto& probe = members_[static_cast<std::size_t>(c.columns[i])].probe;
      const double times = coefficient[static_cast<Eigen::Index>(i)];
      value += (bends ? std::clamp(times, 0.5, 2.0) : times) * (probe[p] - parameter.absent);
    }
    alpha[p] = std::clamp(value, parameter.lo, parameter.hi);
  }
  return alpha;
}

std::vector<double> LinearView::held_out(const std::vector<Eigen::Index>& columns,
                                         const Eigen::VectorXd& prior,
                                         const std::vector<Normal>& folds,
                                         const Normal& all) const {
  // A combination that hardly anything but one fold determines (an index and a gain by the row near
  // Brewster's angle) would run away without it, far from where the model is straight: a little of
  // what all know holds it.
  constexpr double hold = 0.05;
  std::vector<double> chi2;
  for (const Normal& fold : folds) {
    Eigen::MatrixXd matrix =
        (1 + hold) * all.matrix(columns, columns) - fold.matrix(columns, columns);
    matrix.diagonal() += prior;
    const Eigen::VectorXd right = all.right(columns) - fold.right(columns);
    const Eigen::VectorXd scale = matrix.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
    scaled.diagonal().array() += 1e-10;
    const Eigen::VectorXd step = scale.cwiseProduct(scaled.ldlt().solve(scale.cwiseProduct(right)));
    const Eigen::VectorXd moved = fold.matrix(columns, columns) * step;
    chi2.push_back(fold.square - 2 * step.dot(fold.right(columns)) + step.dot(moved));
  }
  return chi2;
}

std::vector<double> LinearView::held_out_by_fold() const {
  std::vector<Eigen::Index> columns(static_cast<std::size_t>(fitted_));
  for (Eigen::Index i = 0; i < fitted_; ++i) columns[static_cast<std::size_t>(i)] = i;
  return held_out(columns, Eigen::VectorXd::Zero(fitted_), folds_, all_);
}

double LinearView::held_out_floor(int draws, std::uint64_t seed) const {
  std::vector<Eigen::Index> columns(static_cast<std::size_t>(fitted_));
  for (Eigen::Index i = 0; i < fitted_; ++i) columns[static_cast<std::size_t>(i)] = i;
  // A fold's normal equations for noise alone: right sides with covariance Jᵀ J, and the rest of
  // the squares from the directions that no parameter reaches.
  std::vector<Eigen::MatrixXd> root;
  for (const Normal& fold : folds_) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(fold.matrix(columns, columns));
    root.emplace_back(eigen.eigenvectors() *
                      eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal());
  }
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> sums;
  for (int d = 0; d < draws; ++d) {
    std::vector<Normal> folds;
    Normal all;
    all.matrix = all_.matrix(columns, columns);
    all.right = Eigen::VectorXd::Zero(fitted_);
    for (std::size_t f = 0; f < folds_.size(); ++f) {
      Eigen::VectorXd unit(fitted_);
      for (double& x : unit) x = normal(random);
      Normal fold;
      fold.matrix = folds_[f].matrix(columns, columns);
      fold.right = root[f] * unit;
      const double left = std::max(1.0, static_cast<double>(folds_[f].observations - fitted_));
      fold.square = unit.squaredNorm() + left + std::sqrt(2 * left) * normal(random);
      all.right += fold.right;
      folds.push_back(std::move(fold));
    }
    double sum = 0;
    for (const double chi2 : held_out(columns, Eigen::VectorXd::Zero(fitted_), folds, all))
      sum += chi2;
    sums.push_back(sum);
  }
  std::nth_element(sums.begin(), sums.begin() + static_cast<std::ptrdiff_t>(sums.size() / 2),
                   sums.end());
  return sums[sums.size() / 2];
}

Eigen::MatrixXd LinearView::root_of_pulls() const {
  // Signatures of unit length: their sizes differ by more than rounding would bear.
  const Eigen::VectorXd length = reduced_.diagonal().cwiseMax(0.0).cwiseSqrt();
  Eigen::VectorXd unit = length;
  for (double& x : unit) x = x > 0 ? 1.0 / x : 0.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(unit.asDiagonal() * reduced_ * unit.asDiagonal()));
  return length.asDiagonal() * eigen.eigenvectors() *
         eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

std::vector<double> LinearView::null_maxima(int draws, std::uint64_t seed) const {
  Eigen::VectorXd unit(reduced_.rows());
  for (Eigen::Index i = 0; i < unit.size(); ++i)
    unit[i] = reduced_(i, i) > 0 ? 1.0 / std::sqrt(reduced_(i, i)) : 0.0;
  const Eigen::MatrixXd overlap = unit.asDiagonal() * reduced_ * unit.asDiagonal();
  const Eigen::MatrixXd root = unit.asDiagonal() * root_of_pulls();
  // Structure is judged by its evidence: its many terms together would gain much by chance.
  std::vector<std::size_t> small;
  std::vector<Eigen::MatrixXd> inverse;
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const Candidate& c = candidates_[k];
    if (model_.effects()[c.effect].structural) continue;
    const Eigen::MatrixXd part = overlap(c.columns, c.columns);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(part);
    // What is fitted has absorbed the directions without length.
    const double least = 1e-6 * own.eigenvalues().maxCoeff();
    Eigen::VectorXd reciprocal = own.eigenvalues();
    for (double& x : reciprocal) x = x > least && x > 0 ? 1.0 / x : 0.0;
    inverse.emplace_back(own.eigenvectors() * reciprocal.asDiagonal() *
                         own.eigenvectors().transpose());
    small.push_back(k);
  }
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> maxima;
  Eigen::VectorXd draw(overlap.rows());
  for (int d = 0; d < draws; ++d) {
    for (double& x : draw) x = normal(random);
    const Eigen::VectorXd right = root * draw;
    double most = 0;
    for (std::size_t k = 0; k < small.size(); ++k) {
      const Candidate& c = candidates_[small[k]];
      const Eigen::VectorXd part = right(c.columns);
      if (one_sided(small[k]) && part[0] < 0) continue;
      most = std::max(most, part.dot(inverse[k] * part));
    }
    maxima.push_back(most);
  }
  std::sort(maxima.begin(), maxima.end());
  return maxima;
}

}  // namespace umov::gap
