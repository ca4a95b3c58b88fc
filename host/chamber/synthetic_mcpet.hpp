// A synthetic white plastic in the place of [M]'s MCPET, whose measured curves are not published as
// numbers: nearly Lambertian, with a lobe about the mirror direction that grows to grazing.
//
// Made of the library's models: facets (Trowbridge and Reitz, width 0.1) of a plastic of n = 1.6
// over a white body, `ggx+subsurface`, each incidence scaled to reflect R_total = 0.984 as [M]'s
// sphere found. Chosen for its kind; no parameter was fitted to any of [M]'s figures.
#pragma once

#include <span>
#include <vector>

#include "host/brdf/planes_table.hpp"
#include "host/chamber/surface.hpp"

namespace umov::chamber {

inline constexpr double mcpet_total = 0.984;
/// [M]'s incidences.
inline constexpr double mcpet_theta_i_deg[] = {5.0, 25.0, 45.0, 60.0, 70.0, 80.0};

/// The table that a goniometer would find at these incidences, every `step_deg` in both planes, at
/// 555 nm.
brdf::PlanesTable synthetic_mcpet(std::span<const double> theta_i_deg, double step_deg);
/// The same with a lobe of another width, facets of `alpha`, scaled to reflect `total`.
brdf::PlanesTable synthetic_plastic(double alpha, std::span<const double> theta_i_deg,
                                    double step_deg, double total = mcpet_total);

/// As much as anybody would want to know of it: an incidence every 2.5°, angles every 0.5°.
brdf::PlanesTable dense_mcpet();

/// What an aperture of 2.5° half angle about the mirror direction gets at an incidence, less the
/// diffuse level beside it (60° across): a specular reflectance as [M] measured it.
double mcpet_specular(double theta_i_deg);
/// [M]'s second model of it.
DiffuseSpecular mcpet_diffuse_specular();

}  // namespace umov::chamber
