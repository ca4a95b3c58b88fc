#include "host/invert/box_quadratic.hpp"

#include <Eigen/Dense>
#include <vector>

namespace umov::invert {
namespace {

/// Newton step of the free coordinates. Units of each coordinate's own curvature keep the
/// factorisation sound; what has none does not move.
Eigen::VectorXd newton_step(const Eigen::MatrixXd& block, const Eigen::VectorXd& slope) {
  const Eigen::VectorXd curvature = block.diagonal();
  Eigen::VectorXd unit(curvature.size());
  for (Eigen::Index i = 0; i < unit.size(); ++i) {
    unit[i] = curvature[i] > 0 ? 1 / std::sqrt(curvature[i]) : 0;
  }
  Eigen::MatrixXd scaled = unit.asDiagonal() * block * unit.asDiagonal();
  scaled.diagonal().array() += 1e-14;
  for (Eigen::Index i = 0; i < unit.size(); ++i) {
    if (unit[i] == 0) scaled(i, i) = 1;
  }
  const Eigen::VectorXd pull = unit.cwiseProduct(slope);
  return -unit.cwiseProduct(scaled.ldlt().solve(pull));
}

}  // namespace

Eigen::VectorXd minimum_in_box(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                               const Eigen::VectorXd& lo, const Eigen::VectorXd& hi,
                               const Eigen::VectorXd& start) {
  const Eigen::Index n = b.size();
  Eigen::VectorXd p = start.cwiseMax(lo).cwiseMin(hi);
  std::vector<int> held(static_cast<std::size_t>(n));  // −1 at its lower limit, +1 at its upper one
  const auto side = [&](Eigen::Index i) -> int& { return held[static_cast<std::size_t>(i)]; };
  for (Eigen::Index i = 0; i < n; ++i) side(i) = p[i] <= lo[i] ? -1 : p[i] >= hi[i] ? 1 : 0;
  const int most_steps = 20 * static_cast<int>(n) + 20;
  for (int step = 0; step < most_steps; ++step) {
    const Eigen::VectorXd slope = a * p + b;
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (side(i) == 0) free.push_back(i);
    }
    double length = 1;
    Eigen::Index blocking = -1;
    if (!free.empty()) {
      const Eigen::VectorXd move = newton_step(a(free, free), slope(free));
      for (std::size_t k = 0; k < free.size(); ++k) {
        const Eigen::Index i = free[k];
        const double d = move[static_cast<Eigen::Index>(k)];
        const double room = d > 0 ? hi[i] - p[i] : lo[i] - p[i];
        if (d != 0 && room / d < length) {
          length = room / d;
          blocking = i;
        }
      }
      for (std::size_t k = 0; k < free.size(); ++k) {
        p[free[k]] += length * move[static_cast<Eigen::Index>(k)];
      }
    }
    if (blocking >= 0) {
      const bool upper =
          std::abs(p[blocking] - hi[blocking]) < std::abs(p[blocking] - lo[blocking]);
      p[blocking] = upper ? hi[blocking] : lo[blocking];
      side(blocking) = upper ? 1 : -1;
      continue;
    }
    const Eigen::VectorXd there = a * p + b;
    Eigen::Index release = -1;
    double worst = 1e-9;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (side(i) == 0 || !(a(i, i) > 0)) continue;
      // By how much the quadratic would fall if this coordinate alone were let go, in its own unit.
      const double inward = there[i] * side(i) / std::sqrt(a(i, i));
      if (inward > worst) {
        worst = inward;
        release = i;
      }
    }
    if (release < 0) break;
    side(release) = 0;
  }
  return p;
}

}  // namespace umov::invert
