#include "host/gap/engine/refit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "host/errors/error.hpp"

namespace umov::gap {
namespace {

/// Parameters of an explanation in one vector, with what is known of each.
struct Flat {
  std::vector<const Parameter*> parameter;
  Eigen::VectorXd value;
};

Flat flatten(const ForwardModel& model, const Explanation& explanation) {
  Flat flat;
  std::vector<double> values;
  for (std::size_t i = 0; i < explanation.base.size(); ++i) {
    flat.parameter.push_back(&model.base()[i]);
    values.push_back(explanation.base[i]);
  }
  for (std::size_t k = 0; k < explanation.effects.size(); ++k) {
    const auto& declared = model.effects()[explanation.effects[k]].parameters;
    for (std::size_t i = 0; i < declared.size(); ++i) {
      flat.parameter.push_back(&declared[i]);
      values.push_back(explanation.alpha[k][i]);
    }
  }
  flat.value =
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  return flat;
}

void unflatten(const Eigen::VectorXd& value, Explanation& explanation) {
  Eigen::Index next = 0;
  for (double& x : explanation.base) x = value[next++];
  for (auto& alpha : explanation.alpha)
    for (double& x : alpha) x = value[next++];
}

Eigen::VectorXd prior_weight(const Flat& flat) {
  Eigen::VectorXd weight(flat.value.size());
  for (Eigen::Index i = 0; i < weight.size(); ++i) {
    const double u = flat.parameter[static_cast<std::size_t>(i)]->prior_u;
    weight[i] = std::isfinite(u) ? 1.0 / (u * u) : 0.0;
  }
  return weight;
}

Eigen::VectorXd from_prior(const Flat& flat, const Eigen::VectorXd& value) {
  Eigen::VectorXd distance(value.size());
  for (Eigen::Index i = 0; i < value.size(); ++i)
    distance[i] = value[i] - flat.parameter[static_cast<std::size_t>(i)]->absent;
  return distance;
}

Eigen::VectorXd within_bounds(const Flat& flat, Eigen::VectorXd value) {
  for (Eigen::Index i = 0; i < value.size(); ++i) {
    const Parameter& p = *flat.parameter[static_cast<std::size_t>(i)];
    value[i] = std::clamp(value[i], p.lo, p.hi);
  }
  return value;
}

/// Is the parameter at a bound that the gradient (of the likelihood) would take it across?
bool pushes_outwards(const Flat& flat, const Eigen::VectorXd& value,
                     const Eigen::VectorXd& gradient, Eigen::Index i) {
  const Parameter& p = *flat.parameter[static_cast<std::size_t>(i)];
  return (value[i] <= p.lo && gradient[i] < 0) || (value[i] >= p.hi && gradient[i] > 0);
}

/// Step of the damped normal equations with the parameters at a bound, that it would push outwards,
/// held.
Eigen::VectorXd bounded_step(const Flat& flat, const Eigen::VectorXd& value,
                             const Eigen::MatrixXd& precision, const Eigen::VectorXd& gradient,
                             double damping) {
  const Eigen::Index n = value.size();
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!pushes_outwards(flat, value, gradient, i) && precision(i, i) > 0) free.push_back(i);
  }
  Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
  if (free.empty()) return step;
  // Scaled by the diagonal: parameters differ by ten orders of magnitude.
  const Eigen::VectorXd scale = precision(free, free).diagonal().cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd scaled = scale.asDiagonal() * precision(free, free) * scale.asDiagonal();
  scaled.diagonal().array() += damping + 1e-12;
  const Eigen::VectorXd right = scale.cwiseProduct(gradient(free));
  step(free) = scale.cwiseProduct(scaled.ldlt().solve(right));
  return step;
}

/// Decrease of χ² below which a fit is settled, and below which a step's derivatives serve again.
constexpr double settled_gain = 1e-4, carried_gain = 1.0;

struct Evaluation {
  Eigen::VectorXd mean, residual;
  double chi2 = 0, penalty = 0;
  double cost() const { return chi2 + penalty; }
};

}  // namespace

Explanation base_explanation(const ForwardModel& model) {
  Explanation explanation;
  for (const Parameter& p : model.base()) explanation.base.push_back(p.absent);
  return explanation;
}

