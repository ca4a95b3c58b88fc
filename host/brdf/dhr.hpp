// Directional-hemispherical reflectance of a model (P2).
#pragma once

#include <span>

#include "host/brdf/model.hpp"

namespace umov::brdf {

/// For unpolarised, s- and p-polarised incident light.
struct Dhr {
  double unpolarized, s, p;
};

/// ∫ BRDF cos θr dω over the reflected hemisphere, by adaptive quadrature, to 1e-6 (absolute below
/// 1, relative above) for lobes of any width that the parameters' ranges allow. `theta_i` in [0,
/// π/2), radians. The mirror part is not in it: see mirror_dhr(). Throws umov::Error for angles or
/// parameters out of range.
Dhr dhr(const Model& model, std::span<const double> parameters, double wavelength_um,
        double theta_i);

/// What the mirror part adds: 0 for models without one.
Dhr mirror_dhr(const Model& model, std::span<const double> parameters, double wavelength_um,
               double theta_i);

}  // namespace umov::brdf
