#include "host/invert/minimise.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/invert/box_quadratic.hpp"
#include "host/invert/normal_equations.hpp"

namespace umov::invert {
namespace {

constexpr double unlimited = 1e300;
/// Damping is relative to each coordinate's curvature.
constexpr double least_damping = 1e-7;
/// Below it a step is the undamped one in all but the flattest valleys.
constexpr double settled_damping = 1e-4;
/// A coordinate whose whole range matters less than this many times the mean square of a residual
/// is idle: the shape of a term with next to no weight. Weight times shape is not what a quadratic
/// can describe, so idle coordinates are damped on their own and do not hold up the others.
constexpr double idle_matter = 100;
constexpr double first_idle_damping = 1;
constexpr double most_idle_damping = 1e6;

/// A coordinate within this share of its range from a limit counts as on it, and starts go no
/// nearer.
constexpr double limit_share = 1e-6;

/// (P12) over z in (−∞, ∞) with x = lo + (hi − lo)/(1 + e^−z).
class PaperObjective final : public ceres::FirstOrderFunction {
 public:
  PaperObjective(const Layout& layout, const Observations& data) : layout_(layout), data_(data) {}

  int NumParameters() const override { return static_cast<int>(layout_.size()); }

  std::vector<double> to_x(const double* z) const {
    std::vector<double> x(layout_.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Coordinate& k = layout_.free()[i].coordinate;
      x[i] = k.lo_x() + (k.hi_x() - k.lo_x()) / (1 + std::exp(-z[i]));
    }
    return x;
  }

  std::vector<double> to_z(std::span<const double> x) const {
    std::vector<double> z(layout_.size());
    for (std::size_t i = 0; i < z.size(); ++i) {
      const Coordinate& k = layout_.free()[i].coordinate;
      // A start on a limit would have a vanishing gradient.
      const double share =
          std::clamp((x[i] - k.lo_x()) / (k.hi_x() - k.lo_x()), limit_share, 1 - limit_share);
      z[i] = std::log(share / (1 - share));
    }
    return z;
  }

  bool Evaluate(const double* z, double* cost, double* gradient) const override {
    const std::vector<double> x = to_x(z);
    const Weighting relative{.relative = true};
    const double share = 1.0 / static_cast<double>(data_.spectra.size());
    *cost = 0;
    if (gradient != nullptr) std::fill_n(gradient, layout_.size(), 0.0);
    for (std::size_t w = 0; w < data_.spectra.size(); ++w) {
      const SpectrumResiduals part =
          residuals(layout_, data_, w, x, {}, relative, gradient != nullptr);
      *cost += share * part.r.squaredNorm();
      if (gradient == nullptr) continue;
      const Eigen::VectorXd slope = 2 * share * part.by_x.transpose() * part.r;
      const auto& active = layout_.active(w);
      for (std::size_t a = 0; a < active.size(); ++a) {
        const std::size_t i = *layout_.slot(w, static_cast<std::size_t>(active[a]));
        const Coordinate& k = layout_.free()[i].coordinate;
        const double s = 1 / (1 + std::exp(-z[i]));
        gradient[i] += slope[static_cast<Eigen::Index>(a)] * (k.hi_x() - k.lo_x()) * s * (1 - s);
      }
    }
    return std::isfinite(*cost);
  }

