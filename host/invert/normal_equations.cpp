#include "host/invert/normal_equations.hpp"

#include <cmath>
#include <limits>
#include <vector>

namespace umov::invert {

NormalEquations normal_equations(const Problem& problem, std::span<const double> x,
                                 std::span<const double> c) {
  const Layout& layout = problem.layout;
  const auto free = static_cast<Eigen::Index>(layout.size());
  const auto size = free + static_cast<Eigen::Index>(c.size());
  NormalEquations out;
  out.gradient.setZero(size);
  out.curvature.setZero(size, size);
  Eigen::MatrixXd columns, block;
  for (std::size_t w = 0; w < problem.data.spectra.size(); ++w) {
    const SpectrumResiduals part =
        residuals(layout, problem.data, w, x, c, problem.weighting, true);
    if (!part.r.allFinite() || !part.by_x.allFinite()) {
      out.finite = false;
      return out;
    }
    out.objective += part.r.squaredNorm();
    // Only parameters of this wavelength and the factors that act at it have columns here.
    std::vector<Eigen::Index> at;
    for (const int parameter : layout.active(w)) {
      at.push_back(static_cast<Eigen::Index>(*layout.slot(w, static_cast<std::size_t>(parameter))));
    }
    const Eigen::Index own = part.by_x.cols();
    std::vector<Eigen::Index> factors;
    for (std::size_t k = 0; k < c.size(); ++k) {
      if (problem.data.spectra[w].common[k].per_point.empty()) continue;
      factors.push_back(static_cast<Eigen::Index>(k));
      at.push_back(free + static_cast<Eigen::Index>(k));
    }
    columns.resize(part.r.size(), own + static_cast<Eigen::Index>(factors.size()));
    columns.leftCols(own) = part.by_x;
    for (std::size_t k = 0; k < factors.size(); ++k) {
      columns.col(own + static_cast<Eigen::Index>(k)) = part.by_c.col(factors[k]);
    }
    block.setZero(columns.cols(), columns.cols());
    block.selfadjointView<Eigen::Lower>().rankUpdate(columns.transpose());
    block.triangularView<Eigen::StrictlyUpper>() = block.transpose();
    const Eigen::VectorXd pull = columns.transpose() * part.r;
    for (std::size_t i = 0; i < at.size(); ++i) {
      out.gradient[at[i]] += pull[static_cast<Eigen::Index>(i)];
      for (std::size_t j = 0; j < at.size(); ++j) {
        out.curvature(at[i], at[j]) +=
            block(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      }
    }
  }
  for (std::size_t k = 0; k < c.size(); ++k) {
    const Eigen::Index i = free + static_cast<Eigen::Index>(k);
    out.objective += c[k] * c[k];
    out.gradient[i] += c[k];
    out.curvature(i, i) += 1;
  }
  if (!problem.priors.empty()) {
    const Priors::Rows prior = problem.priors.rows(x);
    out.objective += prior.r.squaredNorm();
    out.gradient.head(free) += prior.by_x.transpose() * prior.r;
    out.curvature.topLeftCorner(free, free) += prior.by_x.transpose() * prior.by_x;
  }
  out.finite = std::isfinite(out.objective);
  return out;
}

double objective_at(const Problem& problem, std::span<const double> x, std::span<const double> c) {
  double sum = 0;
  for (std::size_t w = 0; w < problem.data.spectra.size(); ++w) {
    sum +=
        residuals(problem.layout, problem.data, w, x, c, problem.weighting, false).r.squaredNorm();
  }
  for (const double value : c) sum += value * value;
  if (!problem.priors.empty()) sum += problem.priors.objective(x);
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

}  // namespace umov::invert
