// Microfacet first-surface reflection (P8): polarised Fresnel facets with Gaussian, exponential or
// GGX slopes.
//
// Assumes geometric optics, one bounce and an isotropic surface. Without shadowing it reflects more
// than it receives towards grazing; with it, light that meets a second facet is lost.
#pragma once

#include <cmath>
#include <numbers>
#include <span>

#include "host/brdf/facet.hpp"
#include "host/brdf/model.hpp"
#include "host/brdf/shadowing.hpp"

namespace umov::brdf {

/// P8's density of facet normals without the bias, ∫ P cos θh dω = 1; `slope_rms` is
/// one-dimensional.
template <class T, class A>
T slope_density(Slopes slopes, const T& slope_rms, const FacetFrame<A>& f) {
  using std::exp;
  const A cos2 = f.cos_h * f.cos_h;
  const A scale = 1.0 / (cos2 * cos2);
  const T variance = slope_rms * slope_rms;
  if (slopes == Slopes::gaussian) {
    return exp(T(-0.5 * f.tan2_h / variance)) * scale / (2.0 * optics::pi * variance);
  }
  // 3/(π s²) exp(-√6 tan θh/s) with s = √2 slope_rms.
  const A tangent = optics::sqrt_or_zero(f.tan2_h);
  return exp(T(-std::numbers::sqrt3 * tangent / slope_rms)) * scale * 3.0 /
         (2.0 * optics::pi * variance);
}

/// S with Gaussian-slope Smith factors; `omega` and `tau` matter to Maxwell and Beard's only.
template <class T, class A>
T shadowing_factor(Shadowing shadowing, const T& slope_rms, std::span<const T> omega_tau,
                   const FacetFrame<A>& f) {
  switch (shadowing) {
    case Shadowing::none:
      break;
    case Shadowing::v_groove:
      return T(v_groove_factor(f));
    case Shadowing::smith:
      return smith_factor(smith_argument(f.cos_i, f.sin_i, slope_rms)) *
             smith_factor(smith_argument(f.cos_r, f.sin_r, slope_rms));
    case Shadowing::smith_correlated:
      return smith_correlated(smith_argument(f.cos_i, f.sin_i, slope_rms),
                              smith_argument(f.cos_r, f.sin_r, slope_rms));
    case Shadowing::maxwell_beard:
      return maxwell_beard_factor(omega_tau[0], omega_tau[1], f);
  }
  return T(1.0);
}

/// Parameters: n, kappa, slope_rms, bias; with Maxwell-Beard shadowing also omega, tau.
template <class T, class A>
FacetMatrix<T> microfacet(std::span<const T> p, Slopes slopes, Shadowing shadowing,
                          const FacetFrame<A>& f) {
  const T density = p[3] * slope_density(slopes, p[2], f);
  const T s = shadowing_factor(shadowing, p[2], p.subspan(4), f);
  const T scale = density * s * (0.25 / (f.cos_i * f.cos_r));
  return scaled_reflection(facet_reflection(p[0], p[1], f.cos_d), scale);
}

/// GGX (Trowbridge-Reitz). Parameters: n, kappa, alpha. Its Smith factors are 2/(1 + √(1 + α²
/// tan²θ)).
template <class T, class A>
FacetMatrix<T> ggx(std::span<const T> p, Shadowing shadowing, const FacetFrame<A>& f) {
  using std::sqrt;
  const T alpha2 = p[2] * p[2];
  const T root = 1.0 / (f.cos_h * f.cos_h * (alpha2 + f.tan2_h));
  T scale = alpha2 * root * root * (0.25 / (optics::pi * f.cos_i * f.cos_r));
  if (shadowing == Shadowing::v_groove) {
    scale *= T(v_groove_factor(f));
  } else if (shadowing != Shadowing::none) {
    // cos θ (1 + 2Λ) = √(cos²θ + α² sin²θ) has no pole at grazing.
    const T root_i = sqrt(f.cos_i * f.cos_i + alpha2 * (f.sin_i * f.sin_i));
    const T root_r = sqrt(f.cos_r * f.cos_r + alpha2 * (f.sin_r * f.sin_r));
    if (shadowing == Shadowing::smith) {
      scale *= (4.0 * f.cos_i * f.cos_r) / ((f.cos_i + root_i) * (f.cos_r + root_r));
    } else {
      scale *= (2.0 * f.cos_i * f.cos_r) / (f.cos_i * root_r + f.cos_r * root_i);
    }
  }
  return scaled_reflection(facet_reflection(p[0], p[1], f.cos_d), scale);
}

}  // namespace umov::brdf
