// What the sample does beyond the base model: dirt and water on it, further lobes, a richer
// reflectance.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "host/brdf/li_torrance.hpp"
#include "host/gap/scan/effects/footprint.hpp"
#include "host/gap/scan/effects/free_form.hpp"
#include "host/gap/scan/effects/material.hpp"

namespace umov::gap::scan {

inline constexpr double water_index = 1.333;

/// Henyey and Greenstein's phase function, normalised to 4π over the sphere.
template <class T, class A>
T phase_function(const T& g, const A& cos_scatter) {
  using std::sqrt;
  const T base = 1.0 + g * g - 2.0 * g * cos_scatter;
  return (1.0 - g * g) / (base * sqrt(base));
}

/// Unpolarised transmittance of a water surface.
template <class T, class A>
T water_transmittance(const A& cosine) {
  return T(optics::transmittance(A(water_index), A(0.0), cosine));
}

/// The base's lobe `p` made anisotropic: its slopes along an axis that is turned by e[1] degrees
/// from the plane of incidence stay, those across it are e^e[0] times as large.
template <class T, class A>
void add_anisotropic(optics::Mueller<T>& m, const T* p, const T* e, const brdf::FacetFrame<A>& f) {
  using std::cos;
  using std::exp;
  using std::sin;
  const T turn = e[1] * optics::radians(1.0), ratio = exp(e[0]);
  const T along = cos(turn) * f.half_x + sin(turn) * f.half_y;
  const T across = (cos(turn) * f.half_y - sin(turn) * f.half_x) / ratio;
  const A cos2 = f.cos_h * f.cos_h;
  const T density = exp(T(-0.5 * (along * along + across * across) / (p[2] * p[2]))) /
                    (2.0 * optics::pi * p[2] * p[2] * ratio * (cos2 * cos2)) *
                    brdf::shadowing_factor(brdf::Shadowing::smith, p[2], std::span<const T>{}, f);
  add_facets(m, p[0], p[1], T(p[3] * (density - gaussian_lobe(p[2], f))), f);
}

/// Mueller BRDF of the sample as it is.
template <class T, class A>
optics::Mueller<T> sample_mueller(const Material<T>& material, const brdf::Geometry<A>& geometry,
                                  const Switched<T>& on) {
  using std::cos;
  using std::exp;
  const brdf::FacetFrame<A> f = brdf::facet_frame(geometry);
  optics::Mueller<T> m =
      brdf::evaluate(*material.model, material.parameters, material.wavelength_um, geometry, f);
  if (!(optics::value_of(f.cos_i) > 0.0) || !(optics::value_of(f.cos_r) > 0.0)) return m;
  add_free_forms(m, material, f, on);
  // cos of the angle to the way back to the source, from |k_r - k_i|² = 4 cos²θd.
  const A cos_retro = 2.0 * f.cos_d * f.cos_d - 1.0;

  if (material.lobe >= 0) {
    const auto* p = &material.parameters[static_cast<std::size_t>(material.lobe)];
    if (const T* e = on[EffectId::long_tails]) {
      const std::array<T, 3> tailed{p[0], p[1], T(p[2] * std::numbers::sqrt2)};
      const T share = e[0] * p[3];
      const brdf::FacetMatrix<T> ggx =
          brdf::ggx(std::span<const T>(tailed), brdf::Shadowing::smith, f);
      brdf::add_facet(
          m,
          brdf::FacetMatrix<T>{T(share * ggx.m00), T(share * ggx.m01), T(share * ggx.m11),
                               T(share * ggx.m22), T(share * ggx.m23)},
          f);
      add_facets(m, p[0], p[1], T(-share * gaussian_lobe(p[2], f)), f);
    }
    if (const T* e = on[EffectId::wave_lobe])
      add_facets(m, p[0], p[1], T(p[3] * wave_excess(p[2], e, material.wavelength_um, f)), f);
    if (const T* e = on[EffectId::second_roughness]) {
      const T other = p[2] * e[1];
      add_facets(m, p[0], p[1], T(e[0] * p[3] * (gaussian_lobe(other, f) - gaussian_lobe(p[2], f))),
                 f);
    }
    if (const T* e = on[EffectId::anisotropic_slopes]) add_anisotropic(m, p, e, f);
    if (const T* e = on[EffectId::near_specular_lobe])
      add_facets(m, p[0], p[1], T(e[0] * gaussian_lobe(e[1], f)), f);
    if (const T* e = on[EffectId::interface_diffuse]) {
      const auto through = [](const auto& n, const auto& kappa, const auto& cosine) {
        return optics::transmittance(n, kappa, cosine);
      };
      const T t =
          brdf::lifted(p[0], p[1], f.cos_i, through) * brdf::lifted(p[0], p[1], f.cos_r, through);
      // Against a Lambertian of the same parameter: only its shape is new.
      brdf::add_depolarized(m, T(e[material.wavelength] * (t - 0.9)));
    }
  }
  if (const T* e = on[EffectId::volume_diffuse])
    brdf::add_depolarized(m, T(e[material.wavelength] * (2.0 / (f.cos_i + f.cos_r) - 1.0)));
  if (const T* e = on[EffectId::polarised_diffuse]) {
    m[1][1] += e[material.wavelength];
    m[2][2] -= e[material.wavelength];
  }
  if (const T* e = on[EffectId::forward_lobe]) {
    // Heights by wavelength, then width, kept polarisation (P11) and what it is kept about.
    const T width = e[on.wavelengths] * optics::radians(1.0);
    const T lobe =
        e[material.wavelength] * exp(T(-0.5 * brdf::squared_angle(f.chord2) / (width * width)));
    const T kept = e[on.wavelengths + 1] * lobe;
    if (optics::value_of(e[on.wavelengths + 2]) < 0.5) {
      brdf::add_facet(m, brdf::FacetMatrix<T>{lobe, T(0.0), kept, T(-kept), T(0.0)}, f);
    } else {
      m[0][0] += lobe;
      m[1][1] += kept;
      m[2][2] -= kept;
      m[3][3] -= kept;
    }
  }
  if (const T* e = on[EffectId::retroreflection_peak]) {
    const T width = e[1] * optics::radians(1.0);
    // 2 (1 - cos β) is the squared chord: β² near the peak.
    brdf::add_depolarized(m, T(e[0] * exp(T(-(1.0 - cos_retro) / (width * width)))));
  }
  if (const T* e = on[EffectId::water_film]) {
    const T dry = diffuse_part(material, f, m);
    const T wet = dry * water_transmittance<T>(f.cos_i) * water_transmittance<T>(f.cos_r) /
                  (water_index * water_index);
    optics::Mueller<T> film(T(0.0));
    brdf::add_depolarized(film, wet);
    if (material.lobe >= 0) {
      const T slope = material.parameters[static_cast<std::size_t>(material.lobe) + 2] * e[1];
      add_facets(film, T(water_index), T(0.0), gaussian_lobe(slope, f), f);
    }
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) m[c][r] += e[0] * (film[c][r] - m[c][r]);
  }
  if (const T* e = on[EffectId::water_drops]) {
    // Normals of a spherical cap: even in projected area up to the contact angle.
    using std::sin;
    const T contact = e[1] * optics::radians(1.0);
    const T rim = sin(contact);
    const A sine2_h = f.tan2_h * f.cos_h * f.cos_h;
    const T inside = 1.0 / (1.0 + exp(T((sine2_h / (rim * rim) - 1.0) * 20.0)));
    const T dry = diffuse_part(material, f, m);
    const T wet = dry * water_transmittance<T>(f.cos_i) * water_transmittance<T>(f.cos_r) /
                  (water_index * water_index);
    optics::Mueller<T> caps(T(0.0));
    brdf::add_depolarized(caps, wet);
    add_facets(caps, T(water_index), T(0.0), T(inside / (optics::pi * rim * rim)), f);
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) m[c][r] += e[0] * (caps[c][r] - m[c][r]);
  }
  if (const T* e = on[EffectId::dust]) {
    const T depth = e[0] * (0.633 / material.wavelength_um);
    const A path = 1.0 / f.cos_i + 1.0 / f.cos_r;
    const T lost = 1.0 - exp(T(-depth * path));
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) m[c][r] -= lost * m[c][r];
    brdf::add_depolarized(m, T(e[2] * phase_function(e[1], A(-cos_retro)) * lost /
                               (4.0 * optics::pi * (f.cos_i + f.cos_r))));
  }
  return m;
}

}  // namespace umov::gap::scan
