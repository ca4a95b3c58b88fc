// Scalars that carry derivatives: what the optics templates need from a dual number.
//
// A dual number here is any type with a public value `a` and a public derivative vector `v` that
// adds and scales (ceres::Jet is one). Nothing of such a library is included: `double` needs none
// of it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>

namespace umov::optics {

template <class T>
concept DualNumber = requires(T x) {
  x.a;
  x.v;
};

/// The plain value of a scalar, without its derivatives.
template <class T>
constexpr auto value_of(const T& x) {
  if constexpr (DualNumber<T>) {
    return x.a;
  } else {
    return x;
  }
}

/// A function summed or tabulated in double, given to T by the chain rule: value f and its partial
/// derivatives with respect to `arguments`. Partials that belong to arguments without derivatives
/// cost little.
template <class T, std::size_t count>
T lift(double f, const std::array<double, count>& partials, const std::array<T, count>& arguments) {
  if constexpr (DualNumber<T>) {
    T result(f);
    for (std::size_t i = 0; i < count; ++i) result.v += partials[i] * arguments[i].v;
    return result;
  } else {
    static_cast<void>(partials);
    static_cast<void>(arguments);
    return T(f);
  }
}

/// Square root that is 0 with zero derivative at (or, by rounding, below) 0, where the true
/// derivative is infinite. At such points (exact retro direction, exact mirror direction) the
/// argument never depends on what is being fitted, and 0·∞ would poison the whole gradient.
template <class T>
T sqrt_or_zero(const T& x) {
  using std::sqrt;
  if (!(value_of(x) > 0.0)) return T(0.0);
  return sqrt(x);
}

}  // namespace umov::optics
