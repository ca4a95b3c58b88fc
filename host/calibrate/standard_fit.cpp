#include "host/calibrate/standard_fit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <Eigen/Dense>

#include "host/calibrate/instrument_function.hpp"
#include "host/errors/error.hpp"
#include "host/formats/order_statistics.hpp"

namespace umov::calibrate {

namespace {

/// The model at all rows: its signal and the derivatives of its logarithm.
class Evaluator {
 public:
  Evaluator(const std::vector<StandardRow>& rows, const StandardModel& model, Eigen::Index count)
      : rows_(rows), model_(model) {
    const auto n = static_cast<Eigen::Index>(rows.size());
    signal_v = Eigen::VectorXd(n);
    log_gradient = Eigen::MatrixXd::Zero(n, count);
    log_gradient.col(0).setOnes();
    for (Eigen::Index i = 0; i < n; ++i)
      for (std::size_t k = 0; k < model.degrees.size(); ++k)
        log_gradient(i, static_cast<Eigen::Index>(k) + 1) = instrument_basis(
            model.degrees[k], rows[static_cast<std::size_t>(i)].theta_r_deg, model.reference_deg);
  }

  void at(const Eigen::VectorXd& parameters) {
    const auto linear = static_cast<Eigen::Index>(model_.degrees.size()) + 1;
    const Eigen::VectorXd log_signal = log_gradient.leftCols(linear) * parameters.head(linear);
    for (Eigen::Index i = 0; i < signal_v.size(); ++i) {
      const StandardRow& row = rows_[static_cast<std::size_t>(i)];
      double factor = 1.0;
      Eigen::Index column = linear;
      const auto lever = [&](double weight) {
        const double f = std::max(0.05, 1.0 + parameters(column) * weight);
        factor *= f;
        log_gradient(i, column++) = weight / f;
      };
      if (model_.bias) lever(row.bias_lever);
      if (model_.retention_u > 0) lever(row.retention_lever);
      if (model_.polarization_u > 0) lever(row.bias_lever);
      signal_v(i) = std::exp(log_signal(i)) * row.base * factor;
    }
  }

  Eigen::VectorXd signal_v;
  Eigen::MatrixXd log_gradient;

 private:
  const std::vector<StandardRow>& rows_;
  const StandardModel& model_;
};

std::optional<StandardFit> try_fit(const std::vector<StandardRow>& rows,
                                   const StandardModel& model) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  const Eigen::Index first_lever = 1 + static_cast<Eigen::Index>(model.degrees.size());
  const Eigen::Index m = first_lever + model.levers();
  Eigen::VectorXd prior_mean = Eigen::VectorXd::Zero(m), prior_weight = Eigen::VectorXd::Zero(m);
  const auto weight = [](double u) { return u > 0 ? 1.0 / (u * u) : 0.0; };
  Eigen::Index lever = first_lever, priors = 0;
  if (model.bias) {
    prior_mean(lever) = model.bias_prior;
    prior_weight(lever++) = weight(model.bias_prior_u);
  }
  if (model.retention_u > 0) prior_weight(lever++) = weight(model.retention_u);
  if (model.polarization_u > 0) prior_weight(lever++) = weight(model.polarization_u);
  for (Eigen::Index k = 0; k < m; ++k) priors += prior_weight(k) > 0 ? 1 : 0;
  if (n + priors < m) return std::nullopt;
  StandardFit fit;
  fit.model = model;
  fit.parameters = Eigen::VectorXd::Zero(m);
  std::vector<double> ratio;
  for (const StandardRow& row : rows) ratio.push_back(row.signal_v / row.base);
  const double start = formats::median(ratio);
  if (!(start > 0)) return std::nullopt;
  fit.parameters(0) = std::log(start);

