// Orthonormal directions of a space.
#pragma once

#include <Eigen/Core>
#include <Eigen/QR>

namespace umov::gap {

/// As columns, of the space that `columns` span; none for none (Eigen's factorisation reads beyond
/// an empty matrix).
inline Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns) {
  if (columns.cols() == 0) return columns;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor(columns);
  return factor.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), factor.rank());
}

}  // namespace umov::gap
