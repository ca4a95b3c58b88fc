#include "host/invert/normal_equations.hpp"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace umov::invert {

namespace {

/// A factor that acts at few points, such as the place where a drive stopped: its column of the
/// derivatives and where that is not zero.
struct SparseColumn {
  Eigen::Index place = 0;  ///< among all coordinates
  Eigen::Index factor = 0;
  std::vector<Eigen::Index> rows;
};

/// Adds the squares and products of one wavelength's derivatives. Only parameters of this
/// wavelength and the factors that act at it have columns here.
void add(const Problem& problem, std::size_t w, const SpectrumResiduals& part,
         NormalEquations& out) {
  const Layout& layout = problem.layout;
  const auto free = static_cast<Eigen::Index>(layout.size());
  const auto& common = problem.data.spectra[w].common;
  std::vector<Eigen::Index> at;
  for (const int parameter : layout.active(w)) {
    at.push_back(static_cast<Eigen::Index>(*layout.slot(w, static_cast<std::size_t>(parameter))));
  }
  const Eigen::Index own = part.by_x.cols();
  std::vector<Eigen::Index> dense;
  std::vector<SparseColumn> sparse;
  for (Eigen::Index k = 0; k < part.by_c.cols(); ++k) {
    const auto& per_point = common[static_cast<std::size_t>(k)].per_point;
    if (per_point.empty()) continue;
    SparseColumn column{free + k, k, {}};
    for (std::size_t i = 0; i < per_point.size(); ++i) {
      if (per_point[i] != 0) column.rows.push_back(static_cast<Eigen::Index>(i));
    }
    if (4 * column.rows.size() < per_point.size()) {
      sparse.push_back(std::move(column));
    } else {
      dense.push_back(k);
      at.push_back(free + k);
    }
  }
  Eigen::MatrixXd columns(part.r.size(), own + static_cast<Eigen::Index>(dense.size()));
  columns.leftCols(own) = part.by_x;
  for (std::size_t k = 0; k < dense.size(); ++k) {
    columns.col(own + static_cast<Eigen::Index>(k)) = part.by_c.col(dense[k]);
  }
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
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
  const auto add_product = [&out](Eigen::Index i, Eigen::Index j, double value) {
    out.curvature(i, j) += value;
    if (i != j) out.curvature(j, i) += value;
  };
  for (std::size_t s = 0; s < sparse.size(); ++s) {
    const SparseColumn& column = sparse[s];
    const auto entry = part.by_c.col(column.factor);
    for (const Eigen::Index row : column.rows)
      out.gradient[column.place] += entry[row] * part.r[row];
    for (std::size_t k = 0; k < at.size(); ++k) {
      double sum = 0;
      for (const Eigen::Index row : column.rows)
        sum += entry[row] * columns(row, static_cast<Eigen::Index>(k));
      add_product(column.place, at[k], sum);
    }
    for (std::size_t t = 0; t <= s; ++t) {
      double sum = 0;
      for (const Eigen::Index row : column.rows)
        sum += entry[row] * part.by_c(row, sparse[t].factor);
      add_product(column.place, sparse[t].place, sum);
    }
  }
}

}  // namespace

NormalEquations normal_equations(const Problem& problem, std::span<const double> x,
                                 std::span<const double> c) {
  const Layout& layout = problem.layout;
  const auto free = static_cast<Eigen::Index>(layout.size());
  const auto size = free + static_cast<Eigen::Index>(c.size());
  NormalEquations out;
  out.gradient.setZero(size);
  out.curvature.setZero(size, size);
  for (std::size_t w = 0; w < problem.data.spectra.size(); ++w) {
    const SpectrumResiduals part =
        residuals(layout, problem.data, w, x, c, problem.weighting, true);
    if (!part.r.allFinite() || !part.by_x.allFinite()) {
      out.finite = false;
      return out;
    }
    out.objective += part.r.squaredNorm();
    add(problem, w, part, out);
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
