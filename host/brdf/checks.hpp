// Does a model obey the physics that its formula doesn't enforce: energy, reciprocity,
// realisability? Numbers, not verdicts. The figures of every model: docs/models.md.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/brdf/facet.hpp"
#include "host/brdf/model.hpp"
#include "host/optics/mueller.hpp"

namespace umov::brdf {

/// The values with every loss that a parameter stands for taken out, so that the reflectance of an
/// energy-conserving model is 1: interfaces become a nearly perfect conductor (n = 0.05, κ = 100,
/// which absorbs 2e-5 at normal incidence and 1e-3 of p-polarised light at most, near 89.4°),
/// albedos and scales 1; of li-torrance only the He-Torrance lobe stays. Nothing for sums and for
/// models whose parameters do not bound their reflectance (nef, beard-maxwell, tabulated).
std::optional<std::vector<double>> lossless(const Model& model, std::span<const double> values);

/// The worst case over many geometries, and where it is.
struct WorstCase {
  double amount = 0.0;
  Geometry<double> geometry{0.0, 0.0, 0.0};
};

/// Largest element of |f(θi → θr, φ) - D f(θr → θi, -φ)ᵀ D| relative to the larger of both m00
/// (P6): 0 for a reciprocal model, at most 2. Over `geometries` directions, half of them spread
/// over both hemispheres up to 85°, half crowded about the mirror direction.
WorstCase reciprocity_violation(const Model& model, std::span<const double> values,
                                double wavelength_um, int geometries);

/// How far a Mueller matrix is from any mixture of pure ones (Cloude 1986): minus the smallest
/// eigenvalue of its coherency matrix over m00, the eigenvalues adding up to m00. 0 (or below, by
/// rounding) for a realisable matrix, at most 1/2.
double unrealisable_share(const optics::Mueller<double>& m);

/// The worst unrealisable_share() over the same directions.
WorstCase realisability_violation(const Model& model, std::span<const double> values,
                                  double wavelength_um, int geometries);

}  // namespace umov::brdf
