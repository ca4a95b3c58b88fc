// Reflectance without a formula: what a lobe's slopes, its growth and the diffuse light may be
// where no family of models fits. Each is the base's own times a smooth series of few terms.
//
// All terms are functions of the half and difference angles, or even in an exchange of the two
// directions: they are reciprocal and isotropic, so that they cannot imitate a stage that is off.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "host/gap/scan/effects/material.hpp"

namespace umov::gap::scan {

/// Terms of the slopes' density: cubic B-splines, evenly spaced by `slope_spacing` in
/// ln(1 + (4u)²), u = tan θh over the base's slope. The first is centred on the mirror direction,
/// the last at six times the slope.
inline constexpr std::size_t slope_terms = 14;
inline constexpr double slope_spacing = 0.5;

/// A uniform cubic B-spline's value and derivative at a distance `x` of its centre.
inline std::array<double, 2> cubic_spline(double x) {
  const double a = std::abs(x), sign = x < 0 ? -1.0 : 1.0;
  if (a < 1.0) return {2.0 / 3.0 - a * a * (1.0 - 0.5 * a), sign * a * (1.5 * a - 2.0)};
  if (a < 2.0)
    return {(2.0 - a) * (2.0 - a) * (2.0 - a) / 6.0, -sign * 0.5 * (2.0 - a) * (2.0 - a)};
  return {0.0, 0.0};
}

/// Σ c_j B(place - j), with derivatives to the coefficients and the place.
template <class T>
T spline_series(const T* coefficient, std::size_t terms, const T& place) {
  const double x = optics::value_of(place);
  const double first = std::max(0.0, std::floor(x) - 1.0);
  T sum(0.0);
  double slope = 0.0;
  for (auto j = static_cast<std::size_t>(first);
       j < std::min(terms, static_cast<std::size_t>(first) + 4); ++j) {
    const auto [value, derivative] = cubic_spline(x - static_cast<double>(j));
    sum += coefficient[j] * value;
    slope += optics::value_of(coefficient[j]) * derivative;
  }
  return sum + slope * (place - x);
}

template <class T, class A>
T free_slope_density(const Material<T>& material, const T* coefficient,
                     const brdf::FacetFrame<A>& f) {
  using std::log;
  const T& slope = material.parameters[static_cast<std::size_t>(material.lobe) + 2];
  const T u2 = f.tan2_h / (slope * slope);
  const T place = log(T(1.0 + 16.0 * u2)) * (1.0 / slope_spacing);
  const T sum = spline_series(coefficient, slope_terms, place);
  // Longer tails than any lobe that is worth a name.
  const T reach = 1.0 + 0.25 * u2;
  const A cos2 = f.cos_h * f.cos_h;
  const T envelope = 1.0 / (2.0 * optics::pi * slope * slope * reach * reach * (cos2 * cos2));
  return sum * envelope *
         brdf::shadowing_factor(brdf::Shadowing::smith, slope, std::span<const T>{}, f);
}

/// Terms of free_lobe before those of each wavelength: growth of the lobe with the difference angle
/// (three), of its depolarised part (two), of its width (two).
inline constexpr std::size_t lobe_terms = 7;
/// Terms of free_diffuse: its shape (six), kept polarisation (two), polarisation by the surface
/// that it crosses (two).
inline constexpr std::size_t diffuse_terms = 10;

template <class T, class A>
void add_free_forms(optics::Mueller<T>& m, const Material<T>& material,
                    const brdf::FacetFrame<A>& f, const Switched<T>& on) {
  const T* slopes = on[EffectId::free_slopes];
  const T* lobe = on[EffectId::free_lobe];
  const T* diffuse = on[EffectId::free_diffuse];
  T plain(0.0);
  if (diffuse != nullptr) plain = diffuse_part(material, f, m);
  if (material.lobe >= 0 && (slopes != nullptr || lobe != nullptr)) {
    const T* p = &material.parameters[static_cast<std::size_t>(material.lobe)];
    const A x = 1.0 - f.cos_d;
    if (slopes != nullptr)
      add_facets(m, p[0], p[1], T(p[3] * free_slope_density(material, slopes, f)), f);
    if (lobe != nullptr) {
      const T u2 = f.tan2_h / (p[2] * p[2]);
      const T own = p[3] * gaussian_lobe(p[2], f);
      const T wider = 0.5 * u2 - 1.0;  // d ln(density)/d ln(slope²)
      const T growth =
          x * (lobe[0] + x * (2.0 * lobe[1] + x * (4.0 * lobe[2]))) +
          wider * (x * (lobe[5] + x * (2.0 * lobe[6])) + lobe[lobe_terms + material.wavelength]);
      add_facets(m, p[0], p[1], T(own * growth), f);
      // Four per cent is what facets of n = 1.5 reflect: terms are shares of the lobe.
      brdf::add_depolarized(
          m, T((0.25 / (f.cos_i * f.cos_r)) * own * 0.04 * (lobe[3] + 2.0 * x * lobe[4])));
    }
  }
  if (diffuse != nullptr) {
    const A i = 1.0 - f.cos_i, r = 1.0 - f.cos_r;
    const A both = i * r, either = i + r;
    const A forward = 1.0 - 2.0 * f.cos_d * f.cos_d;  // cos of the angle between the beams' ways
    const T shape = diffuse[0] * either + diffuse[1] * both + diffuse[2] * (either * either) +
                    diffuse[3] * (both * both) + diffuse[4] * forward +
                    diffuse[5] * (forward * forward);
    const T kept = diffuse[6] + diffuse[7] * forward;
    m[0][0] += plain * shape;
    m[1][1] += plain * kept;
    m[2][2] -= plain * kept;
    // Light that enters or leaves obliquely is polarised by the surface that it crosses.
    const T entering = plain * (i * (diffuse[8] + diffuse[9] * i));
    const T leaving = plain * (r * (diffuse[8] + diffuse[9] * r));
    m[1][0] += entering;
    m[0][1] += leaving;
  }
}

}  // namespace umov::gap::scan
