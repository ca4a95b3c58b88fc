#include "host/gap/engine/hollow.hpp"

#include <algorithm>
#include <vector>

#include <Eigen/Cholesky>

namespace umov::gap {

std::set<std::size_t> not_needed_beside(const ForwardModel& model, const Refit& fit,
                                        const Eigen::MatrixXd& varying, double needed) {
  std::set<std::size_t> hollow;
  if (varying.size() == 0) return hollow;
  // An effect that is absent has no shape: shapes stay, else a valley along which size and shape
  // make up for each other would pass for doubt.
  std::vector<Eigen::Index> sizes = fit.free;
  auto shape = static_cast<Eigen::Index>(fit.explanation.base.size());
  for (const std::size_t e : fit.explanation.effects)
    for (const Parameter& p : model.effects()[e].parameters) {
      if (p.shape) std::erase(sizes, shape);
      ++shape;
    }
  const auto fitted = static_cast<Eigen::Index>(sizes.size());
  Eigen::MatrixXd columns(fit.residual.size(), fitted + varying.cols());
  columns.leftCols(fitted) = fit.jacobian(Eigen::all, sizes);
  columns.rightCols(varying.cols()) = varying;
  Eigen::MatrixXd matrix = columns.transpose() * columns;
  matrix.diagonal().head(fitted) += fit.prior_precision(sizes);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(matrix.rows());
  right.tail(varying.cols()) = varying.transpose() * fit.residual;
  const Eigen::VectorXd unit = matrix.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd scaled = unit.asDiagonal() * matrix * unit.asDiagonal();
  scaled.diagonal().array() += 1e-12;
  const Eigen::LDLT<Eigen::MatrixXd> factor(scaled);
  const Eigen::VectorXd step = unit.cwiseProduct(factor.solve(unit.cwiseProduct(right)));
  const Eigen::MatrixXd covariance =
      unit.asDiagonal() * factor.solve(Eigen::MatrixXd::Identity(scaled.rows(), scaled.rows())) *
      unit.asDiagonal();
  auto next = static_cast<Eigen::Index>(fit.explanation.base.size());
  for (std::size_t k = 0; k < fit.explanation.effects.size(); ++k) {
    const Effect& effect = model.effects()[fit.explanation.effects[k]];
    bool stays = effect.structural;
    for (std::size_t i = 0; i < effect.parameters.size(); ++i, ++next) {
      const Parameter& p = effect.parameters[i];
      if (p.shape || p.choice) continue;
      const auto place = std::find(sizes.begin(), sizes.end(), next);
      if (place == sizes.end()) continue;
      const auto column = place - sizes.begin();
      const double away = fit.explanation.alpha[k][i] + step[column] - p.absent;
      stays = stays || away * away > needed * covariance(column, column);
    }
    if (!stays) hollow.insert(fit.explanation.effects[k]);
  }
  return hollow;
}

}  // namespace umov::gap
