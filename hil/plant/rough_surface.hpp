// Light scattered once by a random rough interface: the He–Torrance directional-diffuse term (P10)
// with its mirror part, and the Gaussian-facet form (P8).
//
// Source: X. D. He, K. E. Torrance, F. X. Sillion, D. P. Greenberg, "A comprehensive physical model
// for light reflection", SIGGRAPH 1991. Assumes a stationary Gaussian height process with Gaussian
// autocorrelation; no multiple scattering between facets, so it loses energy on rough surfaces.
#pragma once

#include "hil/plant/sample.hpp"

namespace umov::plant {

/// Cosines and phase shift of a pair of directions that the scalar factors need.
struct HeightStatistics {
  double sigma_um = 0.0;  ///< rms height of the whole surface (σ0)
  double tau_um = 0.0;    ///< autocorrelation length

  /// rms height of the part that light at these cosines sees: σ of P10, in µm.
  double visible_sigma_um(double cos_i, double cos_r) const;
  /// S(θi) S(θr) of P10.
  double shadowing(double cos_i, double cos_r) const;
  /// g of P10, from the visible height.
  double roughness_phase(double cos_i, double cos_r, double wavelength_um) const;
};

/// G S D / (π cos θi cos θr) of P10 [1/sr]: all but |F|². Unit directions of travel in the sample
/// frame, k_i.z < 0 < k_r.z. Any g: the series is summed around its largest term.
double directional_diffuse_factor(const HeightStatistics& surface, const Vec3& k_i, const Vec3& k_r,
                                  double wavelength_um);

/// Σ_{m>=1} g^m e^{-g} / (m! m) · exp(-a/m), the sum in D, for g > 0 and a >= 0. Relative error <
/// 1e-9.
double phase_series(double g, double a);

/// P S / (4 cos θi cos θr) of P8 [1/sr] with 1-D rms slope and the product form of Smith's
/// shadowing.
double facet_factor(double slope_rms, const Vec3& k_i, const Vec3& k_r);

/// cos of the local angle of incidence on the facet that mirrors k_i into k_r.
double facet_cosine(const Vec3& k_i, const Vec3& k_r);

/// Fresnel Mueller matrix of the facet that mirrors `in` into `out`, in the bases of the beams.
Mueller facet_reflection(double n, double kappa, const Beam& in, const Beam& out);

}  // namespace umov::plant
