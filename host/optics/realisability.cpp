#include "host/optics/realisability.hpp"

#include <cmath>
#include <complex>
#include <cstddef>

namespace umov::optics {

namespace {

using Complex = std::complex<double>;
using Hermitian = std::array<std::array<Complex, 4>, 4>;
using Vector = std::array<Complex, 4>;

/// σ_i in Stokes order (I, Q, U, V).
Complex pauli(int i, int row, int column) {
  switch (i) {
    case 0:
      return row == column ? 1.0 : 0.0;
    case 1:
      return row != column ? 0.0 : row == 0 ? 1.0 : -1.0;
    case 2:
      return row != column ? 1.0 : 0.0;
    default:
      return row == column ? Complex(0, 0) : row == 0 ? Complex(0, -1) : Complex(0, 1);
  }
}

/// Element (a, b) of ¼ σ_i ⊗ σ_j*.
Complex basis(int i, int j, std::size_t a, std::size_t b) {
  const auto high = [](std::size_t k) { return static_cast<int>(k / 2); };
  const auto low = [](std::size_t k) { return static_cast<int>(k % 2); };
  return 0.25 * pauli(i, high(a), high(b)) * std::conj(pauli(j, low(a), low(b)));
}

/// The sixteen basis matrices, made once.
const std::array<Hermitian, 16>& bases() {
  static const std::array<Hermitian, 16> all = [] {
    std::array<Hermitian, 16> result;
    for (std::size_t k = 0; k < 16; ++k)
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b)
          result[k][a][b] = basis(static_cast<int>(k / 4), static_cast<int>(k % 4), a, b);
    return result;
  }();
  return all;
}

Hermitian coherency(const std::array<double, 16>& mueller) {
  Hermitian c{};
  for (std::size_t k = 0; k < 16; ++k) {
    if (mueller[k] == 0) continue;
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < 4; ++b) c[a][b] += mueller[k] * bases()[k][a][b];
  }
  return c;
}

struct Least {
  double value;
  Vector vector;
};

/// Least eigenvalue by Jacobi rotations of the real symmetric matrix [[Re, -Im], [Im, Re]], whose
/// eigenvalues are those of the Hermitian one, each twice.
Least least_eigenvalue(const Hermitian& c) {
  constexpr std::size_t n = 8;
  std::array<std::array<double, n>, n> a{}, v{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      a[i][j] = a[i + 4][j + 4] = c[i][j].real();
      a[i + 4][j] = c[i][j].imag();
      a[i][j + 4] = -c[i][j].imag();
    }
  double size = 0;
  for (std::size_t i = 0; i < n; ++i) {
    v[i][i] = 1;
    for (std::size_t j = 0; j < n; ++j) size += a[i][j] * a[i][j];
  }
  for (int sweep = 0; sweep < 40; ++sweep) {
    double off = 0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) off += a[i][j] * a[i][j];
    if (off <= 1e-32 * size) break;
    for (std::size_t p = 0; p < n; ++p)
      for (std::size_t q = p + 1; q < n; ++q) {
        if (a[p][q] == 0) continue;
        const double tau = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = (tau >= 0 ? 1.0 : -1.0) / (std::abs(tau) + std::hypot(1.0, tau));
        const double cosine = 1 / std::hypot(1.0, t), sine = t * cosine;
        for (std::size_t k = 0; k < n; ++k) {
          const double kp = a[k][p], kq = a[k][q];
          a[k][p] = cosine * kp - sine * kq;
          a[k][q] = sine * kp + cosine * kq;
        }
        for (std::size_t k = 0; k < n; ++k) {
          const double pk = a[p][k], qk = a[q][k];
          a[p][k] = cosine * pk - sine * qk;
          a[q][k] = sine * pk + cosine * qk;
          const double kp = v[k][p], kq = v[k][q];
          v[k][p] = cosine * kp - sine * kq;
          v[k][q] = sine * kp + cosine * kq;
        }
      }
  }
  std::size_t best = 0;
  for (std::size_t k = 1; k < n; ++k)
    if (a[k][k] < a[best][best]) best = k;
  Least least{a[best][best], {}};
  for (std::size_t k = 0; k < 4; ++k) least.vector[k] = {v[k][best], v[k + 4][best]};
  return least;
}

/// v† B v for the basis matrix of element k: the slope of an eigenvalue.
double slope_of(const Vector& v, std::size_t k) {
  Complex sum = 0;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < 4; ++b) sum += std::conj(v[a]) * bases()[k][a][b] * v[b];
  return sum.real();
}

}  // namespace

Realisability<4> realisability(const std::array<double, 16>& mueller) {
  const Least least = least_eigenvalue(coherency(mueller));
  Realisability<4> result;
  result.least_eigenvalue = least.value;
  for (std::size_t k = 0; k < 16; ++k) result.slope[k] = slope_of(least.vector, k);
  return result;
}

Realisability<3> linear_realisability(const std::array<double, 9>& mueller) {
  constexpr std::size_t m33 = 15;
  std::array<double, 16> full{};
  double size = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      full[4 * i + j] = mueller[3 * i + j];
      size += std::abs(mueller[3 * i + j]);
    }
  const auto at = [&full](double value) {
    full[m33] = value;
    return least_eigenvalue(coherency(full));
  };
  // The maximum of a concave function, by the sign of its slope.
  double low = -2 * size, high = 2 * size;
  Least below = at(low), above = at(high);
  double rise = slope_of(below.vector, m33), fall = slope_of(above.vector, m33);
  for (int step = 0; step < 48; ++step) {
    const double middle = 0.5 * (low + high);
    const Least here = at(middle);
    const double slope = slope_of(here.vector, m33);
    if (slope > 0) {
      low = middle;
      below = here;
      rise = slope;
    } else {
      high = middle;
      above = here;
      fall = slope;
    }
  }
  // At a kink two eigenvalues cross, and the mixture of both that is stationary in m33 gives the
  // slopes.
  const double share = rise - fall > 1e-12 ? -fall / (rise - fall) : 0.5;
  Realisability<3> result;
  result.least_eigenvalue = share * below.value + (1 - share) * above.value;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      result.slope[3 * i + j] = share * slope_of(below.vector, 4 * i + j) +
                                (1 - share) * slope_of(above.vector, 4 * i + j);
  return result;
}

}  // namespace umov::optics
