#include "host/gap/chamber/smoothing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace umov::gap {
namespace {

struct Field {
  std::vector<double> x, y;
  Eigen::VectorXd smooth, sharp;

  Field() {
    for (int j = 0; j < 20; ++j) {
      for (int i = 0; i < 24; ++i) {
        if (std::hypot(i - 11.5, 1.2 * (j - 9.5)) > 11.8) continue;
        x.push_back(i);
        y.push_back(j);
      }
    }
    smooth.resize(static_cast<Eigen::Index>(x.size()));
    sharp.resize(smooth.size());
    for (Eigen::Index k = 0; k < smooth.size(); ++k) {
      const auto at = static_cast<std::size_t>(k);
      smooth[k] = 1.0 + 0.1 * x[at] + std::exp(-std::pow((y[at] - 8.0) / 6.0, 2));
      sharp[k] = (static_cast<int>(x[at]) + static_cast<int>(y[at])) % 2 == 0 ? 1.0 : -1.0;
    }
  }
  Eigen::VectorXd noise(double sigma, unsigned seed) const {
    std::mt19937 generator(seed);
    std::normal_distribution<double> normal(0.0, sigma);
    Eigen::VectorXd n(smooth.size());
    for (double& one : n) one = normal(generator);
    return n;
  }
};

TEST(Smoothing, TakesTheNoiseOutOfWhatIsSmoothAndLeavesWhatIsSharp) {
  const Field field;
  const Smoothing smoothing(field.x, field.y);
  const Eigen::VectorXd one = field.smooth + field.noise(0.3, 1);
  const Eigen::VectorXd other = field.smooth + field.noise(0.3, 2);
  const double before = (0.5 * (one + other) - field.smooth).norm();
  EXPECT_LT((smoothing.mean(one, other) - field.smooth).norm(), 0.4 * before);
  EXPECT_GT(smoothing.width(one, other), 1.0);

  const Eigen::VectorXd board = field.sharp + field.noise(0.3, 3);
  const Eigen::VectorXd again = field.sharp + field.noise(0.3, 4);
  EXPECT_EQ(smoothing.width(board, again), 0.0);
  EXPECT_EQ(smoothing.mean(board, again), 0.5 * (board + again));
}

TEST(Smoothing, KeepsAPlaneUpToTheRim) {
  const Field field;
  const Smoothing smoothing(field.x, field.y);
  Eigen::VectorXd plane(field.smooth.size());
  for (Eigen::Index k = 0; k < plane.size(); ++k) {
    const auto at = static_cast<std::size_t>(k);
    plane[k] = 2.0 - 0.3 * field.x[at] + 0.2 * field.y[at];
  }
  // Noise of opposite signs: widths are chosen, and the mean is the plane again.
  const Eigen::VectorXd noise = field.noise(1.0, 5);
  EXPECT_GT(smoothing.width(plane + noise, plane - noise), 1.0);
  EXPECT_LT((smoothing.mean(plane + noise, plane - noise) - plane).cwiseAbs().maxCoeff(), 1e-9);
}

}  // namespace
}  // namespace umov::gap
