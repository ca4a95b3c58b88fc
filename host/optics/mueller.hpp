// Stokes vectors and Mueller matrices. Conventions: docs/physics.md, section 1.
//
// Stokes (I, Q, U, V) in the basis {s, p, k}: Q > 0 is s, U > 0 is s + p, V > 0 is Jones (1, i)/√2
// with time factor exp(-iωt). A Mueller element (row, column) is (outgoing, incoming).
#pragma once

#include <cmath>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/optics/angles.hpp"

namespace umov::optics {

template <class T>
using Vec3 = glm::vec<3, T>;

/// (I, Q, U, V).
template <class T>
using Stokes = glm::vec<4, T>;

/// 4 × 4, stored by columns as GLM does: go through element() and set_element().
template <class T>
using Mueller = glm::mat<4, 4, T>;

template <class T>
const T& element(const Mueller<T>& m, int row, int column) {
  return m[column][row];
}

template <class T>
void set_element(Mueller<T>& m, int row, int column, const T& value) {
  m[column][row] = value;
}

template <class T>
Mueller<T> zero_mueller() {
  return Mueller<T>(T(0.0));
}

template <class T>
Mueller<T> identity_mueller() {
  return Mueller<T>(T(1.0));
}

/// Ideal depolarizer: keeps m00 = 1 only.
template <class T>
Mueller<T> depolarizer() {
  Mueller<T> m(T(0.0));
  m[0][0] = T(1.0);
  return m;
}

/// Change of basis by `cos2`, `sin2` of twice the angle β with s' = s cos β + p sin β (about +k):
/// the matrix takes Stokes components in {s, p} to those in {s', p'}.
template <class T>
Mueller<T> rotation(const T& cos2, const T& sin2) {
  Mueller<T> m(T(1.0));
  set_element(m, 1, 1, cos2);
  set_element(m, 1, 2, sin2);
  set_element(m, 2, 1, T(-sin2));
  set_element(m, 2, 2, cos2);
  return m;
}

/// Change of basis by the angle β in radians.
template <class T>
Mueller<T> rotation(const T& angle) {
  using std::cos;
  using std::sin;
  return rotation(T(cos(2.0 * angle)), T(sin(2.0 * angle)));
}

/// a · b: first b acts, then a.
template <class T>
Mueller<T> product(const Mueller<T>& a, const Mueller<T>& b) {
  Mueller<T> m(T(0.0));
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      T sum(0.0);
      for (int i = 0; i < 4; ++i) sum += element(a, row, i) * element(b, i, column);
      set_element(m, row, column, sum);
    }
  }
  return m;
}

/// m · source.
template <class T>
Stokes<T> apply(const Mueller<T>& m, const Stokes<T>& source) {
  Stokes<T> out(T(0.0));
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) out[row] += element(m, row, column) * source[column];
  }
  return out;
}

/// Light behind a linear polariser whose transmission axis stands `alpha_deg` from p towards +s
/// (0 = P, 90 = S, 45 = U > 0), for unit intensity: (1, -cos 2α, sin 2α, 0).
template <class T>
Stokes<T> polarizer_stokes(double alpha_deg) {
  const double a = 2.0 * radians(alpha_deg);
  return Stokes<T>(T(1.0), T(-std::cos(a)), T(std::sin(a)), T(0.0));
}

/// Row vector of an ideal linear analyser at `alpha_deg` (as above): ½ (1, -cos 2α, sin 2α, 0).
template <class T>
Stokes<T> analyzer_stokes(double alpha_deg) {
  const double a = 2.0 * radians(alpha_deg);
  return Stokes<T>(T(0.5), T(-0.5 * std::cos(a)), T(0.5 * std::sin(a)), T(0.0));
}

/// Unpolarised light of unit intensity; as a row vector, a detector without an analyser.
template <class T>
Stokes<T> unpolarized() {
  return Stokes<T>(T(1.0), T(0.0), T(0.0), T(0.0));
}

/// analyserᵀ · m · source: what a detector behind `analyser` sees of `source` through `m`.
template <class T>
T contract(const Stokes<T>& analyser, const Mueller<T>& m, const Stokes<T>& source) {
  T sum(0.0);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      sum += analyser[row] * element(m, row, column) * source[column];
    }
  }
  return sum;
}

/// The same with constant optics in front of a matrix that carries derivatives. Zero weights are
/// skipped.
template <class T>
requires(!std::is_same_v<T, double>) T
    contract(const Stokes<double>& analyser, const Mueller<T>& m, const Stokes<double>& source) {
  T sum(0.0);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      const double weight = analyser[row] * source[column];
      if (weight != 0.0) sum += element(m, row, column) * weight;
    }
  }
  return sum;
}

}  // namespace umov::optics
