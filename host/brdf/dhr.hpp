// Directional-hemispherical reflectance of a model (P2).
#pragma once

#include <span>

#include "host/brdf/model.hpp"

namespace umov::brdf {

/// For unpolarised, s- and p-polarised incident light.
struct Dhr {
  double unpolarized, s, p;
  double accuracy = 0.0;  ///< the quadrature's estimate of its error, of the worst of the three
};

/// ∫ BRDF cos θr dω over the reflected hemisphere, by adaptive quadrature that aims at 1e-6
/// (absolute below 1, relative above); `accuracy` says what was reached. For tables see
/// integrate_table(). `theta_i` in [0, π/2), radians. The
/// mirror part is not in it: see mirror_dhr(). Throws umov::Error for angles or
/// parameters out of range, or a tabulated part without its table.
Dhr dhr(const Model& model, std::span<const double> parameters, double wavelength_um,
        double theta_i);

/// What the mirror part adds: 0 for models without one.
Dhr mirror_dhr(const Model& model, std::span<const double> parameters, double wavelength_um,
               double theta_i);

}  // namespace umov::brdf
