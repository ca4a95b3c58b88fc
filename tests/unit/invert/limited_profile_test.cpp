#include "host/invert/limited_profile.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

namespace umov::invert {
namespace {

constexpr double rise_95 = 3.841458820694124;
constexpr double far_away = 1e9;

Eigen::MatrixXd correlated(double rho) {
  return (Eigen::Matrix2d() << 1, rho, rho, 1).finished();
}

TEST(LimitedProfile, a_limit_far_away_matters_to_nobody) {
  const LimitedProfile profile(correlated(0.5), Eigen::Vector2d::Zero(),
                               Eigen::Vector2d::Constant(-far_away),
                               Eigen::Vector2d::Constant(far_away));
  EXPECT_FALSE(profile.limited());
}

TEST(LimitedProfile, a_quantity_apart_from_the_limited_parameter_keeps_its_plain_interval) {
  const LimitedProfile profile(correlated(0.0), Eigen::Vector2d(0, -1),
                               Eigen::Vector2d(-far_away, 0), Eigen::Vector2d(far_away, far_away));
  ASSERT_TRUE(profile.limited());
  EXPECT_NEAR(profile.extreme(Eigen::Vector2d(1, 0), +1, rise_95), std::sqrt(rise_95), 1e-6);
  EXPECT_NEAR(profile.extreme(Eigen::Vector2d(1, 0), -1, rise_95), -std::sqrt(rise_95), 1e-6);
}

// The definition itself on a fine grid: largest a·x with chi² at most `rise` above its least value.
double extreme_on_grid(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& centre,
                       const Eigen::Vector3d& lo, const Eigen::Vector3d& gradient) {
  const Eigen::Matrix3d precision = covariance.inverse();
  const auto chi2 = [&](const Eigen::Vector3d& x) {
    return (x - centre).dot(precision * (x - centre));
  };
  constexpr int n = 160;
  double least = 1e300;
  for (int pass = 0;; ++pass) {
    double best = -1e300;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) {
          const Eigen::Vector3d t(i / (n - 1.0), j / (n - 1.0), k / (n - 1.0));
          const Eigen::Vector3d x(-5 + 10 * t[0], lo[1] + (5 - lo[1]) * t[1],
                                  lo[2] + (5 - lo[2]) * t[2]);
          const double c = chi2(x);
          if (pass == 0)
            least = std::min(least, c);
          else if (c <= least + rise_95)
            best = std::max(best, gradient.dot(x));
        }
      }
    }
    if (pass == 1) return best;
  }
}

TEST(LimitedProfile, agrees_with_a_search_of_the_whole_box) {
  const Eigen::Matrix3d covariance =
      (Eigen::Matrix3d() << 1, 0.8, -0.3, 0.8, 1.5, 0.2, -0.3, 0.2, 0.7).finished();
  const Eigen::Vector3d centre(0.2, -0.8, 0.4), lo(-far_away, -0.1, 0.0),
      hi = Eigen::Vector3d::Constant(far_away);
  const LimitedProfile profile(covariance, centre, lo, hi);
  for (const Eigen::Vector3d& gradient :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1, -1, 0.5)}) {
    EXPECT_NEAR(profile.extreme(gradient, +1, rise_95),
                extreme_on_grid(covariance, centre, lo, gradient), 0.08);
    EXPECT_NEAR(profile.extreme(gradient, -1, rise_95),
                -extreme_on_grid(covariance, centre, lo, -gradient), 0.08);
  }
}

TEST(LimitedProfile, covers_on_a_limit_near_it_and_away_from_it) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  constexpr double rho = 0.95;
  for (const double truth : {0.0, 0.5, 1.0, 3.0}) {
    int covered = 0;
    constexpr int trials = 4000;
    for (int trial = 0; trial < trials; ++trial) {
      // Unlimited estimates of (quantity, limited parameter) whose truth is (0, truth), limit 0.
      const double u = normal(random), v = normal(random);
      const double theta = u, k = truth + rho * u + std::sqrt(1 - rho * rho) * v;
      const double k_hat = std::max(k, 0.0), theta_hat = k >= 0 ? theta : theta - rho * k;
      const LimitedProfile profile(correlated(rho), Eigen::Vector2d(theta - theta_hat, k - k_hat),
                                   Eigen::Vector2d(-far_away, -k_hat),
                                   Eigen::Vector2d(far_away, far_away));
      const double lo = profile.limited() ? profile.extreme(Eigen::Vector2d(1, 0), -1, rise_95)
                                          : -std::sqrt(rise_95);
      const double hi = profile.limited() ? profile.extreme(Eigen::Vector2d(1, 0), +1, rise_95)
                                          : std::sqrt(rise_95);
      covered += theta_hat + lo <= 0 && theta_hat + hi >= 0 ? 1 : 0;
    }
    const double share = static_cast<double>(covered) / trials;
    EXPECT_GT(share, 0.935) << truth;
    EXPECT_LT(share, 0.98) << truth;
  }
}

}  // namespace
}  // namespace umov::invert
