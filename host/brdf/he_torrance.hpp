// He and Torrance's physical-optics reflection from a Gaussian surface (P10): directional-diffuse
// lobe and mirror part. Parameters: n, kappa, sigma_um (rms height σ0), tau_um (autocorrelation
// length).
//
// Assumes a Gaussian height distribution with Gaussian autocorrelation and τ of several
// wavelengths; one bounce. Towards grazing incidence it may reflect more than it receives.
#pragma once

#include <cmath>
#include <span>

#include "host/brdf/facet.hpp"
#include "host/brdf/height_series.hpp"
#include "host/brdf/shadowing.hpp"

namespace umov::brdf {

/// What lobe and mirror part share.
template <class T>
struct HeightStatistics {
  T shadowing;  ///< S(θi) S(θr)
  T g;          ///< phase variance [(2πσ/λ)(cos θi + cos θr)]² of the heights that are seen
};

/// y = z0/σ0 from y = c e^(-y²/2), the height of the mean plane that shadowing leaves visible.
template <class T>
T visible_plane(const T& c) {
  const double value = optics::value_of(c);
  double y = value < 1.0 ? value : std::sqrt(std::log(1.0 + value));
  for (int i = 0; i < 50; ++i) {
    const double e = value * std::exp(-0.5 * y * y);
    const double step = (y - e) / (1.0 + y * e);
    y -= step;
    if (std::abs(step) < 1e-15 * (1.0 + y)) break;
  }
  const double slope = std::exp(-0.5 * y * y) / (1.0 + y * y);
  return optics::lift<T, 1>(y, {slope}, {c});
}

/// K = tan θ erfc(x) with x = τ cot θ/2σ0.
template <class T, class A>
T hidden_share(const A& cos_theta, const A& sin_theta, const T& x) {
  const double value = optics::value_of(x);
  if (value >= smith_cutoff) return T(0.0);
  const double slope = -2.0 * std::exp(-value * value) * std::numbers::inv_sqrtpi;
  return optics::lift<T, 1>(std::erfc(value), {slope}, {x}) * (sin_theta / cos_theta);
}

template <class T, class A>
HeightStatistics<T> height_statistics(const T& sigma0, const T& tau, double wavelength_um,
                                      const FacetFrame<A>& f) {
  const T slope = std::numbers::sqrt2 * sigma0 / tau;  // x = cot θ/(√2 slope) = τ cot θ/2σ0
  const T x_i = smith_argument(f.cos_i, f.sin_i, slope);
  const T x_r = smith_argument(f.cos_r, f.sin_r, slope);
  const double root = 0.25 / std::sqrt(0.5 * optics::pi);
  const T y = visible_plane(
      T(root * (hidden_share(f.cos_i, f.sin_i, x_i) + hidden_share(f.cos_r, f.sin_r, x_r))));
  const T phase = sigma0 * (2.0 * optics::pi / wavelength_um * f.v_z);
  return {smith_factor(x_i) * smith_factor(x_r), phase * phase / (1.0 + y * y)};
}

/// G S D/(π cos θi cos θr): the lobe without the Fresnel factors of its facets, 1/sr.
template <class T, class A>
T height_lobe(const T& sigma0, const T& tau, double wavelength_um, const FacetFrame<A>& f) {
  const HeightStatistics<T> heights = height_statistics(sigma0, tau, wavelength_um, f);
  const double wave_number = 2.0 * optics::pi / wavelength_um;
  // v_xy² τ²/4, the argument that decays with distance from the mirror direction.
  const T u = tau * tau * (0.25 * wave_number * wave_number * f.v_z * f.v_z * f.tan2_h);
  const HeightSeries series = height_series(optics::value_of(heights.g), optics::value_of(u));
  const T h = optics::lift<T, 2>(series.value, {series.by_g, series.by_u}, {heights.g, u});
  // G = (v·v/v_z)² and D's π²τ²/4λ² = (k τ)²/16.
  const A v2 = 4.0 * f.cos_d * f.cos_d;
  const A g = (v2 / f.v_z) * (v2 / f.v_z);
  return tau * tau * heights.shadowing * h *
         (wave_number * wave_number / 16.0 * g / (optics::pi * f.cos_i * f.cos_r));
}

/// f_dd = |F|² G S D/(π cos θi cos θr).
template <class T, class A>
FacetMatrix<T> he_torrance(std::span<const T> p, double wavelength_um, const FacetFrame<A>& f) {
  return scaled_reflection(facet_reflection(p[0], p[1], f.cos_d),
                           height_lobe(p[2], p[3], wavelength_um, f));
}

/// e^(-g) |F|² S, dimensionless; `f` must be the mirror geometry.
template <class T, class A>
FacetMatrix<T> he_torrance_mirror(std::span<const T> p, double wavelength_um,
                                  const FacetFrame<A>& f) {
  using std::exp;
  const HeightStatistics<T> heights = height_statistics(p[2], p[3], wavelength_um, f);
  const T scale = exp(T(-heights.g)) * heights.shadowing;
  return scaled_reflection(facet_reflection(p[0], p[1], f.cos_d), scale);
}

}  // namespace umov::brdf
