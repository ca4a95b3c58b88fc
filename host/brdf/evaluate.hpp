// The value of a model: its Mueller BRDF, and its mirror part.
//
// Templates over the scalar T of the parameters, so that one definition serves simulation (double)
// and fitting (dual numbers such as ceres::Jet). The angles are double, or T when derivatives with
// respect to them are wanted; double angles are much the faster.
#pragma once

#include <span>
#include <type_traits>

#include "host/brdf/beard_maxwell.hpp"
#include "host/brdf/diffuse.hpp"
#include "host/brdf/facet.hpp"
#include "host/brdf/he_torrance.hpp"
#include "host/brdf/li_torrance.hpp"
#include "host/brdf/microfacet.hpp"
#include "host/brdf/model.hpp"
#include "host/brdf/phong_ward.hpp"
#include "host/brdf/rayleigh_rice.hpp"
#include "host/brdf/tabulated.hpp"
#include "host/brdf/volume.hpp"
#include "host/optics/fresnel.hpp"
#include "host/optics/mueller.hpp"

namespace umov::brdf {

template <class T, class A>
optics::Mueller<T> evaluate(const Model& model, std::span<const T> parameters, double wavelength_um,
                            const Geometry<A>& geometry, const FacetFrame<A>& frame);

/// Mueller BRDF in 1/sr, element (row, column) = (outgoing, incoming), in the {s, p} bases of
/// docs/physics.md. `parameters` are in the order of model.parameters() and within their ranges
/// (not checked here: model.check()). `wavelength_um` is the vacuum wavelength. Directions at or
/// below the horizon give 0. Throws umov::Error for a tabulated part without its table. The mirror
/// part of he-torrance, li-torrance and rayleigh-rice has no finite BRDF and is not in it:
/// mirror_reflectance().
template <class T, class A>
optics::Mueller<T> evaluate(const Model& model, std::span<const T> parameters, double wavelength_um,
                            const Geometry<A>& geometry) {
  return evaluate(model, parameters, wavelength_um, geometry, facet_frame(geometry));
}

/// The same for who has the `frame` of the `geometry` already.
template <class T, class A>
optics::Mueller<T> evaluate(const Model& model, std::span<const T> parameters, double wavelength_um,
                            const Geometry<A>& geometry, const FacetFrame<A>& frame) {
  static_assert(std::is_same_v<A, double> || std::is_same_v<A, T>);
  optics::Mueller<T> sum(T(0.0));
  if (!(optics::value_of(frame.cos_i) > 0.0) || !(optics::value_of(frame.cos_r) > 0.0)) return sum;
  for (const Component& part : model.components()) {
    const std::span<const T> p = parameters.subspan(part.first, part.count);
    switch (part.kind) {
      case Kind::lambertian:
        add_depolarized(sum, lambertian(p));
        break;
      case Kind::nef:
        add_depolarized(sum, nef(p, frame));
        break;
      case Kind::microfacet:
        add_facet(sum, microfacet(p, part.slopes, part.shadowing, frame), frame);
        break;
      case Kind::ggx:
        add_facet(sum, ggx(p, part.shadowing, frame), frame);
        break;
      case Kind::he_torrance:
        add_facet(sum, he_torrance(p, wavelength_um, frame), frame);
        break;
      case Kind::li_torrance:
        add_facet(sum, li_torrance_directional(p, wavelength_um, frame), frame);
        add_depolarized(sum, li_torrance_diffuse(p, frame));
        break;
      case Kind::rayleigh_rice:
        add_rayleigh_rice(sum, p, part.psd, wavelength_um, geometry, frame);
        break;
      case Kind::beard_maxwell:
        add_facet(sum, beard_maxwell_surface(p, part.slopes, part.shadowing, frame), frame);
        add_depolarized(sum, beard_maxwell_volume(p.last(2), frame));
        break;
      case Kind::subsurface:
        add_crossed_twice(sum, p[0], body_brdf(p[0], p[1]), frame);
        break;
      case Kind::single_scatter:
        add_crossed_twice(sum, p[0], single_scattering_brdf(p, geometry, frame), frame);
        break;
      case Kind::phong:
        add_depolarized(sum, phong(p, frame));
        break;
      case Kind::ward:
        add_depolarized(sum, ward(p, frame));
        break;
      case Kind::tabulated:
        if (!part.table) refuse_missing_table(model);
        add_tabulated(sum, *part.table, wavelength_um, geometry);
        break;
    }
  }
  return sum;
}

/// What leaves exactly in the mirror direction, as a dimensionless Mueller reflectance: e^(-g) |F|²
/// S of the smooth share of a he-torrance or li-torrance surface (P10), R e^(-g) of rayleigh-rice
/// (P13), 0 for other models.
/// An instrument that takes in the solid angle ΔΩ around the mirror direction sees it as a BRDF of
/// mirror/(cos θr ΔΩ).
template <class T, class A>
optics::Mueller<T> mirror_reflectance(const Model& model, std::span<const T> parameters,
                                      double wavelength_um, const A& theta_i) {
  static_assert(std::is_same_v<A, double> || std::is_same_v<A, T>);
  optics::Mueller<T> sum(T(0.0));
  const FacetFrame<A> frame = facet_frame(Geometry<A>{theta_i, theta_i, A(0.0)});
  if (!(optics::value_of(frame.cos_i) > 0.0)) return sum;
  for (const Component& part : model.components()) {
    const std::span<const T> p = parameters.subspan(part.first, part.count);
    if (part.kind == Kind::he_torrance) {
      add_facet(sum, he_torrance_mirror(p, wavelength_um, frame), frame);
    } else if (part.kind == Kind::li_torrance) {
      add_facet(sum, li_torrance_mirror(p, wavelength_um, frame), frame);
    } else if (part.kind == Kind::rayleigh_rice) {
      add_facet(sum, rayleigh_rice_mirror(p, part.psd, wavelength_um, frame), frame);
    }
  }
  return sum;
}

extern template optics::Mueller<double> evaluate<double, double>(const Model&,
                                                                 std::span<const double>, double,
                                                                 const Geometry<double>&);
extern template optics::Mueller<double> evaluate<double, double>(const Model&,
                                                                 std::span<const double>, double,
                                                                 const Geometry<double>&,
                                                                 const FacetFrame<double>&);
extern template optics::Mueller<double> mirror_reflectance<double, double>(const Model&,
                                                                           std::span<const double>,
                                                                           double, const double&);

}  // namespace umov::brdf
