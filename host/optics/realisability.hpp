// Is a measured Mueller matrix one that light can have?
//
// A matrix is physical (a mixture of Jones matrices) exactly where its coherency matrix
//   C = ¼ Σ m_ij σ_i ⊗ σ_j*   (σ_i the Pauli matrices in Stokes order)
// has no negative eigenvalue (S. R. Cloude, Optik 75, 26 (1986); R. Simon, Opt. Commun. 42, 293
// (1982)). Of the linear part (I, Q, U) alone the question is whether a completion to such a matrix
// exists. Turning the sign of V on both sides keeps a matrix physical and keeps its linear part and
// m33; the mean of a completion and of its turned self is physical too, as these matrices form a
// convex cone, and has no other element of V's row and column. So a completion exists exactly where
// one number m33 brings the least eigenvalue to zero or above; that eigenvalue is concave in m33.
#pragma once

#include <array>

namespace umov::optics {

/// Least eigenvalue of the coherency matrix (in the unit of the elements; m00 = 1 of an ideal
/// depolariser has ¼, any pure matrix 0) and its slope with respect to every element.
template <int side>
struct Realisability {
  double least_eigenvalue = 0;
  std::array<double, side * side> slope{};
};

/// Of a complete matrix, row by row.
Realisability<4> realisability(const std::array<double, 16>& mueller);

/// Of a linear part, row by row, at the completion that is best for it.
Realisability<3> linear_realisability(const std::array<double, 9>& mueller);

}  // namespace umov::optics
