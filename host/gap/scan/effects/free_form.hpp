// Reflectance without a formula: what a lobe's slopes, its growth and the diffuse light may be
// where no family of models fits. Each is the base's own times a smooth series.
//
// All terms are functions of the half and difference angles, or even in an exchange of the two
// directions: they are reciprocal and isotropic, so that they cannot imitate a stage that is off.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "host/gap/scan/effects/material.hpp"

namespace umov::gap::scan {

/// A series among the parameters of an effect.
struct Series {
  SeriesId id;
  EffectId effect;
  std::size_t first;  ///< of its coefficients in the effect's parameters
  std::size_t terms;
  bool spectral;  ///< one set of coefficients for each wavelength, one behind the other
};

/// Densities of slopes: cubic B-splines, evenly spaced in ln(1 + (4u)²), u = tan θh over the base's
/// slope. The first is centred on the mirror direction, the last at six (ten) times the slope.
inline constexpr double slope_spacing = 0.5, fine_slope_spacing = 0.12;
inline constexpr std::size_t slope_terms = 14, fine_slope_terms = 62;
/// Highest orders of cos(k a) and T_l(b) in the growth of a lobe: a by the slope, b by the
/// difference angle. Constant terms are the base's own weights.
inline constexpr std::size_t lobe_orders_h = 6, lobe_orders_d = 4;
inline constexpr std::size_t growth_terms = lobe_orders_h * lobe_orders_d - 1;
/// Of the same at each wavelength, up to this sum of orders; the constant term is one of them.
inline constexpr std::size_t spectral_lobe_order = 2, spectral_lobe_terms = 6;
/// Of T_k T_l in the cosines of half and difference angle, up to these sums of orders.
inline constexpr std::size_t diffuse_order = 4, diffuse_shape_terms = 14;
inline constexpr std::size_t kept_order = 2, kept_terms = 6;
inline constexpr std::size_t spectral_diffuse_order = 2, spectral_diffuse_terms = 5;

/// Parameters of free_lobe behind its series and before those of each wavelength: its depolarised
/// part (two), its width (two).
inline constexpr std::size_t lobe_extra = 4;
/// Parameters of free_diffuse behind its series: polarisation by the surface that light crosses.
inline constexpr std::size_t diffuse_extra = 2;
/// Parameters of azimuthal_diffuse: depolarised terms and, last, one that keeps polarisation.
inline constexpr std::size_t azimuthal_terms = 5;
inline constexpr std::size_t most_terms = fine_slope_terms;

inline constexpr std::array<Series, series_count> all_series{
    {{SeriesId::slopes, EffectId::free_slopes, 0, slope_terms, false},
     {SeriesId::fine_slopes, EffectId::fine_slopes, 0, fine_slope_terms, false},
     {SeriesId::growth, EffectId::free_lobe, 0, growth_terms, false},
     {SeriesId::spectral_lobe, EffectId::spectral_lobe, 0, spectral_lobe_terms, true},
     {SeriesId::diffuse_shape, EffectId::free_diffuse, 0, diffuse_shape_terms, false},
     {SeriesId::kept, EffectId::free_diffuse, diffuse_shape_terms, kept_terms, false},
     {SeriesId::spectral_diffuse, EffectId::spectral_diffuse, 0, spectral_diffuse_terms, true}}};

/// A term's value and its derivatives to the two coordinates of its series.
struct Term {
  double value = 0, by_a = 0, by_b = 0;
};

/// A uniform cubic B-spline's value and derivative at a distance `x` of its centre.
inline std::array<double, 2> cubic_spline(double x) {
  const double a = std::abs(x), sign = x < 0 ? -1.0 : 1.0;
  if (a < 1.0) return {2.0 / 3.0 - a * a * (1.0 - 0.5 * a), sign * a * (1.5 * a - 2.0)};
  if (a < 2.0)
    return {(2.0 - a) * (2.0 - a) * (2.0 - a) / 6.0, -sign * 0.5 * (2.0 - a) * (2.0 - a)};
  return {0.0, 0.0};
}

/// Values and derivatives of Chebyshev's polynomials T_0, T_1 …
inline std::array<std::array<double, 2>, lobe_orders_h> chebyshev(double x) {
  std::array<std::array<double, 2>, lobe_orders_h> t{{{1.0, 0.0}, {x, 1.0}}};
  for (std::size_t k = 2; k < t.size(); ++k)
    t[k] = {2.0 * x * t[k - 1][0] - t[k - 2][0],
            2.0 * t[k - 1][0] + 2.0 * x * t[k - 1][1] - t[k - 2][1]};
  return t;
}

/// Calls `each(number, k, l)` for the terms of a series of products, in the order of their
/// coefficients.
template <class Each>
void for_each_product(SeriesId id, Each each) {
  std::size_t next = 0;
  const auto triangle = [&](std::size_t order, bool constant) {
    for (std::size_t k = 0; k <= order; ++k)
      for (std::size_t l = 0; k + l <= order; ++l)
        if (constant || k + l > 0) each(next++, k, l);
  };
  if (id == SeriesId::growth) {
    for (std::size_t k = 0; k < lobe_orders_h; ++k)
      for (std::size_t l = 0; l < lobe_orders_d; ++l)
        if (k + l > 0) each(next++, k, l);
  } else if (id == SeriesId::spectral_lobe) {
    triangle(spectral_lobe_order, true);
  } else if (id == SeriesId::diffuse_shape) {
    triangle(diffuse_order, false);
  } else if (id == SeriesId::kept) {
    triangle(kept_order, true);
  } else if (id == SeriesId::spectral_diffuse) {
    triangle(spectral_diffuse_order, false);
  }
}

/// Terms of a series at its coordinates.
inline void series_terms(SeriesId id, double a, double b, std::span<Term> out) {
  if (id == SeriesId::slopes || id == SeriesId::fine_slopes) {
    std::fill(out.begin(), out.end(), Term{});
    const auto first = static_cast<std::size_t>(std::max(0.0, std::floor(a) - 1.0));
    for (std::size_t j = first; j < std::min(out.size(), first + 4); ++j) {
      const auto [value, slope] = cubic_spline(a - static_cast<double>(j));
      out[j] = {value, slope, 0.0};
    }
    return;
  }
  const bool lobe = id == SeriesId::growth || id == SeriesId::spectral_lobe;
  // cos(k a) is T_k(cos a).
  const double x = lobe ? std::cos(a) : a;
  const double by_x = lobe ? -std::sin(a) : 1.0;
  const auto along_a = chebyshev(x), along_b = chebyshev(b);
  for_each_product(id, [&](std::size_t j, std::size_t k, std::size_t l) {
    out[j] = {along_a[k][0] * along_b[l][0], by_x * along_a[k][1] * along_b[l][0],
              along_a[k][0] * along_b[l][1]};
  });
}

/// First coordinate of a series: a place among slopes, or the cosine of the half angle.
template <class T, class A>
T series_place(SeriesId id, const T& slope, const brdf::FacetFrame<A>& f) {
  using std::log;
  const auto stretched = [&](double scale) {
    return T(log(T(1.0 + scale * (f.tan2_h / (slope * slope)))));
  };
  switch (id) {
    case SeriesId::slopes:
      return T(stretched(16.0) * (1.0 / slope_spacing));
    case SeriesId::fine_slopes:
      return T(stretched(16.0) * (1.0 / fine_slope_spacing));
    case SeriesId::growth:
    case SeriesId::spectral_lobe: {
      // Half a turn takes the mirror direction to forty times the slope.
      const double whole = std::log(1.0 + 4.0 * 40.0 * 40.0);
      return T(stretched(4.0) * (optics::pi / whole));
    }
    default:
      return T(2.0 * f.cos_h - 1.0);
  }
}

/// Terms of a series at a geometry, for a base of this slope: the derivatives of series_sum().
inline void series_basis(SeriesId id, double slope, const brdf::FacetFrame<double>& f,
                         std::span<Term> out) {
  series_terms(id, series_place(id, slope, f), 2.0 * f.cos_d - 1.0, out);
}

/// Σ c_j φ_j of a series that is switched on, else zero.
template <class T, class A>
T series_sum(SeriesId id, const Material<T>& material, const brdf::FacetFrame<A>& f,
             const Switched<T>& on) {
  const Series& series = all_series[static_cast<std::size_t>(id)];
  const T* coefficient = on[series.effect];
  T sum(0.0);
  if (coefficient == nullptr) return sum;
  coefficient += series.first;
  if (series.spectral) coefficient += material.wavelength * series.terms;
  const bool by_slope = material.lobe >= 0;
  const T place = series_place(
      id, by_slope ? material.parameters[static_cast<std::size_t>(material.lobe) + 2] : T(1.0), f);
  const A other = 2.0 * f.cos_d - 1.0;
  std::array<Term, most_terms> terms;
  const std::span<Term> used = std::span<Term>(terms).first(series.terms);
  series_terms(id, optics::value_of(place), optics::value_of(other), used);
  for (std::size_t j = 0; j < series.terms; ++j)
    if (terms[j].value != 0) sum += coefficient[j] * terms[j].value;
  if constexpr (optics::DualNumber<T>) {
    double by_a = 0, by_b = 0;
    for (std::size_t j = 0; j < series.terms; ++j) {
      by_a += optics::value_of(coefficient[j]) * terms[j].by_a;
      by_b += optics::value_of(coefficient[j]) * terms[j].by_b;
    }
    sum += by_a * (place - optics::value_of(place)) + by_b * (other - optics::value_of(other));
  }
  if (on.lift[static_cast<std::size_t>(id)] != nullptr)
    sum += *on.lift[static_cast<std::size_t>(id)];
  return sum;
}

template <class T, class A>
void add_free_lobes(optics::Mueller<T>& m, const Material<T>& material,
                    const brdf::FacetFrame<A>& f, const Switched<T>& on) {
  const T* p = &material.parameters[static_cast<std::size_t>(material.lobe)];
  const T* lobe = on[EffectId::free_lobe];
  const T weight =
      p[3] * brdf::shadowing_factor(brdf::Shadowing::smith, p[2], std::span<const T>{}, f);
  const T u2 = f.tan2_h / (p[2] * p[2]);
  // Longer tails than any lobe that is worth a name, its peak that of the Gaussian.
  const T reach = 1.0 + 0.25 * u2;
  const A cos2 = f.cos_h * f.cos_h;
  const T tailed = weight / (2.0 * optics::pi * p[2] * p[2] * reach * reach * (cos2 * cos2));
  T density(0.0);
  if (on[EffectId::free_slopes] != nullptr || on[EffectId::fine_slopes] != nullptr)
    density += tailed * (series_sum(SeriesId::slopes, material, f, on) +
                         series_sum(SeriesId::fine_slopes, material, f, on));
  if (lobe != nullptr || on[EffectId::spectral_lobe] != nullptr) {
    T own = weight * brdf::slope_density(brdf::Slopes::gaussian, p[2], f);
    if (const T* e = on[EffectId::wave_lobe])
      own += p[3] * wave_excess(p[2], e, material.wavelength_um, f);
    // Some of the tails too: where the Gaussian has ended there would be nothing to grow.
    density += (own + 0.2 * tailed) * (series_sum(SeriesId::growth, material, f, on) +
                                       series_sum(SeriesId::spectral_lobe, material, f, on));
    if (lobe != nullptr) {
      const T* e = lobe + growth_terms;
      const A x = 1.0 - f.cos_d;
      const T wider = 0.5 * u2 - 1.0;  // d ln(density)/d ln(slope²)
      density +=
          own * wider * (x * (e[2] + x * (2.0 * e[3])) + e[lobe_extra + material.wavelength]);
      // Four per cent is what facets of n = 1.5 reflect: terms are shares of the lobe.
      brdf::add_depolarized(m,
                            T((0.25 / (f.cos_i * f.cos_r)) * own * 0.04 * (e[0] + 2.0 * x * e[1])));
    }
  }
  add_facets(m, p[0], p[1], density, f);
}

/// Diffuse light's dependence on the azimuth where half and difference angle stay the same:
/// products of functions of either direction have it. Zero in the plane of incidence; one of the
/// angles' turns about the half direction exchanges the beams, so that only its cosine's square
/// counts.
template <class T, class A>
void add_azimuthal_diffuse(optics::Mueller<T>& m, const T& plain, const T* e,
                           const brdf::FacetFrame<A>& f) {
  const A h2 = f.cos_h * f.cos_h, d2 = f.cos_d * f.cos_d;
  // 4 sin²θh sin²θd sin²φd, since cos θi cos θr = cos²θh cos²θd - sin²θh sin²θd cos²φd.
  const A w = 4.0 * ((1.0 - h2) * (1.0 - d2) - h2 * d2 + f.cos_i * f.cos_r);
  brdf::add_depolarized(
      m, T(plain * w *
           (e[0] + e[1] * (2.0 * f.cos_h - 1.0) + e[2] * (2.0 * f.cos_d - 1.0) + e[3] * w)));
  const T kept = plain * w * e[4];
  brdf::add_facet(m, brdf::FacetMatrix<T>{T(0.0), T(0.0), kept, T(-kept), T(0.0)}, f);
}

template <class T, class A>
void add_free_forms(optics::Mueller<T>& m, const Material<T>& material,
                    const brdf::FacetFrame<A>& f, const Switched<T>& on) {
  const T* diffuse = on[EffectId::free_diffuse];
  const T* azimuthal = on[EffectId::azimuthal_diffuse];
  const bool diffuses =
      diffuse != nullptr || azimuthal != nullptr || on[EffectId::spectral_diffuse] != nullptr;
  T plain(0.0);
  if (diffuses) plain = diffuse_part(material, f, m);
  if (material.lobe >= 0 &&
      (on[EffectId::free_slopes] != nullptr || on[EffectId::fine_slopes] != nullptr ||
       on[EffectId::free_lobe] != nullptr || on[EffectId::spectral_lobe] != nullptr))
    add_free_lobes(m, material, f, on);
  if (!diffuses) return;
  if (azimuthal != nullptr) add_azimuthal_diffuse(m, plain, azimuthal, f);
  brdf::add_depolarized(m, T(plain * (series_sum(SeriesId::diffuse_shape, material, f, on) +
                                      series_sum(SeriesId::spectral_diffuse, material, f, on))));
  if (diffuse == nullptr) return;
  const T kept = plain * series_sum(SeriesId::kept, material, f, on);
  brdf::add_facet(m, brdf::FacetMatrix<T>{T(0.0), T(0.0), kept, T(-kept), T(0.0)}, f);
  // Light that enters or leaves obliquely is polarised by the surface that it crosses.
  const A i = 1.0 - f.cos_i, r = 1.0 - f.cos_r;
  const T* e = diffuse + diffuse_shape_terms + kept_terms;
  m[1][0] += plain * (i * (e[0] + e[1] * i));
  m[0][1] += plain * (r * (e[0] + e[1] * r));
}

}  // namespace umov::gap::scan
