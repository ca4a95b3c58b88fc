#include "host/gap/engine/noise.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace umov::gap {

Whitening::Whitening(NoiseShape shape, RelativeNoise relative, double scale)
    : shape_(std::move(shape)), relative_(relative), white_sigma_(scale * shape_.sigma) {
  const double fresh_or_fixed = std::hypot(relative_.white, relative_.pattern);
  if (fresh_or_fixed > 0 && shape_.relative.size() > 0)
    white_sigma_ =
        (white_sigma_.cwiseAbs2() + (fresh_or_fixed * shape_.relative).cwiseAbs2()).cwiseSqrt();
  std::vector<bool> filtered(static_cast<std::size_t>(white_sigma_.size()), false);
  if (relative_.slow > 0 && shape_.relative.size() > 0) {
    const double variance = relative_.slow * relative_.slow;
    const double fresh = variance * (1 - relative_.memory * relative_.memory);
    double predicted = variance;
    for (const Eigen::Index i : shape_.order) {
      filtered[static_cast<std::size_t>(i)] = true;
      const double s = shape_.relative[i];
      const double innovation = s * s * predicted + white_sigma_[i] * white_sigma_[i];
      gain_.push_back(predicted * s / innovation);
      inverse_.push_back(1.0 / std::sqrt(innovation));
      ln_determinant_ += 0.5 * std::log(innovation);
      const double left = predicted * (1 - gain_.back() * s);
      predicted = relative_.memory * relative_.memory * left + fresh;
    }
  }
  for (Eigen::Index i = 0; i < white_sigma_.size(); ++i)
    if (!filtered[static_cast<std::size_t>(i)]) ln_determinant_ += std::log(white_sigma_[i]);
  if (relative_.pattern > 0 && shape_.relative.size() > 0) follow_places();
}

void Whitening::follow_places() {
  Eigen::VectorXd inverse = white_sigma_.cwiseInverse();
  for (std::size_t k = 0; k < inverse_.size(); ++k) inverse[shape_.order[k]] = inverse_[k];
  for (const std::vector<Eigen::Index>& list : shape_.same_place) {
    double known = 1;  // variance of the place's pattern, in its own unit
    for (const Eigen::Index i : list) {
      const double share = relative_.pattern * shape_.relative[i] * inverse[i];
      const double variance = share * share * known + 1 - share * share;
      const double gain = known * share / variance;
      again_.push_back({i, share, gain, 1 / std::sqrt(variance), i == list.front()});
      ln_determinant_ += 0.5 * std::log(variance);
      known *= 1 - gain * share;
    }
  }
}

Eigen::MatrixXd Whitening::apply(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd white = white_sigma_.cwiseInverse().asDiagonal() * columns;
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    double state = 0;
    for (std::size_t k = 0; k < gain_.size(); ++k) {
      const Eigen::Index i = shape_.order[k];
      const double innovation = columns(i, c) - shape_.relative[i] * state;
      white(i, c) = innovation * inverse_[k];
      state = relative_.memory * (state + gain_[k] * innovation);
    }
    for (const Again& a : again_) {
      if (a.first) state = 0;
      const double innovation = white(a.observation, c) - a.share * state;
      white(a.observation, c) = innovation * a.inverse;
      state += a.gain * innovation;
    }
  }
  return white;
}

double misfit(const NoiseShape& shape, const Eigen::VectorXd& residual, const Eigen::VectorXd& kept,
              const RelativeNoise& noise, double scale) {
  const Whitening whitening(shape, noise, scale);
  return 2 * whitening.ln_determinant() +
         whitening.apply(residual.cwiseQuotient(kept.cwiseSqrt())).squaredNorm();
}

namespace {

/// Least gain of twice the log-likelihood for which a noise is believed: its size and memory are
/// looked for over a wide range.
constexpr double least_gain = 8;

}  // namespace

RelativeNoise learn_relative_noise(const NoiseShape& shape, const Eigen::VectorXd& residual,
                                   const Eigen::VectorXd& kept, double scale) {
  if (shape.relative.size() == 0 || shape.order.size() < 20) return {};
  const auto cost = [&](const RelativeNoise& n) { return misfit(shape, residual, kept, n, scale); };
  RelativeNoise best;
  double least = cost(best);
  const auto consider = [&](const RelativeNoise& n, double price) {
    const double value = cost(n) + price;
    if (value >= least) return false;
    least = value;
    best = n;
    return true;
  };
  /// Steps in the logarithms of sizes and of the forgetting 1 - φ.
  const auto polish = [&](double price) {
    double step = 0.5;
    for (int round = 0; round < 24 && step > 0.01; ++round) {
      bool moved = false;
      for (int which = 0; which < 3; ++which) {
        for (const double sign : {1.0, -1.0}) {
          RelativeNoise n = best;
          if (which == 0) n.white *= std::exp(sign * step);
          if (which == 1) n.slow *= std::exp(sign * step);
          if (which == 2) n.memory = 1 - (1 - n.memory) * std::exp(sign * step);
          const bool same = (which == 0 && !(n.white > 0)) || (which != 0 && !(n.slow > 0));
          if (same || n.memory < 0 || n.memory > 0.9999) continue;
          if (consider(n, price)) {
            moved = true;
            break;
          }
        }
      }
      if (!moved) step *= 0.5;
    }
  };
  for (const double size : {3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2})
    consider({size, 0, 0}, least_gain / 2);
  if (best.white > 0) polish(least_gain / 2);
  // A slow part beside or instead of the white one: a grid first, for the likelihood may have two
  // maxima (fast and slow).
  const RelativeNoise white = best;
  for (const double size : {3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2})
    for (const double memory : {0.3, 0.6, 0.9, 0.98, 0.997})
      for (const double beside : {white.white, 0.5 * white.white, 0.0})
        consider({beside, size, memory}, 1.5 * least_gain);
  if (best.slow > 0) polish(1.5 * least_gain);
  // Where places repeat they tell what is fixed to them from what is new each time.
  if (best.white > 0 && !shape.same_place.empty()) {
    const RelativeNoise fresh = best;
    const double price = best.slow > 0 ? 1.5 * least_gain : least_gain / 2;
    for (const double share : {0.2, 0.4, 0.6, 0.8, 1.0}) {
      RelativeNoise n = fresh;
      n.pattern = std::sqrt(share) * fresh.white;
      n.white = std::sqrt(1 - share) * fresh.white;
      consider(n, price);
    }
  }
  return best;
}

}  // namespace umov::gap