Explanation with_effect(const Explanation& explanation, std::size_t effect,
                        const std::vector<double>& alpha) {
  Explanation result = explanation;
  const auto at = std::lower_bound(result.effects.begin(), result.effects.end(), effect);
  const auto offset = at - result.effects.begin();
  result.effects.insert(at, effect);
  result.alpha.insert(result.alpha.begin() + offset, alpha);
  return result;
}

Explanation without_effect(const Explanation& explanation, std::size_t effect) {
  Explanation result = explanation;
  const auto at = std::find(result.effects.begin(), result.effects.end(), effect);
  if (at == result.effects.end()) return result;
  result.alpha.erase(result.alpha.begin() + (at - result.effects.begin()));
  result.effects.erase(at);
  return result;
}

Refit refit(const ForwardModel& model, const Explanation& start, const Whitening& whitening,
            int max_iterations) {
  Refit best;
  best.explanation = start;
  const Flat flat = flatten(model, start);
  const Eigen::VectorXd weight = prior_weight(flat);
  const Eigen::VectorXd& observed = model.observations().value;

  const auto evaluate = [&](const Eigen::VectorXd& value, Eigen::MatrixXd* jacobian) {
    unflatten(value, best.explanation);
    Evaluation e;
    model.predict(best.explanation, e.mean, jacobian);
    e.residual = whitening.apply(observed - e.mean);
    e.chi2 = e.residual.squaredNorm();
    const Eigen::VectorXd distance = from_prior(flat, value);
    e.penalty = distance.cwiseAbs2().dot(weight);
    if (!std::isfinite(e.chi2))
      throw Error("the simulation gives values that are not numbers",
                  "check the starting parameters and the angles of the measurement");
    return e;
  };

  Eigen::VectorXd value = within_bounds(flat, flat.value);
  Eigen::MatrixXd jacobian;
  Evaluation now = evaluate(value, &jacobian);
  const auto take_derivatives = [&] {
    jacobian = whitening.apply(jacobian);
    best.precision = Eigen::MatrixXd::Zero(value.size(), value.size());
    best.precision.selfadjointView<Eigen::Lower>().rankUpdate(jacobian.transpose());
    best.precision = Eigen::MatrixXd(best.precision.selfadjointView<Eigen::Lower>());
    best.precision.diagonal() += weight;
  };
  const auto gradient_of = [&](const Evaluation& e) -> Eigen::VectorXd {
    return jacobian.transpose() * e.residual - weight.cwiseProduct(from_prior(flat, value));
  };
  take_derivatives();
  bool derivatives_are_here = true;
  double damping = 1e-4;
  for (; best.iterations < max_iterations; ++best.iterations) {
    const Eigen::VectorXd gradient = gradient_of(now);
    bool improved = false;
    double gained = 0;
    for (int attempt = 0; attempt < 12 && !improved; ++attempt) {
      const Eigen::VectorXd step = bounded_step(flat, value, best.precision, gradient, damping);
      const Eigen::VectorXd tried = within_bounds(flat, value + step);
      if ((tried - value).cwiseAbs2().dot(best.precision.diagonal()) < 1e-14) break;
      const Evaluation then = evaluate(tried, nullptr);
      if (then.cost() <= now.cost()) {
        gained = now.cost() - then.cost();
        value = tried;
        now = then;
        improved = true;
        damping = std::max(1e-9, damping * 0.1);
      } else if (!derivatives_are_here) {
        break;
      } else {
        damping *= 10;
      }
    }
    const bool settled = !improved || gained < settled_gain;
    if (settled && derivatives_are_here) break;
    // Old derivatives will do while they still carry far: near a minimum most models are straight.
    const bool carries = derivatives_are_here && improved && gained < carried_gain;
    if (carries) {
      derivatives_are_here = false;
      continue;
    }
    now = evaluate(value, &jacobian);
    take_derivatives();
    derivatives_are_here = true;
  }
  if (!derivatives_are_here) {
    now = evaluate(value, &jacobian);
    take_derivatives();
  }
  best.prior_precision = weight;
  const Eigen::VectorXd gradient = gradient_of(now);
  for (Eigen::Index i = 0; i < value.size(); ++i)
    if (best.precision(i, i) > 0 && !pushes_outwards(flat, value, gradient, i))
      best.free.push_back(i);
  best.jacobian = std::move(jacobian);
  best.mean = std::move(now.mean);
  best.residual = std::move(now.residual);
  best.chi2 = now.chi2;
  best.penalty = now.penalty;
  return best;
}

}  // namespace umov::gap
