// Diffuse terms that depolarise completely: Lambertian and the two-parameter form of P9.
#pragma once

#include <span>

#include "host/brdf/facet.hpp"

namespace umov::brdf {

/// Parameter: rho, the hemispherical reflectance.
template <class T>
T lambertian(std::span<const T> p) {
  return p[0] * (1.0 / optics::pi);
}

/// P9. Parameters: rho_d1, rho_d2 in 1/sr. The second term grows without bound towards grazing.
template <class T, class A>
T nef(std::span<const T> p, const FacetFrame<A>& f) {
  return p[0] + p[1] * (1.0 / (f.cos_i * f.cos_r));
}

}  // namespace umov::brdf
