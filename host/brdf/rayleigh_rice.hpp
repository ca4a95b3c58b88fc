// First-order perturbation theory of a slightly rough surface (Rayleigh, Rice, P13), in and out of
// the plane of incidence, with all polarisations.
//
// Parameters: n, kappa and the two-sided two-dimensional power spectral density of the heights:
// sigma_um, correlation_um (gaussian) or abc_a, abc_b, abc_c (abc).
//
// Assumes heights far below the wavelength, 4πσ cos θ/λ << 1, of one homogeneous material. Light
// scattered twice is left out, so that in-plane light is never depolarised.
#pragma once

#include <cmath>
#include <span>

#include "host/brdf/facet.hpp"
#include "host/brdf/gradient.hpp"
#include "host/brdf/jones.hpp"
#include "host/brdf/model.hpp"

namespace umov::brdf {

/// Density in µm⁴ at the spatial frequency whose square is `frequency2`, 1/µm².
template <class T, class A>
T spectral_density(Psd psd, std::span<const T> shape, const A& frequency2) {
  using std::exp;
  using std::log;
  if (psd == Psd::gaussian) {
    const T& sigma = shape[0];
    const T area = optics::pi * shape[1] * shape[1];
    return sigma * sigma * area * exp(T(-optics::pi * area * frequency2));
  }
  const T& b = shape[1];
  return shape[0] * exp(T(-0.5 * shape[2] * log(T(1.0 + b * b * frequency2))));
}

/// σ² in µm² of the spatial frequencies below 1/λ, the only ones that scatter light out of a beam
/// at normal incidence: 2π ∫ PSD f df from 0 to 1/λ.
template <class T>
T scattering_variance(Psd psd, std::span<const T> shape, double wavelength_um) {
  using std::exp;
  using std::log;
  const double limit2 = 1.0 / (wavelength_um * wavelength_um);
  if (psd == Psd::gaussian) {
    const T& sigma = shape[0];
    const T x = optics::pi * shape[1];
    return sigma * sigma * (1.0 - exp(T(-x * x * limit2)));
  }
  // π A ∫ (1 + B² u)^(-C/2) du with u = f²: (π A/B²) L · φ((1 - C/2) L), L = log(1 + B²/λ²) and
  // φ(z) = (e^z - 1)/z.
  const T b2 = shape[1] * shape[1];
  if (!(optics::value_of(b2) * limit2 > 1e-12)) return shape[0] * (optics::pi * limit2);
  const T length = log(T(1.0 + b2 * limit2));
  const T z = (1.0 - 0.5 * shape[2]) * length;
  const double value = optics::value_of(z);
  const double phi = std::abs(value) < 1e-5 ? 1.0 + 0.5 * value : std::expm1(value) / value;
  const double slope = std::abs(value) < 1e-3 ? 0.5 + value / 3.0 + 0.125 * value * value
                                              : (std::exp(value) - phi) / value;
  return shape[0] * optics::pi / b2 * length * optics::lift<T, 1>(phi, {slope}, {z});
}

/// The amplitudes q of P13. `scatter` is the exit direction's cos φ and sin φ, and sin θi · sin θr
/// with the sign of θr.
template <class T>
Jones<T> perturbation_amplitudes(const T& n, const T& kappa, const T& cos_i, const T& cos_r,
                                 const T& cos_phi, const T& sin_phi, const T& sines) {
  const ComplexValue<T> eps{T(n * n - kappa * kappa), T(2.0 * n * kappa)};
  const ComplexValue<T> contrast{T(eps.re - T(1.0)), eps.im};
  const ComplexValue<T> q_i = optics::normal_wave_number(n, kappa, cos_i);
  const ComplexValue<T> q_r = optics::normal_wave_number(n, kappa, cos_r);
  const ComplexValue<T> s_i{T(cos_i + q_i.re), q_i.im}, s_r{T(cos_r + q_r.re), q_r.im};
  const ComplexValue<T> p_i{T(eps.re * cos_i + q_i.re), T(eps.im * cos_i + q_i.im)};
  const ComplexValue<T> p_r{T(eps.re * cos_r + q_r.re), T(eps.im * cos_r + q_r.im)};
  const ComplexValue<T> both = times(q_i, q_r);
  const ComplexValue<T> along{T(both.re * cos_phi - eps.re * sines),
                              T(both.im * cos_phi - eps.im * sines)};
  return {quotient(scaled(contrast, T(-1.0 * cos_phi)), times(s_i, s_r)),
          quotient(times(scaled(contrast, sin_phi), q_i), times(p_i, s_r)),
          quotient(times(scaled(contrast, sin_phi), q_r), times(s_i, p_r)),
          quotient(times(contrast, along), times(p_i, p_r))};
}

/// sum += (16π²/λ⁴) cos θi cos θr PSD · Mueller(q).
template <class T, class A>
[[gnu::noinline]] void add_rayleigh_rice(optics::Mueller<T>& sum, std::span<const T> p, Psd psd,
                                         double wavelength_um, const Geometry<A>& geometry,
                                         const FacetFrame<A>& f) {
  using std::cos;
  using std::sin;
  const A cos_phi = cos(geometry.phi_r), sin_phi = sin(geometry.phi_r);
  const A sines = f.sin_i * sin(geometry.theta_r);
  const double wave = 1.0 / wavelength_um;
  const A frequency2 = wave * wave * (f.v_z * f.v_z * f.tan2_h);
  const double fourth = 16.0 * optics::pi * optics::pi * wave * wave * wave * wave;
  const T scale = spectral_density(psd, p.subspan(2), frequency2) * (fourth * (f.cos_i * f.cos_r));
  if constexpr (optics::DualNumber<T> && !std::is_same_v<A, T>) {
    using Small = Gradient<2>;
    const optics::Mueller<Small> m = mueller_of(
        perturbation_amplitudes(Small(p[0].a, 0), Small(p[1].a, 1), Small(f.cos_i), Small(f.cos_r),
                                Small(cos_phi), Small(sin_phi), Small(sines)));
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) {
        const Small& x = m[column][row];
        sum[column][row] += scale * optics::lift<T, 2>(x.a, x.v, {p[0], p[1]});
      }
    }
  } else {
    const optics::Mueller<T> m = mueller_of(perturbation_amplitudes(
        p[0], p[1], T(f.cos_i), T(f.cos_r), T(cos_phi), T(sin_phi), T(sines)));
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) sum[column][row] += scale * m[column][row];
    }
  }
}

/// R exp(-(4πσ cos θ/λ)²) with scattering_variance(): to the order of the theory the mirror loses
/// what the lobe scatters, R (1 - g), and the exponential, which differs from that in the next
/// order only, stays positive. `f` must be the mirror geometry.
template <class T, class A>
FacetMatrix<T> rayleigh_rice_mirror(std::span<const T> p, Psd psd, double wavelength_um,
                                    const FacetFrame<A>& f) {
  using std::exp;
  const A phase = 4.0 * optics::pi / wavelength_um * f.cos_i;
  const T g = scattering_variance(psd, p.subspan(2), wavelength_um) * (phase * phase);
  return scaled_reflection(facet_reflection(p[0], p[1], f.cos_d), T(exp(T(-g))));
}

}  // namespace umov::brdf
