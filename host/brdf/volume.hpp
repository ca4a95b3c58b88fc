// Light from below a smooth interface, polarised by crossing it twice (P15): a Lambertian body, and
// a cloudy medium that scatters each ray once.
//
// `subsurface`: n, rho. `single-scatter`: n, albedo, asymmetry. Both depolarise inside; what
// polarisation there is comes from the transmittances. The light that the interface reflects
// itself is not in them: add microfacet or another surface.
#pragma once

#include <cmath>
#include <span>

#include "host/brdf/facet.hpp"
#include "host/brdf/li_torrance.hpp"

namespace umov::brdf {

/// Transmittance of the interface for one beam: mean of s and p, and half their difference.
template <class T>
struct Crossing {
  T mean, half_difference;
};

template <class T, class A>
Crossing<T> crossing(const T& n, const A& cosine) {
  const optics::FresnelReflection<T> r = facet_reflection(n, T(0.0), cosine);
  return {T(1.0 - r.mean), T(-r.half_difference)};
}

/// sum += scale · (T̄r, Tr', 0, 0)ᵀ (T̄i, Ti', 0, 0).
template <class T, class A>
[[gnu::noinline]] void add_crossed_twice(optics::Mueller<T>& sum, const T& n, const T& scale,
                                         const FacetFrame<A>& f) {
  const Crossing<T> in = crossing(n, f.cos_i), out = crossing(n, f.cos_r);
  const T mean = scale * out.mean, difference = scale * out.half_difference;
  sum[0][0] += mean * in.mean;
  sum[0][1] += difference * in.mean;
  sum[1][0] += mean * in.half_difference;
  sum[1][1] += difference * in.half_difference;
}

/// ρ/(π n² (1 - ρ r)) with r = 1 - T̄/n² the interface's diffuse reflectance from inside: a
/// Lambertian body of reflectance `rho` that lights the interface from below again and again.
template <class T>
[[gnu::noinline]] T body_brdf(const T& n, const T& rho) {
  const Normalisation mean = diffuse_transmittance(optics::value_of(n), 0.0);
  const T t_mean = optics::lift<T, 1>(mean.value, {mean.partials[0]}, {n});
  const T n2 = n * n;
  return rho / (optics::pi * (n2 * (1.0 - rho) + rho * t_mean));
}

/// cos θ of the refracted beam.
template <class T, class A>
T refracted_cosine(const T& n, const A& sine) {
  using std::sqrt;
  return sqrt(T(1.0 - sine * sine / (n * n)));
}

/// ω p(Θ)/(n² (cos θi' + cos θr')), primes inside: first-order scattering of a deep medium, with
/// Henyey and Greenstein's phase function of the angle Θ between the two refracted beams.
template <class T, class A>
[[gnu::noinline]] T single_scattering_brdf(std::span<const T> p, const Geometry<A>& geometry,
                                           const FacetFrame<A>& f) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T& n = p[0];
  const T& g = p[2];
  const T in = refracted_cosine(n, f.sin_i), out = refracted_cosine(n, f.sin_r);
  const A sines = f.sin_i * sin(geometry.theta_r) * cos(geometry.phi_r);
  const T n2 = n * n;
  const T cos_scatter = sines / n2 - in * out;
  const T g2 = g * g;
  const T base = 1.0 + g2 - 2.0 * g * cos_scatter;
  const T phase = (1.0 - g2) * (0.25 / optics::pi) / (base * sqrt(base));
  return p[1] * phase / (n2 * (in + out));
}

}  // namespace umov::brdf
