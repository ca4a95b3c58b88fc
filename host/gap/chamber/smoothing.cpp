#include "host/gap/chamber/smoothing.hpp"

#include <array>
#include <cmath>

#include <Eigen/Dense>

namespace umov::gap {
namespace {

/// Half an octave apart. At 0 nothing is smoothed.
constexpr std::array widths{0.0, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0};

Eigen::MatrixXd plane_fits(const std::vector<double>& x, const std::vector<double>& y,
                           double width) {
  const auto count = static_cast<Eigen::Index>(x.size());
  if (width == 0.0) return Eigen::MatrixXd::Identity(count, count);
  Eigen::MatrixXd smooth(count, count);
  Eigen::Matrix3Xd terms(3, count);
  Eigen::VectorXd weights(count);
  for (Eigen::Index at = 0; at < count; ++at) {
    const auto here = static_cast<std::size_t>(at);
    for (Eigen::Index i = 0; i < count; ++i) {
      const double dx = x[static_cast<std::size_t>(i)] - x[here];
      const double dy = y[static_cast<std::size_t>(i)] - y[here];
      terms.col(i) = Eigen::Vector3d(1.0, dx, dy);
      weights[i] = std::exp(-0.5 * (dx * dx + dy * dy) / (width * width));
    }
    const Eigen::Matrix3Xd weighted = terms * weights.asDiagonal();
    const Eigen::Matrix3d normal = weighted * terms.transpose();
    // The height of the plane at its middle. A pixel without neighbours keeps its value.
    const Eigen::Vector3d height =
        normal.completeOrthogonalDecomposition().solve(Eigen::Vector3d(1.0, 0.0, 0.0));
    smooth.row(at) = height.transpose() * weighted;
  }
  return smooth;
}

}  // namespace

Smoothing::Smoothing(const std::vector<double>& x, const std::vector<double>& y) {
  for (const double width : widths) smooth_.push_back(plane_fits(x, y, width));
}

std::size_t Smoothing::choose(const Eigen::VectorXd& one, const Eigen::VectorXd& other) const {
  std::size_t best = 0;
  double least = 0.0;
  for (std::size_t i = 0; i < smooth_.size(); ++i) {
    const double missed =
        (smooth_[i] * one - other).squaredNorm() + (smooth_[i] * other - one).squaredNorm();
    if (i > 0 && !(missed < least)) continue;
    least = missed;
    best = i;
  }
  return best;
}

Eigen::VectorXd Smoothing::mean(const Eigen::VectorXd& one, const Eigen::VectorXd& other) const {
  return smooth_[choose(one, other)] * (0.5 * (one + other));
}

double Smoothing::width(const Eigen::VectorXd& one, const Eigen::VectorXd& other) const {
  return widths[choose(one, other)];
}

}  // namespace umov::gap
