// Shadowing and masking of facets: the factor S of P8 and P10.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "host/brdf/facet.hpp"
#include "host/brdf/model.hpp"
#include "host/optics/dual.hpp"

namespace umov::brdf {

/// Cotangents above this, in units of √2 times the slope, cast no shadow that a double can hold
/// (e^-100).
inline constexpr double smith_cutoff = 10.0;

/// W(x) = x (1 + Λ(x)) for Gaussian slopes, x = cot θ/(√2 σ); W' = 1 - ½ erfc x.
struct SmithTerms {
  double lit;     ///< N = 1 - ½ erfc x
  double w;       ///< W
  double normal;  ///< dN/dx = e^(-x²)/√π
};

inline SmithTerms smith_terms(double x) {
  const double normal = std::exp(-x * x) * std::numbers::inv_sqrtpi;
  const double lit = 1.0 - 0.5 * std::erfc(x);
  return {lit, x * lit + 0.5 * normal, normal};
}

/// x = cot θ/(√2 σ), or a value past the cutoff where that overflows.
template <class T, class A>
T smith_argument(const A& cos_theta, const A& sin_theta, const T& slope_rms) {
  using optics::value_of;
  const double limit =
      smith_cutoff * std::numbers::sqrt2 * value_of(slope_rms) * value_of(sin_theta);
  if (value_of(cos_theta) >= limit) return T(smith_cutoff);
  return T(cos_theta / (std::numbers::sqrt2 * slope_rms * sin_theta));
}

/// One direction's factor as the reference values and He and Torrance have it:
/// S(θ) = (1 - ½ erfc x)/(1 + Λ) = x N/W.
template <class T>
T smith_factor(const T& x) {
  const double value = optics::value_of(x);
  if (value >= smith_cutoff) return T(1.0);
  const SmithTerms t = smith_terms(value);
  const double s = value * t.lit / t.w;
  const double slope = (t.lit + value * t.normal) / t.w - s * t.lit / t.w;
  return optics::lift<T, 1>(s, {slope}, {x});
}

/// The height-correlated form 1/(1 + Λi + Λr).
template <class T>
T smith_correlated(const T& x_i, const T& x_r) {
  const double i = optics::value_of(x_i);
  const double r = optics::value_of(x_r);
  const SmithTerms ti = smith_terms(i);
  const SmithTerms tr = smith_terms(r);
  // 1/(W_i/x_i + W_r/x_r - 1) with the poles at grazing multiplied out.
  const double denominator = ti.w * r + tr.w * i - i * r;
  if (!(denominator > 0.0)) return T(0.0);
  const double s = i * r / denominator;
  const double by_i = (r - s * (ti.lit * r + tr.w - r)) / denominator;
  const double by_r = (i - s * (tr.lit * i + ti.w - i)) / denominator;
  return optics::lift<T, 2>(s, {by_i, by_r}, {x_i, x_r});
}

/// Torrance and Sparrow's symmetric V-grooves.
template <class A>
A v_groove_factor(const FacetFrame<A>& f) {
  using optics::value_of;
  const A lower = value_of(f.cos_i) < value_of(f.cos_r) ? f.cos_i : f.cos_r;
  const A s = 2.0 * f.cos_h * lower / f.cos_d;
  return value_of(s) < 1.0 ? s : A(1.0);
}

/// Maxwell and Beard's empirical form; `omega` and `tau` in radians.
template <class T, class A>
T maxwell_beard_factor(const T& omega, const T& tau, const FacetFrame<A>& f) {
  using std::atan2;
  using std::exp;
  const A theta_h = atan2(optics::sqrt_or_zero(f.tan2_h), A(1.0));
  const A theta_d = atan2(f.sin_d, f.cos_d);
  const T ratio = theta_h / omega;
  return (1.0 + ratio * exp(T(-2.0 * theta_d / tau))) / (1.0 + ratio);
}

}  // namespace umov::brdf
