// Beard and Maxwell's paint model: first-surface light from a zero-bistatic scan, volume light
// (P14).
//
// Parameters: n, kappa, slope_rms, bias (1/sr: the zero-bistatic BRDF at the normal), with
// Maxwell-Beard shadowing omega, tau; then rho_d, rho_v (1/sr).
//
// Empirical: neither term knows how much light there is, and towards grazing it reflects more than
// it receives. Reciprocal. Volume light is depolarised.
#pragma once

#include <cmath>
#include <numbers>
#include <span>

#include "host/brdf/facet.hpp"
#include "host/brdf/microfacet.hpp"
#include "host/brdf/model.hpp"

namespace umov::brdf {

/// Z(θh)/Z(0) · cos²θh, Z the zero-bistatic scan.
template <class T, class A>
T zero_bistatic_shape(Slopes slopes, const T& slope_rms, const FacetFrame<A>& f) {
  using std::atan2;
  using std::exp;
  const A cos2 = f.cos_h * f.cos_h;
  const T variance = slope_rms * slope_rms;
  if (slopes == Slopes::angle) {
    const A theta_h = atan2(optics::sqrt_or_zero(f.tan2_h), A(1.0));
    return exp(T(-0.5 * theta_h * theta_h / variance)) * cos2;
  }
  // What P8's facets would show: their density over its value at the normal.
  return slope_density(slopes, slope_rms, f) * (2.0 * optics::pi * variance) *
         (slopes == Slopes::gaussian ? 1.0 : 1.0 / 3.0);
}

/// |F(θd)|²/R(0) · bias · Z(θh)/Z(0) cos²θh/(cos θi cos θr) · S.
template <class T, class A>
[[gnu::noinline]] FacetMatrix<T> beard_maxwell_surface(std::span<const T> p, Slopes slopes,
                                                       Shadowing shadowing,
                                                       const FacetFrame<A>& f) {
  const T& n = p[0];
  const T& kappa = p[1];
  const T kappa2 = kappa * kappa;
  // 1/R(0); where index and vacuum match there is no first surface to scale.
  const T at_normal = (n - 1.0) * (n - 1.0) + kappa2;
  if (!(optics::value_of(at_normal) > 0.0)) return {T(0.0), T(0.0), T(0.0), T(0.0), T(0.0)};
  const T inverse = ((n + 1.0) * (n + 1.0) + kappa2) / at_normal;
  const T s = shadowing_factor(shadowing, p[2], p.subspan(4), f);
  const T scale =
      p[3] * inverse * zero_bistatic_shape(slopes, p[2], f) * s * (1.0 / (f.cos_i * f.cos_r));
  return scaled_reflection(facet_reflection(n, kappa, f.cos_d), scale);
}

/// ρ_d + 2 ρ_v/(cos θi + cos θr), depolarised; `volume` is rho_d, rho_v.
template <class T, class A>
T beard_maxwell_volume(std::span<const T> volume, const FacetFrame<A>& f) {
  return volume[0] + volume[1] * (2.0 / f.v_z);
}

}  // namespace umov::brdf