  Eigen::MatrixXd jacobian(n, m), normal(m, m), inverse(m, m);
  Eigen::VectorXd residual(n);
  Evaluator evaluator(rows, model, m);
  const auto linearise = [&] {
    evaluator.at(fit.parameters);
    for (Eigen::Index i = 0; i < n; ++i) {
      const StandardRow& row = rows[static_cast<std::size_t>(i)];
      const double sd = std::sqrt(row.variance);
      residual(i) = (row.signal_v - evaluator.signal_v(i)) / sd;
      jacobian.row(i) = evaluator.signal_v(i) / sd * evaluator.log_gradient.row(i);
    }
    normal = jacobian.transpose() * jacobian;
    normal.diagonal() += prior_weight;
  };
  for (int iteration = 0; iteration < 30; ++iteration) {
    linearise();
    // Equilibrated, so that the rank test does not depend on units.
    const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt();
    if (!(scale.minCoeff() > 0)) return std::nullopt;
    const Eigen::VectorXd unit = scale.cwiseInverse();
    const Eigen::FullPivLU<Eigen::MatrixXd> lu(unit.asDiagonal() * normal * unit.asDiagonal());
    if (lu.rcond() < 1e-12) return std::nullopt;
    inverse = unit.asDiagonal() * lu.inverse() * unit.asDiagonal();
    const Eigen::VectorXd gradient =
        jacobian.transpose() * residual - prior_weight.cwiseProduct(fit.parameters - prior_mean);
    const Eigen::VectorXd step = inverse * gradient;
    fit.parameters += step;
    if (step.cwiseAbs().maxCoeff() < 1e-10) break;
  }
  linearise();
  if (!fit.parameters.allFinite()) return std::nullopt;
  fit.chi2 = residual.squaredNorm();
  fit.dof = static_cast<double>(n - m + priors);
  const double widening = fit.dof > 0 ? std::max(1.0, fit.chi2 / fit.dof) : 1.0;
  fit.covariance = widening * inverse;
  fit.response = inverse * jacobian.transpose();
  fit.pull.resize(rows.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const double sd = std::sqrt(rows[static_cast<std::size_t>(i)].variance);
    fit.response.col(i) /= sd;
    fit.pull[static_cast<std::size_t>(i)] = residual(i);
  }
  return fit;
}

/// Mean of fits with weights exp(-score/2), in the union of their parameters.
StandardFit average(const std::vector<StandardFit>& fits, const std::vector<double>& score) {
  const double best = *std::min_element(score.begin(), score.end());
  std::vector<double> weight;
  double sum = 0;
  for (double s : score) {
    // Orders below 2 % of the best are dropped: each would bring parameters for next to nothing.
    weight.push_back(s - best < 8.0 ? std::exp(-0.5 * (s - best)) : 0.0);
    sum += weight.back();
  }
  std::set<int> degrees;
  for (std::size_t k = 0; k < fits.size(); ++k)
    if (weight[k] > 0) degrees.insert(fits[k].model.degrees.begin(), fits[k].model.degrees.end());

  StandardFit mean;
  mean.model = fits.front().model;
  mean.model.degrees.assign(degrees.begin(), degrees.end());
  const Eigen::Index tail = fits.front().parameters.size() - 1 -
                            static_cast<Eigen::Index>(fits.front().model.degrees.size());
  const auto wide = static_cast<Eigen::Index>(degrees.size());
  const Eigen::Index m = 1 + wide + tail, n = fits.front().response.cols();
  mean.parameters = Eigen::VectorXd::Zero(m);
  mean.covariance = Eigen::MatrixXd::Zero(m, m);
  mean.response = Eigen::MatrixXd::Zero(m, n);
  mean.pull.assign(static_cast<std::size_t>(n), 0.0);
  std::vector<Eigen::VectorXd> parameters(fits.size());
  for (std::size_t k = 0; k < fits.size(); ++k) {
    if (weight[k] == 0) continue;
    const double w = weight[k] / sum;
    const StandardFit& fit = fits[k];
    std::vector<Eigen::Index> place = {0};
    for (int degree : fit.model.degrees)
      place.push_back(1 + std::distance(degrees.begin(), degrees.find(degree)));
    for (Eigen::Index t = 0; t < tail; ++t) place.push_back(1 + wide + t);
    parameters[k] = Eigen::VectorXd::Zero(m);
    for (std::size_t a = 0; a < place.size(); ++a) {
      const auto row = static_cast<Eigen::Index>(a);
      parameters[k](place[a]) = fit.parameters(row);
      mean.response.row(place[a]) += w * fit.response.row(row);
      for (std::size_t b = 0; b < place.size(); ++b)
        mean.covariance(place[a], place[b]) +=
            w * fit.covariance(row, static_cast<Eigen::Index>(b));
    }
    mean.parameters += w * parameters[k];
    for (std::size_t i = 0; i < mean.pull.size(); ++i) mean.pull[i] += w * fit.pull[i];
    mean.dof += w * fit.dof;
  }
  for (std::size_t k = 0; k < fits.size(); ++k) {
    if (weight[k] == 0) continue;
    const Eigen::VectorXd apart = parameters[k] - mean.parameters;
    mean.covariance += weight[k] / sum * apart * apart.transpose();
  }
  for (double pull : mean.pull) mean.chi2 += pull * pull;
  return mean;
}

}  // namespace

