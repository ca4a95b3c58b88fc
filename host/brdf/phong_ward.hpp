// Two scalar lobes that users bring from computer graphics. They know nothing of polarisation:
// treated as depolarising, so that only m00 is not 0. Neither is shadowed; both lose energy towards
// grazing incidence.
#pragma once

#include <array>
#include <cmath>
#include <span>

#include "host/brdf/facet.hpp"

namespace umov::brdf {

/// Phong's lobe cosᵉα about the mirror direction, normalised so that its reflectance at normal
/// incidence is ks: ks (e + 2)/2π · cosᵉα. Reciprocal. Parameters: ks, exponent.
template <class T, class A>
T phong(std::span<const T> p, const FacetFrame<A>& f) {
  using std::exp;
  using std::log;
  const A cos_alpha = 1.0 - 0.5 * f.chord2;
  if (!(optics::value_of(cos_alpha) > 0.0)) return T(0.0);
  return p[0] * (p[1] + 2.0) * (0.5 / optics::pi) * exp(T(p[1] * log(cos_alpha)));
}

/// Ward's elliptical Gaussian (1992): ks exp(-(hx²/αx² + hy²/αy²))/(4π αx αy √(cos θi cos θr)) with
/// the facet slopes hx, hy; αx lies in the plane of incidence. Parameters: ks, alpha_x, alpha_y.
template <class T, class A>
T ward(std::span<const T> p, const FacetFrame<A>& f) {
  using std::exp;
  using std::sqrt;
  const T x = f.half_x / p[1];
  const T y = f.half_y / p[2];
  return p[0] * exp(T(-(x * x + y * y))) /
         (4.0 * optics::pi * p[1] * p[2] * sqrt(f.cos_i * f.cos_r));
}

}  // namespace umov::brdf
