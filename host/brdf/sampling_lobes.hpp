// Proposals: distributions of exit directions that can be drawn from exactly and whose density is
// known exactly. A sampler mixes them.
//
// Each has `draw(in, u1, u2, u3)`, a unit vector that may lie below the horizon, and `pdf(in,
// exit)`, the density per steradian of what draw() gives above the horizon. u1, u2, u3 are uniform
// in [0, 1).
#pragma once

#include "host/brdf/model.hpp"
#include "host/brdf/sampling_directions.hpp"

namespace umov::brdf {

/// cos θr/π.
struct CosineLobe {
  optics::Vec3<double> draw(const Incidence& in, double u1, double u2, double u3) const;
  double pdf(const Incidence& in, const Exit& exit) const;
  bool operator==(const CosineLobe&) const = default;
};

/// 1/2π over the hemisphere.
struct UniformLobe {
  optics::Vec3<double> draw(const Incidence& in, double u1, double u2, double u3) const;
  double pdf(const Incidence& in, const Exit& exit) const;
  bool operator==(const UniformLobe&) const = default;
};

/// Mirror reflection at the facets that the incident light sees on a surface with Gaussian slopes
/// (Heitz and d'Eon 2014): slopes with density p(hx) p(hy) (cos θi - sin θi hx)₊ over its integral
/// cos θi (1 + Λ). The slope along the plane of incidence and the one across it are independent.
struct GaussianFacetLobe {
  double slope_x, slope_y;  ///< rms slopes along and across the plane of incidence

  optics::Vec3<double> draw(const Incidence& in, double u1, double u2, double u3) const;
  double pdf(const Incidence& in, const Exit& exit) const;
  bool operator==(const GaussianFacetLobe&) const = default;
};

/// The same for Trowbridge-Reitz slopes, by the cap of the sphere that the ellipsoid of normals
/// maps to (Dupuy and Benyoub 2023).
struct GgxFacetLobe {
  double alpha;

  optics::Vec3<double> draw(const Incidence& in, double u1, double u2, double u3) const;
  double pdf(const Incidence& in, const Exit& exit) const;
  bool operator==(const GgxFacetLobe&) const = default;
};

/// Mirror reflection at the walls of symmetric V-grooves whose slopes have the density `law`: a
/// groove is drawn, then the wall of it that the light sees, with the share it sees of each (Heitz
/// 2014). Serves any symmetric density of slopes; exact for V-groove shadowing.
struct GrooveLobe {
  enum class Law { gaussian, exponential, trowbridge_reitz };
  Law law;
  double width;  ///< rms slope along one direction; α for trowbridge_reitz

  optics::Vec3<double> draw(const Incidence& in, double u1, double u2, double u3) const;
  double pdf(const Incidence& in, const Exit& exit) const;
  bool operator==(const GrooveLobe&) const = default;
};

/// (e + 1)/2π · cosᵉα about the mirror direction, α < 90°.
struct CosinePowerLobe {
  double exponent;

  optics::Vec3<double> draw(const Incidence& in, double u1, double u2, double u3) const;
  double pdf(const Incidence& in, const Exit& exit) const;
  bool operator==(const CosinePowerLobe&) const = default;
};

/// exp(-chord²/2w²) about the mirror direction, chord = 2 sin(α/2): wider everywhere than the
/// Gaussian of the angle α itself, and drawn in closed form.
struct ChordLobe {
  double width;  ///< w, radians

  optics::Vec3<double> draw(const Incidence& in, double u1, double u2, double u3) const;
  double pdf(const Incidence& in, const Exit& exit) const;
  bool operator==(const ChordLobe&) const = default;
};

}  // namespace umov::brdf
