// A dual number with a fixed small gradient, for numbers that the library itself needs with
// derivatives.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace umov::brdf {

template <std::size_t count>
struct GradientVector : std::array<double, count> {
  GradientVector& operator+=(const GradientVector& other) {
    for (std::size_t i = 0; i < count; ++i) (*this)[i] += other[i];
    return *this;
  }
  friend GradientVector operator*(double scale, GradientVector v) {
    for (double& x : v) x *= scale;
    return v;
  }
};

/// Value `a` and gradient `v`, with the arithmetic that the optics templates use.
template <std::size_t count>
struct Gradient {
  double a = 0.0;
  GradientVector<count> v{};

  Gradient() = default;
  explicit Gradient(double value) : a(value) {}
  /// The i-th independent variable.
  Gradient(double value, std::size_t i) : a(value) { v[i] = 1.0; }

  /// A function of two arguments with partial derivatives du and dv.
  static Gradient chain(double value, double du, const Gradient& x, double dv, const Gradient& y) {
    Gradient r(value);
    for (std::size_t i = 0; i < count; ++i) r.v[i] = du * x.v[i] + dv * y.v[i];
    return r;
  }
  static Gradient chain(double value, double du, const Gradient& x) {
    Gradient r(value);
    for (std::size_t i = 0; i < count; ++i) r.v[i] = du * x.v[i];
    return r;
  }

  friend Gradient operator+(const Gradient& x, const Gradient& y) {
    return chain(x.a + y.a, 1, x, 1, y);
  }
  friend Gradient operator-(const Gradient& x, const Gradient& y) {
    return chain(x.a - y.a, 1, x, -1, y);
  }
  friend Gradient operator*(const Gradient& x, const Gradient& y) {
    return chain(x.a * y.a, y.a, x, x.a, y);
  }
  friend Gradient operator/(const Gradient& x, const Gradient& y) {
    const double ratio = x.a / y.a;
    return chain(ratio, 1.0 / y.a, x, -ratio / y.a, y);
  }
  friend Gradient operator-(double s, const Gradient& x) { return chain(s - x.a, -1.0, x); }
  friend Gradient operator*(double s, const Gradient& x) { return chain(s * x.a, s, x); }
  friend Gradient operator/(double s, const Gradient& x) {
    const double ratio = s / x.a;
    return chain(ratio, -ratio / x.a, x);
  }
  friend Gradient sqrt(const Gradient& x) {
    const double root = std::sqrt(x.a);
    return chain(root, 0.5 / root, x);
  }
};

}  // namespace umov::brdf
