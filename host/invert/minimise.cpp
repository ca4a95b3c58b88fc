#include "host/invert/minimise.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>

namespace umov::invert {
namespace {

/// Residuals of one wavelength. Parameter blocks: one of size 1 for each active parameter, then,
/// where there are factors, one of them all.
class SpectrumCost final : public ceres::CostFunction {
 public:
  SpectrumCost(const Layout& layout, const Observations& data, std::size_t wavelength,
               std::size_t factors, const Weighting& weighting)
      : layout_(layout),
        data_(data),
        wavelength_(wavelength),
        factors_(factors),
        weighting_(weighting) {
    for (std::size_t a = 0; a < layout.active(wavelength).size(); ++a) {
      mutable_parameter_block_sizes()->push_back(1);
    }
    if (factors > 0) mutable_parameter_block_sizes()->push_back(static_cast<int>(factors));
    set_num_residuals(static_cast<int>(data.spectra[wavelength].points.size()));
  }

  bool Evaluate(double const* const* blocks, double* out, double** jacobians) const override {
    const auto& active = layout_.active(wavelength_);
    std::vector<double> x(layout_.size(), 0.0);
    for (std::size_t a = 0; a < active.size(); ++a) {
      x[*layout_.slot(wavelength_, static_cast<std::size_t>(active[a]))] = blocks[a][0];
    }
    const std::span<const double> c(factors_ > 0 ? blocks[active.size()] : nullptr, factors_);
    const SpectrumResiduals part =
        residuals(layout_, data_, wavelength_, x, c, weighting_, jacobians != nullptr);
    const Eigen::Index points = part.r.size();
    Eigen::Map<Eigen::VectorXd>(out, points) = part.r;
    if (!part.r.allFinite()) return false;
    if (jacobians == nullptr) return true;
    if (!part.by_x.allFinite()) return false;
    for (std::size_t a = 0; a < active.size(); ++a) {
      if (jacobians[a] == nullptr) continue;
      Eigen::Map<Eigen::VectorXd>(jacobians[a], points) =
          part.by_x.col(static_cast<Eigen::Index>(a));
    }
    if (factors_ > 0 && jacobians[active.size()] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          jacobians[active.size()], points, static_cast<Eigen::Index>(factors_)) = part.by_c;
    }
    return true;
  }

 private:
  const Layout& layout_;
  const Observations& data_;
  std::size_t wavelength_;
  std::size_t factors_;
  Weighting weighting_;
};

/// The factors' unit normal prior.
class UnitPrior final : public ceres::CostFunction {
 public:
  explicit UnitPrior(int size) : size_(size) {
    mutable_parameter_block_sizes()->push_back(size);
    set_num_residuals(size);
  }
  bool Evaluate(double const* const* blocks, double* out, double** jacobians) const override {
    std::copy_n(blocks[0], size_, out);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      std::fill_n(jacobians[0], size_ * size_, 0.0);
      for (int i = 0; i < size_; ++i) jacobians[0][i * size_ + i] = 1;
    }
    return true;
  }

 private:
  int size_;
};

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

bool touches_limit(const Layout& layout, const std::vector<double>& x) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Coordinate& k = layout.free()[i].coordinate;
    if (x[i] <= k.lo_x() || x[i] >= k.hi_x()) return true;
  }
  return false;
}

}  // namespace

Solution least_squares(const Layout& layout, const Observations& data, std::vector<double> x,
                       std::vector<double> c, const Weighting& weighting, int max_iterations) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Coordinate& k = layout.free()[i].coordinate;
    x[i] = std::clamp(x[i], k.lo_x(), k.hi_x());
  }
  ceres::Problem problem;
  for (std::size_t w = 0; w < data.spectra.size(); ++w) {
    std::vector<double*> blocks;
    for (const int parameter : layout.active(w)) {
      blocks.push_back(&x[*layout.slot(w, static_cast<std::size_t>(parameter))]);
    }
    if (!c.empty()) blocks.push_back(c.data());
    if (blocks.empty() || data.spectra[w].points.empty()) continue;
    problem.AddResidualBlock(new SpectrumCost(layout, data, w, c.size(), weighting), nullptr,
                             blocks);
  }
  if (!c.empty()) {
    problem.AddResidualBlock(new UnitPrior(static_cast<int>(c.size())), nullptr, c.data());
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!problem.HasParameterBlock(&x[i])) continue;
    const Coordinate& k = layout.free()[i].coordinate;
    problem.SetParameterLowerBound(&x[i], 0, k.lo_x());
    problem.SetParameterUpperBound(&x[i], 0, k.hi_x());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.function_tolerance = 1e-9;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-9;
  options.num_threads = 1;

  // The solver only projects its steps onto the limits: with one in force the projected step need
  // not descend, and it stops short. So parameters that press against a limit are held there while
  // the others move, and let go when the gradient turns.
  Solution out;
  std::vector<bool> held(x.size(), false);
  std::vector<int> releases(x.size(), 0);
  for (int left = max_iterations; left > 0;) {
    bool changed = false;
    if (touches_limit(layout, x)) {
      const Linearisation at = linearise(layout, data, x, c, weighting);
      const Eigen::VectorXd gradient = at.by_x.transpose() * at.r;
      for (std::size_t i = 0; i < x.size(); ++i) {
        const Coordinate& k = layout.free()[i].coordinate;
        const double slope = gradient[static_cast<Eigen::Index>(i)];
        const bool presses = (x[i] <= k.lo_x() && slope > 0) || (x[i] >= k.hi_x() && slope < 0);
        if (presses == held[i] || (held[i] && releases[i] >= 3)) continue;
        if (held[i]) ++releases[i];
        held[i] = presses;
        changed = true;
        if (presses) {
          problem.SetParameterBlockConstant(&x[i]);
        } else {
          problem.SetParameterBlockVariable(&x[i]);
        }
      }
    }
    if (out.converged && !changed) break;
    options.max_num_iterations = std::min(left, 12);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    out.objective = 2 * summary.final_cost;
    out.converged = summary.termination_type == ceres::CONVERGENCE;
    const int steps = std::max(1, static_cast<int>(summary.iterations.size()) - 1);
    out.iterations += steps;
    left -= steps;
    if (summary.termination_type == ceres::FAILURE) break;
  }
  out.x = std::move(x);
  out.c = std::move(c);
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
                                    std::vector<double> x, std::vector<double> c,
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
    Solution next = least_squares(layout, data, out.solution.x, out.solution.c,
                                  {.scale = used, .huber_sigma = huber_sigma}, steps);
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
  Solution last = least_squares(layout, data, out.solution.x, out.solution.c,
                                {.scale = used, .huber_sigma = huber_sigma}, std::max(left, 20));
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