 private:
  const Layout& layout_;
  const Observations& data_;
};

}  // namespace

Solution least_squares(const Problem& problem, std::vector<double> x, std::vector<double> c,
                       const std::vector<bool>& linear, const Stop& stop) {
  const Layout& layout = problem.layout;
  const auto free = static_cast<Eigen::Index>(layout.size());
  const auto size = free + static_cast<Eigen::Index>(c.size());
  Eigen::VectorXd lo = Eigen::VectorXd::Constant(size, -unlimited);
  Eigen::VectorXd hi = Eigen::VectorXd::Constant(size, unlimited);
  Eigen::VectorXd here(size);
  std::vector<bool> damped(static_cast<std::size_t>(size), false);
  for (Eigen::Index i = 0; i < free; ++i) {
    const FreeParameter& parameter = layout.free()[static_cast<std::size_t>(i)];
    lo[i] = parameter.coordinate.lo_x();
    hi[i] = parameter.coordinate.hi_x();
    here[i] = std::clamp(x[static_cast<std::size_t>(i)], lo[i], hi[i]);
    damped[static_cast<std::size_t>(i)] = linear.empty() || !linear[parameter.parameter];
  }
  for (Eigen::Index i = free; i < size; ++i) here[i] = c[static_cast<std::size_t>(i - free)];
  const auto part = [&](const Eigen::VectorXd& z, Eigen::Index first, Eigen::Index count) {
    return std::span<const double>(z.data() + first, static_cast<std::size_t>(count));
  };
  const auto evaluate = [&](const Eigen::VectorXd& z) {
    return normal_equations(problem, part(z, 0, free), part(z, free, size - free));
  };

  Solution out;
  NormalEquations at = evaluate(here);
  out.iterations = 1;
  double damping = stop.first_damping, growth = 2, idle_damping = first_idle_damping;
  // Data without noise have no objective left at their optimum that a share could be taken of.
  const auto points = static_cast<double>(problem.data.size());
  const double nothing = 1e-12 * points;
  while (at.finite && out.iterations < stop.max_iterations) {
    const double tolerance = stop.function_tolerance * std::max(at.objective, nothing);
    const double unit = std::max(at.objective, nothing) / points;
    Eigen::MatrixXd curvature = at.curvature;
    std::vector<Eigen::Index> idle;
    for (Eigen::Index i = 0; i < free; ++i) {
      if (!damped[static_cast<std::size_t>(i)]) continue;
      const double least = unit / ((hi[i] - lo[i]) * (hi[i] - lo[i]));
      if (at.curvature(i, i) < idle_matter * least) {
        curvature(i, i) += idle_damping * std::max(at.curvature(i, i), least);
        idle.push_back(i);
      } else {
        curvature(i, i) += damping * at.curvature(i, i);
      }
    }
    // In terms of the step, lest the position's digits drown a small one.
    const Eigen::VectorXd step =
        minimum_in_box(curvature, at.gradient, lo - here, hi - here, Eigen::VectorXd::Zero(size));
    const Eigen::VectorXd there = (here + step).cwiseMax(lo).cwiseMin(hi);
    const double foretold = -(2 * at.gradient + at.curvature * step).dot(step);
    if (!(foretold > 0.1 * tolerance)) {
      // With little damping there is nothing left to gain; with much the step was only short.
      if (damping <= settled_damping) {
        out.converged = true;
        break;
      }
      damping = std::max(damping * 0.1, settled_damping);
      if (!(foretold > 0)) continue;
    }
    NormalEquations next = evaluate(there);
    ++out.iterations;
    const double gain = next.finite ? at.objective - next.objective : -1;
    if (gain > 0) {
      const double ratio = gain / foretold;
      damping *= std::max(1.0 / 5, 1 - std::pow(2 * ratio - 1, 3));
      idle_damping = std::max(idle_damping * 0.2, settled_damping);
      growth = 2;
      const bool small = gain <= tolerance;
      here = there;
      at = std::move(next);
      if (small && damping <= settled_damping) {
        out.converged = true;
        break;
      }
      if (small) damping = std::max(damping * 0.1, 0.5 * settled_damping);
    } else {
      // Rounding decides at the bottom of a flat valley.
      if (next.finite && foretold <= tolerance) {
        out.converged = true;
        break;
      }
      const bool idle_moved = std::any_of(idle.begin(), idle.end(), [&](Eigen::Index i) {
        return std::abs(step[i]) > 1e-3 * (hi[i] - lo[i]);
      });
      if (idle_moved && idle_damping < most_idle_damping) {
        idle_damping *= 30;
        continue;
      }
      damping = std::max(damping, least_damping) * growth;
      growth *= 2;
      if (damping > 1e16) break;
    }
  }
  out.objective = at.finite ? at.objective : std::numeric_limits<double>::infinity();
  out.x.assign(here.data(), here.data() + free);
  out.c.assign(here.data() + free, here.data() + size);
  return out;
}

bool exceeds_noise(double scale, std::size_t points, std::size_t free_parameters) {
  const double dof = points > free_parameters ? static_cast<double>(points - free_parameters) : 1;
  return scale * scale > 1 + 4 * std::sqrt(2 / dof);
}

double measured_scale(const Layout& layout, const Observations& data, const Solution& solution,
                      double huber_sigma) {
  Eigen::VectorXd r(static_cast<Eigen::Index>(data.size()));
  Eigen::Index first = 0;
  for (std::size_t w = 0; w < data.spectra.size(); ++w) {
    const SpectrumResiduals part = residuals(layout, data, w, solution.x, solution.c, {}, false);
    r.segment(first, part.r.size()) = part.r;
    first += part.r.size();
  }
  if (!r.allFinite()) return std::numeric_limits<double>::infinity();
  return residual_scale(r, huber_sigma, layout.size());
}

RobustSolution robust_least_squares(const Layout& layout, const Observations& data,
                                    const Priors& priors, std::vector<double> x,
                                    std::vector<double> c, const std::vector<bool>& linear,
                                    double huber_sigma, int max_iterations) {
  RobustSolution out;
  out.solution.x = std::move(x);
  out.solution.c = std::move(c);
  const auto scale_now = [&] {
    const double s = measured_scale(layout, data, out.solution, huber_sigma);
    return std::isfinite(s) && exceeds_noise(s, data.size(), layout.size()) ? s : 1.0;
  };
  // Short fits while the scale still falls, then one to the end.
  int left = max_iterations;
  double used = scale_now();
  for (int round = 0; round < 12 && left > 0; ++round) {
    const int steps = std::min(left, 8);
    Solution next =
        least_squares({layout, data, priors, {.scale = used, .huber_sigma = huber_sigma}},
                      out.solution.x, out.solution.c, linear, {.max_iterations = steps});
    left -= next.iterations;
    next.iterations += out.solution.iterations;
    out.solution = std::move(next);
    const double s = scale_now();
    const bool settled = std::abs(s - used) <= 0.01 * used;
    out.scale = used;
    if (settled && out.solution.converged) return out;
    used = settled ? used : s;
    if (settled) break;
  }
  Solution last =
      least_squares({layout, data, priors, {.scale = used, .huber_sigma = huber_sigma}},
                    out.solution.x, out.solution.c, linear, {.max_iterations = std::max(left, 20)});
  last.iterations += out.solution.iterations;
  out.solution = std::move(last);
  out.scale = scale_now();
  return out;
}

Solution paper_bfgs(const Layout& layout, const Observations& data, std::vector<double> x,
                    int max_iterations) {
  auto* objective = new PaperObjective(layout, data);
  const ceres::GradientProblem problem(objective);  // owns it
  std::vector<double> z = objective->to_z(x);
  ceres::GradientProblemSolver::Options options;
  options.line_search_direction_type = ceres::BFGS;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = 1e-12;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(options, problem, z.data(), &summary);
  Solution out;
  out.x = objective->to_x(z.data());
  // The logistic only tends to its limits: what has come this close is there.
  for (std::size_t i = 0; i < out.x.size(); ++i) {
    const Coordinate& k = layout.free()[i].coordinate;
    const double share = (out.x[i] - k.lo_x()) / (k.hi_x() - k.lo_x());
    if (share < limit_share) out.x[i] = k.lo_x();
    if (share > 1 - limit_share) out.x[i] = k.hi_x();
  }
  for (std::size_t w = 0; w < data.spectra.size(); ++w) {
    out.objective +=
        residuals(layout, data, w, out.x, {}, {.relative = true}, false).r.squaredNorm() /
        static_cast<double>(data.spectra.size());
  }
  out.iterations = static_cast<int>(summary.iterations.size());
  out.converged = summary.termination_type == ceres::CONVERGENCE;
  return out;
}

}  // namespace umov::invert
