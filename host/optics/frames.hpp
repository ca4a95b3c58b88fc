// Directions of travel, the {s, p} bases on them, and rotations into a scattering plane
// (docs/physics.md, 1).
//
// Sample frame: +z is the surface normal, x lies in the plane of incidence. φ = 0 is the forward
// (mirror) half plane; a negative θr with φ = 0 is the retro side.
#pragma once

#include <cmath>

#include "host/optics/dual.hpp"
#include "host/optics/mueller.hpp"

namespace umov::optics {

template <class T>
T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class T>
Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return Vec3<T>(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/// A beam: unit direction of travel k and the unit vectors s, p with p = k × s.
template <class T>
struct Beam {
  Vec3<T> s, p, k;
};

/// Direction of travel of light that comes in at `theta_i` (radians, >= 0): (sin θi, 0, -cos θi).
template <class T>
Vec3<T> incident_direction(const T& theta_i) {
  using std::cos;
  using std::sin;
  return Vec3<T>(sin(theta_i), T(0.0), T(-cos(theta_i)));
}

/// Direction of travel of light that leaves at `theta_r`, `phi_r` (radians; θr may be negative).
template <class T>
Vec3<T> exit_direction(const T& theta_r, const T& phi_r) {
  using std::cos;
  using std::sin;
  const T sine = sin(theta_r);
  return Vec3<T>(sine * cos(phi_r), sine * sin(phi_r), cos(theta_r));
}

/// The beam along unit vector `k`: s = (z × k)/|z × k|, and s = y where k is along z.
template <class T>
Beam<T> beam_along(const Vec3<T>& k) {
  const T sine2 = k.x * k.x + k.y * k.y;
  Vec3<T> s(T(0.0), T(1.0), T(0.0));
  if (value_of(sine2) > 1e-30) {
    const T scale = 1.0 / sqrt_or_zero(sine2);
    s = Vec3<T>(-k.y * scale, k.x * scale, T(0.0));
  }
  return {s, cross(k, s), k};
}

/// The incoming beam at `theta_i`, with s = y for every θi: the limit that normal incidence needs.
template <class T>
Beam<T> incident_beam(const T& theta_i) {
  const Vec3<T> k = incident_direction(theta_i);
  const Vec3<T> s(T(0.0), T(1.0), T(0.0));
  return {s, Vec3<T>(-k.z, T(0.0), k.x), k};
}

/// The outgoing beam at `theta_r`, `phi_r`, with s = (-sin φ, cos φ, 0) for every θr. For θr > 0
/// that is z × k normalised; at θr = 0 it is the limit along the half plane φ (y for φ = 0, where
/// an analyser on the detector arm stands); for θr < 0 s and p both change sign, which no Stokes
/// component sees.
template <class T>
Beam<T> exit_beam(const T& theta_r, const T& phi_r) {
  using std::cos;
  using std::sin;
  const T cos_phi = cos(phi_r);
  const T sin_phi = sin(phi_r);
  const T cosine = cos(theta_r);
  const T sine = sin(theta_r);
  return {Vec3<T>(-sin_phi, cos_phi, T(0.0)), Vec3<T>(-cosine * cos_phi, -cosine * sin_phi, sine),
          Vec3<T>(sine * cos_phi, sine * sin_phi, cosine)};
}

/// cos 2β and sin 2β of a basis change.
template <class T>
struct DoubleAngle {
  T cos2, sin2;
};

/// Rotation from the basis of `beam` to the basis whose s points along `normal` (any length,
/// transverse to the beam up to rounding): s' = s cos β + p sin β.
template <class T>
DoubleAngle<T> rotation_to(const Beam<T>& beam, const Vec3<T>& normal) {
  const T c = dot(normal, beam.s);
  const T s = dot(normal, beam.p);
  const T scale = 1.0 / (c * c + s * s);
  return {(c * c - s * s) * scale, 2.0 * c * s * scale};
}

/// Unnormalised normal k_i × k_r of the plane that two beams span. Where they are (anti)parallel
/// within 1e-12 rad no plane is defined, and none is needed (reflection at normal incidence or at
/// grazing commutes with rotations about the beam): then the incoming s serves.
template <class T>
Vec3<T> scattering_plane_normal(const Beam<T>& in, const Beam<T>& out) {
  const Vec3<T> normal = cross(in.k, out.k);
  if (value_of(dot(normal, normal)) > 1e-24) return normal;
  return in.s;
}

/// M given in the plane with `normal`, seen in the beams' own bases: R(-β_out) · M · R(β_in).
template <class T>
Mueller<T> to_beam_bases(const Mueller<T>& m, const Beam<T>& in, const Beam<T>& out,
                         const Vec3<T>& normal) {
  const DoubleAngle<T> entry = rotation_to(in, normal);
  const DoubleAngle<T> exit = rotation_to(out, normal);
  return product(rotation(exit.cos2, T(-exit.sin2)), product(m, rotation(entry.cos2, entry.sin2)));
}

}  // namespace umov::optics
