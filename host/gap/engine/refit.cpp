#include "host/gap/engine/refit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "host/errors/error.hpp"
#include "host/gap/engine/orthonormal.hpp"

namespace umov::gap {
namespace {

/// Parameters of an explanation in one vector, with what is known of each.
struct Flat {
  std::vector<const Parameter*> parameter;
  Eigen::VectorXd value;
  std::vector<bool> held;  ///< must not move
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
  flat.held.assign(values.size(), false);
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

/// Step of the damped normal equations within the bounds: parameters at a bound that it would push
/// outwards are held, those that it would take across one go up to it, and the others are solved
/// for with these in place. Cut off one by one, a step of parameters that make up for each other
/// would lead uphill.
Eigen::VectorXd bounded_step(const Flat& flat, const Eigen::VectorXd& value,
                             const Eigen::MatrixXd& precision, const Eigen::VectorXd& gradient,
                             double damping) {
  const Eigen::Index n = value.size();
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!flat.held[static_cast<std::size_t>(i)] && !pushes_outwards(flat, value, gradient, i) &&
        precision(i, i) > 0)
      free.push_back(i);
  }
  Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
  while (!free.empty()) {
    // Scaled by the diagonal: parameters differ by ten orders of magnitude.
    const Eigen::VectorXd scale = precision(free, free).diagonal().cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd scaled = scale.asDiagonal() * precision(free, free) * scale.asDiagonal();
    scaled.diagonal().array() += damping + 1e-12;
    step(free).setZero();
    const Eigen::VectorXd left = gradient - precision * step;
    step(free) = scale.cwiseProduct(scaled.ldlt().solve(scale.cwiseProduct(left(free))));
    std::vector<Eigen::Index> inside;
    for (const Eigen::Index i : free) {
      const Parameter& p = *flat.parameter[static_cast<std::size_t>(i)];
      if (value[i] + step[i] >= p.lo && value[i] + step[i] <= p.hi) {
        inside.push_back(i);
      } else {
        step[i] = std::clamp(value[i] + step[i], p.lo, p.hi) - value[i];
      }
    }
    if (inside.size() == free.size()) break;
    free = std::move(inside);
  }
  return step;
}

/// Decrease of χ², in units of χ² per observation where that is above one, below which a fit is
/// settled, and below which a step's derivatives serve again.
constexpr double settled_gain = 1e-2, carried_gain = 1.0;

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

namespace {

/// For every parameter of an explanation, which one of another's it is; -1 where it has none.
std::vector<Eigen::Index> places_in(const Explanation& of, const Explanation& in) {
  std::vector<Eigen::Index> places(of.base.size());
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = static_cast<Eigen::Index>(i);
  for (std::size_t k = 0; k < of.effects.size(); ++k) {
    auto next = static_cast<Eigen::Index>(in.base.size());
    bool found = false;
    for (std::size_t j = 0; j < in.effects.size() && !found; ++j) {
      found = in.effects[j] == of.effects[k];
      if (!found) next += static_cast<Eigen::Index>(in.alpha[j].size());
    }
    for (std::size_t i = 0; i < of.alpha[k].size(); ++i) places.push_back(found ? next++ : -1);
  }
  return places;
}

}  // namespace

Refit refit(const ForwardModel& model, const Explanation& start, const Whitening& whitening,
            int max_iterations, const Refit* near, const std::vector<Eigen::Index>& held) {
  Refit best;
  best.explanation = start;
  Flat flat = flatten(model, start);
  for (const Eigen::Index i : held) flat.held[static_cast<std::size_t>(i)] = true;
  const Eigen::VectorXd weight = prior_weight(flat);
  const Eigen::VectorXd& observed = model.observations().value;

  const auto evaluate = [&](const Eigen::VectorXd& value, Eigen::MatrixXd* jacobian,
                            const std::vector<bool>& wanted = {}) {
    unflatten(value, best.explanation);
    Evaluation e;
    model.predict(best.explanation, e.mean, jacobian, wanted);
    // Where a parameter has no derivative (a root at its end, say) it stays for this step.
    if (jacobian != nullptr)
      for (Eigen::Index i = 0; i < jacobian->cols(); ++i)
        if (!jacobian->col(i).allFinite()) jacobian->col(i).setZero();
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
  best.own_derivatives = near == nullptr;
  std::vector<Eigen::Index> known;
  std::vector<bool> wanted;
  if (near != nullptr) {
    known = places_in(start, near->explanation);
    for (const Eigen::Index place : known) wanted.push_back(place < 0);
  }
  Eigen::MatrixXd fresh_columns;
  Evaluation now = evaluate(value, &fresh_columns, wanted);
  Eigen::MatrixXd jacobian(observed.size(), value.size());
  // What is borrowed stays as it is: only columns that are new are differentiated and multiplied.
  std::vector<Eigen::Index> lent, lent_from, own;
  for (Eigen::Index i = 0; i < value.size(); ++i) {
    if (near != nullptr && known[static_cast<std::size_t>(i)] >= 0) {
      lent.push_back(i);
      lent_from.push_back(known[static_cast<std::size_t>(i)]);
    } else {
      own.push_back(i);
    }
  }
  Eigen::MatrixXd lent_precision;
  if (near != nullptr) {
    jacobian(Eigen::all, lent) = near->jacobian(Eigen::all, lent_from);
    lent_precision = near->precision(lent_from, lent_from);
    lent_precision.diagonal() -= near->prior_precision(lent_from);
  }
  const auto take_derivatives = [&](Eigen::MatrixXd& fresh) {
    best.precision = Eigen::MatrixXd::Zero(value.size(), value.size());
    if (near == nullptr) {
      jacobian = whitening.apply(fresh);
      best.precision.selfadjointView<Eigen::Lower>().rankUpdate(jacobian.transpose());
      best.precision = Eigen::MatrixXd(best.precision.selfadjointView<Eigen::Lower>());
    } else {
      best.precision(lent, lent) = lent_precision;
      if (!own.empty()) {
        const Eigen::MatrixXd columns = whitening.apply(Eigen::MatrixXd(fresh(Eigen::all, own)));
        jacobian(Eigen::all, own) = columns;
        const Eigen::MatrixXd products = jacobian.transpose() * columns;
        best.precision(Eigen::all, own) = products;
        best.precision(own, Eigen::all) = products.transpose();
      }
    }
    best.precision.diagonal() += weight;
  };
  const auto gradient_of = [&](const Evaluation& e) -> Eigen::VectorXd {
    return jacobian.transpose() * e.residual - weight.cwiseProduct(from_prior(flat, value));
  };
  take_derivatives(fresh_columns);
  // Derivatives of a step ago serve again where they lead downhill fast enough.
  bool fresh = true;
  double damping = 1e-4;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const Eigen::VectorXd gradient = gradient_of(now);
    const double unit = std::max(1.0, now.chi2 / static_cast<double>(observed.size()));
    bool improved = false;
    double gained = 0;
    const int attempts = !fresh ? 1 : near == nullptr ? 12 : 4;
    for (int attempt = 0; attempt < attempts && !improved; ++attempt) {
      const Eigen::VectorXd step = bounded_step(flat, value, best.precision, gradient, damping);
      const Eigen::VectorXd tried = within_bounds(flat, value + step);
      if ((tried - value).dot(gradient) < 0.1 * settled_gain * unit) break;
      const Evaluation then = evaluate(tried, nullptr);
      if (then.cost() <= now.cost()) {
        gained = now.cost() - then.cost();
        value = tried;
        now = then;
        improved = true;
        damping = std::max(1e-9, damping * 0.1);
      } else {
        damping *= 10;
      }
    }
    const double enough = (near == nullptr ? 1.0 : 10.0) * settled_gain * unit;
    const bool settled = !improved || gained < enough;
    if (settled && fresh) break;
    // Near a minimum most models are straight.
    if (fresh && improved && gained < carried_gain * unit) {
      fresh = false;
      continue;
    }
    now = evaluate(value, &fresh_columns, wanted);
    take_derivatives(fresh_columns);
    fresh = true;
  }
  if (!fresh) {
    now = evaluate(value, &fresh_columns, wanted);
    take_derivatives(fresh_columns);
  }
  best.prior_precision = weight;
  const Eigen::VectorXd gradient = gradient_of(now);
  // At a bound a parameter rests, unless the next step would take it away.
  const Eigen::VectorXd next = bounded_step(flat, value, best.precision, gradient, 1e-9);
  for (Eigen::Index i = 0; i < value.size(); ++i) {
    const Parameter& p = *flat.parameter[static_cast<std::size_t>(i)];
    const bool rests = flat.held[static_cast<std::size_t>(i)] ||
                       (next[i] == 0 && (value[i] <= p.lo || value[i] >= p.hi));
    if (best.precision(i, i) > 0 && !rests) best.free.push_back(i);
  }
  best.jacobian = std::move(jacobian);
  best.mean = std::move(now.mean);
  best.residual = std::move(now.residual);
  best.chi2 = now.chi2;
  best.penalty = now.penalty;
  return best;
}

double worth_by_curvature(const ForwardModel& model, const Refit& fit, std::size_t place) {
  const Effect& effect = model.effects()[fit.explanation.effects[place]];
  auto number = static_cast<Eigen::Index>(fit.explanation.base.size());
  for (std::size_t k = 0; k < place; ++k)
    number += static_cast<Eigen::Index>(fit.explanation.alpha[k].size());
  std::vector<Eigen::Index> sizes;
  std::vector<double> away;
  for (std::size_t i = 0; i < effect.parameters.size(); ++i, ++number) {
    const Parameter& p = effect.parameters[i];
    if (p.shape || p.choice || !(fit.precision(number, number) > 0)) continue;
    sizes.push_back(number);
    away.push_back(fit.explanation.alpha[place][i] - p.absent);
  }
  if (sizes.empty()) return 0;
  std::vector<Eigen::Index> others;
  for (const Eigen::Index i : fit.free)
    if (std::find(sizes.begin(), sizes.end(), i) == sizes.end()) others.push_back(i);
  Eigen::MatrixXd left = fit.precision(sizes, sizes);
  if (!others.empty()) {
    const Eigen::VectorXd scale =
        fit.precision(others, others).diagonal().cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd scaled =
        scale.asDiagonal() * fit.precision(others, others) * scale.asDiagonal();
    scaled.diagonal().array() += 1e-10;
    const Eigen::MatrixXd across = scale.asDiagonal() * fit.precision(others, sizes);
    left -= across.transpose() * scaled.ldlt().solve(across);
  }
  const Eigen::Map<const Eigen::VectorXd> step(away.data(), static_cast<Eigen::Index>(away.size()));
  return std::max(0.0, step.dot(left * step));
}

Eigen::MatrixXd followed_directions(const Refit& fit) {
  const Eigen::Index n = fit.residual.size();
  const auto fitted = static_cast<Eigen::Index>(fit.free.size());
  Eigen::MatrixXd basis(n + fitted, fitted);
  basis.topRows(n) = fit.jacobian(Eigen::all, fit.free);
  basis.bottomRows(fitted) =
      Eigen::MatrixXd(fit.prior_precision(fit.free).cwiseSqrt().asDiagonal());
  for (Eigen::Index i = 0; i < fitted; ++i) basis.col(i).normalize();
  return orthonormal(basis);
}

Eigen::VectorXd standard_errors(const Eigen::MatrixXd& precision) {
  const Eigen::VectorXd scale = precision.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd scaled = scale.asDiagonal() * precision * scale.asDiagonal();
  for (Eigen::Index i = 0; i < scaled.rows(); ++i)
    if (!(precision(i, i) > 0)) scaled(i, i) = 1;
  scaled.diagonal().array() += 1e-10;
  const Eigen::MatrixXd inverse =
      scaled.ldlt().solve(Eigen::MatrixXd::Identity(scaled.rows(), scaled.cols()));
  Eigen::VectorXd errors(scaled.rows());
  for (Eigen::Index i = 0; i < errors.size(); ++i)
    errors[i] = precision(i, i) > 0 ? std::sqrt(std::max(0.0, inverse(i, i))) * scale[i] : 0.0;
  return errors;
}

}  // namespace umov::gap
