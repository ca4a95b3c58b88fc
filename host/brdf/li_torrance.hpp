// Li and Torrance's four-component model as this project defines it (P11). Parameters: n, kappa,
// sigma_um, tau_um, k_dd, k_udf, k_uds, k_fs, fs_width_deg, fs_polarization.
//
// k_dd weighs the He-Torrance lobe (and its mirror part), k_udf uniform light of the first surface,
// k_uds light from below that crosses the Fresnel interface twice, k_fs a broad forward lobe.
#pragma once

#include <array>
#include <cmath>
#include <span>

#include "host/brdf/facet.hpp"
#include "host/brdf/he_torrance.hpp"

namespace umov::brdf {

/// A number of one or two arguments with its partial derivatives.
struct Normalisation {
  double value;
  std::array<double, 2> partials;
};

/// T̄ = 2 ∫ T cos θ sin θ dθ of the unpolarised transmittance, with d/dn and d/dκ. Remembers recent
/// arguments, a few per thread: a fit asks for the same ones thousands of times.
Normalisation diffuse_transmittance(double n, double kappa);

/// N(w) = 2π ∫ exp(-θ²/2w²) cos θ sin θ dθ over the hemisphere, w in radians, with d/dw. Remembers
/// likewise.
Normalisation forward_lobe_norm(double width);

/// α² of the angle α whose squared chord is `chord2` = 4 sin²(α/2): smooth where α itself is not.
template <class A>
A squared_angle(const A& chord2) {
  const double c2 = optics::value_of(chord2);
  if (c2 < 1e-12) return chord2;
  const double chord = std::sqrt(c2);
  const double half = 0.5 * chord < 1.0 ? 0.5 * chord : 1.0;
  const double alpha = 2.0 * std::asin(half);
  const double cosine = std::sqrt(std::fmax(1.0 - half * half, 1e-300));
  return optics::lift<A, 1>(alpha * alpha, {alpha / (chord * cosine)}, {chord2});
}

/// k_dd f_dd + k_fs f_fs, the two parts that keep polarisation.
template <class T, class A>
FacetMatrix<T> li_torrance_directional(std::span<const T> p, double wavelength_um,
                                       const FacetFrame<A>& f) {
  using std::exp;
  FacetMatrix<T> m = he_torrance(p, wavelength_um, f);
  const T& k_dd = p[4];
  m = {T(k_dd * m.m00), T(k_dd * m.m01), T(k_dd * m.m11), T(k_dd * m.m22), T(k_dd * m.m23)};

  const T width = p[8] * optics::radians(1.0);
  const Normalisation norm = forward_lobe_norm(optics::value_of(width));
  const T lobe = p[7] * exp(T(-0.5 * squared_angle(f.chord2) / (width * width))) /
                 optics::lift<T, 1>(norm.value, {norm.partials[0]}, {width});
  const T kept = p[9] * lobe;
  m.m00 += lobe;
  m.m11 += kept;
  m.m22 -= kept;
  return m;
}

/// (k_udf + k_uds T(θi) T(θr)/(T(0) T̄))/π, depolarised.
template <class T, class A>
T li_torrance_diffuse(std::span<const T> p, const FacetFrame<A>& f) {
  const T& n = p[0];
  const T& kappa = p[1];
  const Normalisation mean = diffuse_transmittance(optics::value_of(n), optics::value_of(kappa));
  const T t_mean = optics::lift<T, 2>(mean.value, mean.partials, {n, kappa});
  const auto transmittance = [](const auto& index, const auto& absorption, const auto& cosine) {
    return optics::transmittance(index, absorption, cosine);
  };
  const T t_0 = lifted(n, kappa, 1.0, transmittance);
  const T through = lifted(n, kappa, f.cos_i, transmittance) *
                    lifted(n, kappa, f.cos_r, transmittance) / (t_0 * t_mean);
  return (p[5] + p[6] * through) * (1.0 / optics::pi);
}

template <class T, class A>
FacetMatrix<T> li_torrance_mirror(std::span<const T> p, double wavelength_um,
                                  const FacetFrame<A>& f) {
  const FacetMatrix<T> m = he_torrance_mirror(p, wavelength_um, f);
  const T& k_dd = p[4];
  return {T(k_dd * m.m00), T(k_dd * m.m01), T(k_dd * m.m11), T(k_dd * m.m22), T(k_dd * m.m23)};
}

}  // namespace umov::brdf
