// The base model's material as the effects of a sample see it: its facet lobe and the rest.
#pragma once

#include <cstddef>
#include <numbers>
#include <span>

#include "host/brdf/evaluate.hpp"
#include "host/brdf/he_torrance.hpp"
#include "host/gap/scan/effect_list.hpp"

namespace umov::gap::scan {

/// The base model with its parameters at one wavelength. `lobe` is the place of n, κ, slope_rms and
/// bias of its first facet lobe in them, -1 where it has none.
template <class T>
struct Material {
  const brdf::Model* model;
  std::span<const T> parameters;
  double wavelength_um;
  std::size_t wavelength;  ///< number
  int lobe;
};

/// Polarised facets with a density of slopes `density` (per P8, cos^-4 included).
template <class T, class A>
void add_facets(optics::Mueller<T>& sum, const T& n, const T& kappa, const T& density,
                const brdf::FacetFrame<A>& f) {
  const T scale = density * (0.25 / (f.cos_i * f.cos_r));
  brdf::add_facet(sum, brdf::scaled_reflection(brdf::facet_reflection(n, kappa, f.cos_d), scale),
                  f);
}

template <class T, class A>
T gaussian_lobe(const T& slope_rms, const brdf::FacetFrame<A>& f) {
  return brdf::slope_density(brdf::Slopes::gaussian, slope_rms, f) *
         brdf::shadowing_factor(brdf::Shadowing::smith, slope_rms, std::span<const T>{}, f);
}

/// The same facets where heights are not large against the wavelength: e[0] of the lobe is He and
/// Torrance's of the same slope, for rms heights of 1/e[1] µm (see wave_lobe in the catalogue).
/// What is returned is what it is above the Gaussian lobe.
template <class T, class A>
T wave_excess(const T& slope_rms, const T* e, double wavelength_um, const brdf::FacetFrame<A>& f) {
  const T height_um = 1.0 / e[1];
  const T length_um = height_um * (std::numbers::sqrt2 / slope_rms);
  const T lobe = brdf::height_lobe(height_um, length_um, wavelength_um, f);
  return e[0] * (lobe * (4.0 * f.cos_i * f.cos_r) - gaussian_lobe(slope_rms, f));
}

/// Depolarised light of the base at this geometry: what its facets do not explain. Its facets
/// polarise, so the part of m00 that the base's diffuse terms give is found by leaving them out.
template <class T, class A>
T diffuse_part(const Material<T>& material, const brdf::FacetFrame<A>& f,
               const optics::Mueller<T>& all) {
  if (material.lobe < 0) return all[0][0];
  optics::Mueller<T> lobe(T(0.0));
  const auto* p = &material.parameters[static_cast<std::size_t>(material.lobe)];
  add_facets(lobe, p[0], p[1], T(p[3] * gaussian_lobe(p[2], f)), f);
  return all[0][0] - lobe[0][0];
}

}  // namespace umov::gap::scan
