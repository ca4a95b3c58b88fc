// Bundles of rays about a beam: quadrature nodes over a disc and over a Gaussian divergence.
#pragma once

#include <vector>

#include "hil/plant/sample.hpp"

namespace umov::plant {

/// A ray with the basis that an axis-bound polariser gives it, and its share of the bundle.
struct Ray {
  Beam beam;
  double weight;
};

/// The beam turned by `angle` radians towards the azimuth `turn` in its own basis (0 = towards s,
/// π/2 = towards p); s is projected across the new direction.
Beam tilted(const Beam& beam, double angle, double turn);

/// Rays over the disc of `half_angle` radians about `beam`, uniform in solid angle. One ray for 0.
/// Exact for smooth functions to 5th order in the angle, to 9th above 0.01 rad.
std::vector<Ray> disc_rays(const Beam& beam, double half_angle);

/// Rays with Gaussian angles of `rms` radians an axis. Exact to 3rd order, to 5th above 0.002 rad.
std::vector<Ray> gaussian_rays(const Beam& beam, double rms);

}  // namespace umov::plant
