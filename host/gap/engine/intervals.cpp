#include "host/gap/engine/intervals.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Cholesky>

namespace umov::gap {
namespace {

constexpr double two_sided_95 = 1.959964;
constexpr double chi2_95 = two_sided_95 * two_sided_95;  // one degree of freedom

double cost(const Refit& fit) {
  return fit.chi2 + fit.penalty;
}

/// Adds to an explanation's values, the base's first.
void move(Explanation& explanation, const Eigen::VectorXd& step) {
  Eigen::Index next = 0;
  for (double& x : explanation.base) x += step[next++];
  for (auto& alpha : explanation.alpha)
    for (double& x : alpha) x += step[next++];
}

/// The fits around one parameter, the first of an effect.
class Surroundings {
 public:
  Surroundings(const ForwardModel& model, const Refit& fit, std::size_t place,
               const Whitening& whitening)
      : model_(model), fit_(fit), place_(place), whitening_(whitening) {
    number_ = static_cast<Eigen::Index>(fit.explanation.base.size());
    for (std::size_t k = 0; k < place; ++k)
      number_ += static_cast<Eigen::Index>(fit.explanation.alpha[k].size());
  }

  Eigen::Index number() const { return number_; }

  /// End of the 95 % interval on one side of the best value: `side` -1 or 1.
  double end(double side, double error) {
    constexpr int most_steps = 10;
    constexpr double longer = 1.6;
    constexpr double straight = 3;  // root of Δχ² to which it may be taken for a straight line
    const Parameter& p = parameter();
    const Eigen::VectorXd along = companions();
    const double least = unshaped_cost(fit_);
    Explanation at = fit_.explanation;
    double last = at.alpha[place_][0], last_root = 0, step = side * two_sided_95 * error;
    for (int i = 0; i < most_steps; ++i) {
      const double next = std::clamp(last + step, p.lo, p.hi);
      Explanation there = at;
      move(there, along * (next - last));
      there.alpha[place_][0] = next;
      const Refit held = refit(model_, there, whitening_, 12, &without(), {number_});
      const double root = std::sqrt(std::max(0.0, unshaped_cost(held) - least));
      const bool inside = root < two_sided_95;
      if (!inside && root < straight)
        return last + (next - last) * (two_sided_95 - last_root) / (root - last_root);
      if (inside && (next <= p.lo || next >= p.hi)) return next;
      if (inside) {
        at = held.explanation;
        last = next;
        last_root = root;
        step *= longer;
      } else {
        step = 0.4 * (next - last);
      }
    }
    return last;
  }

  /// Does the opposite sign fit as well?
  bool has_twin() {
    Explanation turned = fit_.explanation;
    double& value = turned.alpha[place_][0];
    value = 2 * parameter().absent - value;
    // As far as the other parameters can make up for it to first order.
    constexpr double worth_a_fit = 30;
    Eigen::VectorXd mean;
    model_.predict(turned, mean, nullptr);
    Eigen::VectorXd left = whitening_.apply(model_.observations().value - mean);
    if (!left.allFinite()) return false;
    const Eigen::VectorXd pull = without().jacobian.transpose() * left;
    const Eigen::LDLT<Eigen::MatrixXd> others(without().precision);
    if (left.squaredNorm() - pull.dot(others.solve(pull)) > fit_.chi2 + worth_a_fit) return false;
    const Refit twin = refit(model_, turned, whitening_, 12, &without());
    const bool still_turned = (twin.explanation.alpha[place_][0] - parameter().absent) *
                                  (fit_.explanation.alpha[place_][0] - parameter().absent) <
                              0;
    return still_turned && cost(twin) < cost(fit_) + chi2_95;
  }

 private:
  const Parameter& parameter() const {
    return model_.effects()[fit_.explanation.effects[place_]].parameters.front();
  }
  /// How the other parameters go with this one along the valley of the likelihood, for a step of
  /// one. Those that rest at a bound stay.
  Eigen::VectorXd companions() const {
    Eigen::VectorXd along = Eigen::VectorXd::Zero(fit_.precision.rows());
    std::vector<Eigen::Index> others;
    for (const Eigen::Index i : fit_.free)
      if (i != number_) others.push_back(i);
    const Eigen::VectorXd scale =
        fit_.precision(others, others).diagonal().cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd scaled =
        scale.asDiagonal() * fit_.precision(others, others) * scale.asDiagonal();
    scaled.diagonal().array() += 1e-10;
    const Eigen::VectorXd pull = fit_.precision(others, number_);
    along(others) = -scale.cwiseProduct(scaled.ldlt().solve(scale.cwiseProduct(pull)));
    return along;
  }
  /// All of a shape's range is as good: its prior says nothing against the ends.
  double unshaped_cost(const Refit& fit) const {
    const auto& declared = model_.effects()[fit.explanation.effects[place_]].parameters;
    double value = cost(fit);
    for (std::size_t i = 0; i < declared.size(); ++i) {
      if (!declared[i].shape) continue;
      const double off =
          (fit.explanation.alpha[place_][i] - declared[i].absent) / declared[i].prior_u;
      value -= off * off;
    }
    return value;
  }
  /// Lends derivatives of all other parameters; the effect's own are taken anew.
  const Refit& without() {
    if (!without_)
      without_ = std::make_unique<Refit>(
          refit(model_, without_effect(fit_.explanation, fit_.explanation.effects[place_]),
                whitening_, 0, &fit_));
    return *without_;
  }

  const ForwardModel& model_;
  const Refit& fit_;
  std::size_t place_;
  const Whitening& whitening_;
  Eigen::Index number_ = 0;
  std::unique_ptr<Refit> without_;
};

}  // namespace

NamedValue named_value(const Parameter& parameter, double value, double error) {
  return {parameter.name,
          parameter.unit,
          {value, std::max(parameter.lo, value - two_sided_95 * error),
           std::min(parameter.hi, value + two_sided_95 * error)}};
}

std::vector<NamedValue> effect_parameters(const ForwardModel& model, const Refit& fit,
                                          std::size_t place, const Whitening& whitening) {
  const Effect& effect = model.effects()[fit.explanation.effects[place]];
  const auto& declared = effect.parameters;
  const std::vector<double>& alpha = fit.explanation.alpha[place];
  Surroundings around(model, fit, place, whitening);
  const Eigen::VectorXd errors =
      standard_errors(fit.precision)
          .segment(around.number(), static_cast<Eigen::Index>(alpha.size()));
  std::vector<NamedValue> named;
  for (std::size_t i = 0; i < declared.size(); ++i)
    named.push_back(named_value(declared[i], alpha[i], errors[static_cast<Eigen::Index>(i)]));

  const Parameter& first = declared.front();
  const double error = errors[0];
  if (effect.structural || first.shape || first.choice || !(error > 0) || !std::isfinite(error))
    return named;
  Interval& interval = named.front().interval;
  const bool shaped =
      std::any_of(declared.begin(), declared.end(), [](const Parameter& p) { return p.shape; });
  if (shaped) {
    interval.lo = around.end(-1, error);
    interval.hi = around.end(1, error);
  } else if (declared.size() == 1 && first.lo < first.absent && first.hi > first.absent &&
             around.has_twin()) {
    const double twin = 2 * first.absent - interval.value;
    interval.lo = std::min(interval.lo, std::max(first.lo, twin - two_sided_95 * error));
    interval.hi = std::max(interval.hi, std::min(first.hi, twin + two_sided_95 * error));
  }
  return named;
}

}  // namespace umov::gap
