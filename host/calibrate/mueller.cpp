#include "host/calibrate/mueller.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "host/calibrate/polarization.hpp"
#include "host/optics/realisability.hpp"

namespace umov::calibrate {

namespace {

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Design = Eigen::Matrix<double, Eigen::Dynamic, 9>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double unphysical_z = -3;
constexpr double negligible = 1e-9;  ///< singular values and null-space parts, relative

using Key = std::array<long long, 4>;

std::map<Key, std::vector<std::size_t>> by_direction(const formats::BrdfTable::Points& p) {
  std::map<Key, std::vector<std::size_t>> groups;
  const auto rounded = [](double v) { return std::llround(v * 1e4); };
  for (std::size_t i = 0; i < p.size(); ++i)
    if (p.used[i] != 0 && p.brdf_u[i] > 0)
      groups[{rounded(p.wavelength_nm[i]), rounded(p.theta_i_deg[i]), rounded(p.phi_r_deg[i]),
              rounded(p.theta_r_deg[i])}]
          .push_back(i);
  return groups;
}

struct Fit {
  Eigen::Matrix<double, 9, 1> value;
  Matrix9 covariance;
  std::array<bool, 9> determined{};
  double chi2 = 0, condition = 0;
  Eigen::Index rank = 0;
};

Fit fit_direction(const formats::BrdfTable& table, const std::vector<std::size_t>& points,
                  const Design& design) {
  const auto n = design.rows();
  Eigen::VectorXd u(n), f(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    u(i) = table.points.brdf_u[points[static_cast<std::size_t>(i)]];
    f(i) = table.points.brdf_per_sr[points[static_cast<std::size_t>(i)]];
  }
  Fit fit;
  // Which elements the states fix is a matter of the design alone, not of the weights.
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(design, Eigen::ComputeFullV);
  const Eigen::VectorXd singular = svd.singularValues();
  while (fit.rank < singular.size() && singular(fit.rank) > negligible * singular(0)) ++fit.rank;
  fit.condition = singular(0) / singular(fit.rank - 1);
  const Eigen::MatrixXd open = svd.matrixV().rightCols(9 - fit.rank);
  for (Eigen::Index k = 0; k < 9; ++k)
    fit.determined[static_cast<std::size_t>(k)] = open.row(k).norm() < 1e-6;
  // Within the space that the states span, the weighted fit is unique.
  const Eigen::MatrixXd span = svd.matrixV().leftCols(fit.rank);
  const Eigen::MatrixXd weighted = u.cwiseInverse().asDiagonal() * (design * span);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(weighted);
  const Eigen::MatrixXd inverse = qr.solve(Eigen::MatrixXd::Identity(n, n));
  const Eigen::MatrixXd estimate = span * inverse * u.cwiseInverse().asDiagonal();  // 9 × n
  fit.value = estimate * f;
  fit.chi2 = (f - design * fit.value).cwiseQuotient(u).squaredNorm();
  fit.covariance = estimate * u.cwiseAbs2().asDiagonal() * estimate.transpose();
  for (const auto& factor : table.factors) {
    Eigen::VectorXd shift(n);
    for (Eigen::Index i = 0; i < n; ++i)
      shift(i) = factor.per_point[points[static_cast<std::size_t>(i)]];
    const Eigen::VectorXd moved = estimate * shift;
    fit.covariance += moved * moved.transpose();
  }
  return fit;
}

double realisable_z(const Fit& fit) {
  std::array<double, 9> elements{};
  for (std::size_t k = 0; k < 9; ++k) {
    if (!fit.determined[k]) return nan;
    elements[k] = fit.value(static_cast<Eigen::Index>(k));
  }
  const auto found = optics::linear_realisability(elements);
  const Eigen::Map<const Eigen::Matrix<double, 9, 1>> slope(found.slope.data());
  return found.least_eigenvalue / std::sqrt(slope.dot(fit.covariance * slope));
}

void append(formats::BrdfTable::Mueller& out, const formats::BrdfTable::Points& p, std::size_t at,
            std::size_t points, const Fit& fit) {
  out.theta_i_deg.push_back(p.theta_i_deg[at]);
  out.theta_r_deg.push_back(p.theta_r_deg[at]);
  out.phi_r_deg.push_back(p.phi_r_deg[at]);
  out.wavelength_nm.push_back(p.wavelength_nm[at]);
  const auto index = [](std::size_t k) { return static_cast<Eigen::Index>(k); };
  for (std::size_t k = 0; k < 9; ++k) {
    out.mueller.push_back(fit.determined[k] ? fit.value(index(k)) : nan);
    out.mueller_u.push_back(fit.determined[k] ? std::sqrt(fit.covariance(index(k), index(k)))
                                              : nan);
    for (std::size_t l = k; l < 9; ++l)
      out.covariance.push_back(
          fit.determined[k] && fit.determined[l] ? fit.covariance(index(k), index(l)) : nan);
  }
  out.condition.push_back(fit.condition);
  out.chi2.push_back(fit.chi2);
  out.dof.push_back(static_cast<double>(points) - static_cast<double>(fit.rank));
  out.realisable_z.push_back(realisable_z(fit));
}

}  // namespace

std::optional<formats::BrdfTable::Mueller> find_mueller(const formats::BrdfTable& table,
                                                        bool partial, MuellerSummary& summary) {
  formats::BrdfTable::Mueller out;
  const auto& p = table.points;
  std::set<std::size_t> missing;
  for (const auto& [key, points] : by_direction(p)) {
    Design design(static_cast<Eigen::Index>(points.size()), 9);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d a = ideal_analyzer_vector(p.analyzer_deg[points[i]]);
      const Eigen::Vector3d s = ideal_source_vector(p.polarizer_deg[points[i]]);
      const Eigen::Matrix3d outer = a * s.transpose();
      for (Eigen::Index k = 0; k < 9; ++k)
        design(static_cast<Eigen::Index>(i), k) = outer(k / 3, k % 3);
    }
    double oblique = 0;
    for (Eigen::Index k : {2, 5, 6, 7, 8})
      oblique = std::max(oblique, design.col(k).cwiseAbs().maxCoeff());
    if (oblique < 1e-3 && !partial) {
      ++summary.left_out;
      continue;
    }
    const Fit fit = fit_direction(table, points, design);
    append(out, p, points.front(), points.size(), fit);
    ++summary.directions;
    bool complete = true;
    for (std::size_t k = 0; k < 9; ++k)
      if (!fit.determined[k]) {
        complete = false;
        missing.insert(k);
      }
    if (complete) {
      ++summary.complete;
      summary.largest_condition = std::max(summary.largest_condition, fit.condition);
    }
    if (out.realisable_z.back() < unphysical_z) ++summary.unphysical;
    summary.chi2 += out.chi2.back();
    summary.dof += out.dof.back();
  }
  for (std::size_t k : missing) summary.undetermined.push_back(fmt::format("m{}{}", k / 3, k % 3));
  if (out.size() == 0) return std::nullopt;
  return out;
}

}  // namespace umov::calibrate
