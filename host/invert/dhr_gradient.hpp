// How the directional-hemispherical reflectance moves with the free parameters.
#pragma once

#include <Eigen/Core>
#include <span>

#include "host/invert/layout.hpp"

namespace umov::invert {

/// dDHR/dx for unpolarised light at `theta_i` (radians), mirror part included, by a fixed rule of a
/// few hundred directions that crowd about the mirror direction: good to about 1 %, which an
/// uncertainty can stand. `value`, if given, receives the rule's own DHR.
Eigen::VectorXd dhr_gradient(const Layout& layout, std::span<const double> x,
                             std::size_t wavelength, double theta_i, double* value = nullptr);

}  // namespace umov::invert
