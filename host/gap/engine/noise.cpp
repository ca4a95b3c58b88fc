#include "host/gap/engine/noise.hpp"

#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

namespace umov::gap {

Whitening::Whitening(NoiseShape shape, SlowNoise slow, double scale)
    : shape_(std::move(shape)), slow_(slow), scale_(scale) {
  std::vector<bool> filtered(static_cast<std::size_t>(shape_.sigma.size()), false);
  if (slow_.size > 0 && shape_.slow.size() > 0) {
    const double variance = slow_.size * slow_.size;
    const double fresh = variance * (1 - slow_.memory * slow_.memory);
    double predicted = variance;
    for (const Eigen::Index i : shape_.order) {
      filtered[static_cast<std::size_t>(i)] = true;
      const double s = shape_.slow[i];
      const double sigma = scale_ * shape_.sigma[i];
      const double innovation = s * s * predicted + sigma * sigma;
      gain_.push_back(predicted * s / innovation);
      inverse_.push_back(1.0 / std::sqrt(innovation));
      ln_determinant_ += 0.5 * std::log(innovation);
      const double left = predicted * (1 - gain_.back() * s);
      predicted = slow_.memory * slow_.memory * left + fresh;
    }
  }
  for (Eigen::Index i = 0; i < shape_.sigma.size(); ++i)
    if (!filtered[static_cast<std::size_t>(i)])
      ln_determinant_ += std::log(scale_ * shape_.sigma[i]);
}

Eigen::MatrixXd Whitening::apply(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd white = (scale_ * shape_.sigma).cwiseInverse().asDiagonal() * columns;
  if (gain_.empty()) return white;
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    double state = 0;
    for (std::size_t k = 0; k < gain_.size(); ++k) {
      const Eigen::Index i = shape_.order[k];
      const double innovation = columns(i, c) - shape_.slow[i] * state;
      white(i, c) = innovation * inverse_[k];
      state = slow_.memory * (state + gain_[k] * innovation);
    }
  }
  return white;
}

namespace {

/// Twice the negative restricted log-likelihood, up to a constant.
double misfit(const NoiseShape& shape, const Eigen::VectorXd& residual,
              const Eigen::MatrixXd& columns, const SlowNoise& slow, double scale) {
  const Whitening whitening(shape, slow, scale);
  const Eigen::VectorXd r = whitening.apply(residual);
  double value = 2 * whitening.ln_determinant() + r.squaredNorm();
  if (columns.cols() > 0) {
    const Eigen::MatrixXd a = whitening.apply(columns);
    Eigen::MatrixXd normal = a.transpose() * a;
    // Columns that repeat each other take one degree of freedom.
    const Eigen::VectorXd size = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    normal = size.asDiagonal() * normal * size.asDiagonal();
    normal.diagonal().array() += 1e-8;
    const Eigen::LDLT<Eigen::MatrixXd> factor(normal);
    const Eigen::VectorXd right = size.cwiseProduct(a.transpose() * r);
    value -= right.dot(factor.solve(right));
    value +=
        factor.vectorD().cwiseAbs().array().max(1e-300).log().sum() - 2 * size.array().log().sum();
  }
  return value;
}

}  // namespace

SlowNoise learn_slow_noise(const NoiseShape& shape, const Eigen::VectorXd& residual,
                           const Eigen::MatrixXd& columns, double scale) {
  if (shape.slow.size() == 0 || shape.order.size() < 20) return {};
  const double none = misfit(shape, residual, columns, {}, scale);
  SlowNoise best;
  double least = none;
  // A grid first: the likelihood may have two maxima (fast and slow), then a pattern search.
  for (const double size : {3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2}) {
    for (const double memory : {0.0, 0.6, 0.9, 0.98, 0.997}) {
      const double value = misfit(shape, residual, columns, {size, memory}, scale);
      if (value < least) {
        least = value;
        best = {size, memory};
      }
    }
  }
  if (!(best.size > 0)) return {};
  double step_size = 0.55, step_memory = 0.55;
  for (int round = 0; round < 14; ++round) {
    bool moved = false;
    for (const auto& [ds, dm] : {std::pair{step_size, 0.0}, std::pair{-step_size, 0.0},
                                 std::pair{0.0, step_memory}, std::pair{0.0, -step_memory}}) {
      // Steps in ln size and in ln of the forgetting 1 - φ.
      SlowNoise tried{best.size * std::exp(ds), 1 - (1 - best.memory) * std::exp(dm)};
      if (tried.memory < 0 || tried.memory > 0.9999) continue;
      const double value = misfit(shape, residual, columns, tried, scale);
      if (value < least) {
        least = value;
        best = tried;
        moved = true;
      }
    }
    if (!moved) {
      step_size *= 0.5;
      step_memory *= 0.5;
    }
  }
  return none - least > 6 ? best : SlowNoise{};
}

}  // namespace umov::gap