double remove_gross(std::vector<StandardRow>& rows) {
  constexpr double neighbourhood_deg = 12;
  constexpr double retro_deg = 10;
  std::vector<StandardRow> kept;
  double dark = -1;
  for (const StandardRow& row : rows) {
    std::vector<double> near;
    for (const StandardRow& other : rows)
      if (std::abs(other.theta_r_deg - row.theta_r_deg) <= neighbourhood_deg)
        near.push_back(other.signal_v / other.base);
    const double relative = row.signal_v / row.base / formats::median(near);
    if (relative > 0.5 && relative < 2.0)
      kept.push_back(row);
    else if (relative <= 0.5 && row.from_retro_deg < retro_deg)
      dark = std::max(dark, row.from_retro_deg);
  }
  rows = std::move(kept);
  if (dark < 0) return 0;
  double good = retro_deg;
  for (const StandardRow& row : rows)
    if (row.from_retro_deg > dark) good = std::min(good, row.from_retro_deg);
  return good;
}

StandardFit fit_standard(const std::vector<StandardRow>& rows, const StandardModel& model) {
  if (auto fit = try_fit(rows, model)) return *std::move(fit);
  throw Error("the standard's records do not determine the gain",
              "give a scan of a white standard with positive signals at several exit angles");
}

StandardFit choose_instrument_function(const std::vector<StandardRow>& rows, StandardModel model,
                                       int max_degree, bool two_sided) {
  std::set<long long> angles;
  for (const StandardRow& row : rows)
    angles.insert(std::llround((two_sided ? row.theta_r_deg : std::abs(row.theta_r_deg)) * 100.0));
  // A polynomial through a third of the nodes at most: it must not follow single angles.
  const int limit = std::min(max_degree, static_cast<int>(angles.size() / 3) * (two_sided ? 1 : 2));
  std::vector<std::vector<int>> candidates = {{}};
  for (int top = 1; top <= limit; ++top) {
    std::vector<int> full, even;
    for (int k = 1; k <= top; ++k) {
      full.push_back(k);
      if (k % 2 == 0) even.push_back(k);
    }
    if (two_sided) candidates.push_back(full);
    if (top % 2 == 0) candidates.push_back(even);
  }
  std::vector<StandardFit> fits;
  for (const auto& degrees : candidates) {
    model.degrees = degrees;
    if (auto fit = try_fit(rows, model)) fits.push_back(*std::move(fit));
  }
  if (fits.empty()) {
    model.degrees.clear();
    return fit_standard(rows, model);
  }
  double least = -1;
  for (const StandardFit& fit : fits)
    if (fit.dof > 0 && (least < 0 || fit.chi2 / fit.dof < least)) least = fit.chi2 / fit.dof;
  const double scatter = std::max(1.0, least);
  const double others = std::max(1.0, static_cast<double>(fits.size()) - 1.0);
  std::vector<double> score;
  for (const StandardFit& fit : fits) {
    const double terms = static_cast<double>(fit.model.degrees.size());
    score.push_back(fit.chi2 / scatter + terms * std::log(static_cast<double>(rows.size())) +
                    (terms > 0 ? 2.0 * std::log(others) : 0.0));
  }
  return average(fits, score);
}

}  // namespace umov::calibrate
