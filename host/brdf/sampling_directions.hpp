// Directions as samplers and integrals see them: an incidence, and an exit direction with the
// slopes of the facet that mirrors one into the other.
#pragma once

#include <cmath>

#include "host/brdf/facet.hpp"

namespace umov::brdf {

/// Incident light at `theta` radians from the normal.
struct Incidence {
  double theta, cosine, sine;

  explicit Incidence(double theta_i)
      : theta(theta_i), cosine(std::cos(theta_i)), sine(std::sin(theta_i)) {}
};

/// An exit direction above the horizon. cos θh and cos θd belong to the facet with the slopes
/// half_x, half_y, as in FacetFrame.
struct Exit {
  optics::Vec3<double> direction;
  double half_x, half_y, tan2_h, cos_h, cos_d;

  Exit(const Incidence& in, const optics::Vec3<double>& to) : direction(to) {
    const double scale = 1.0 / (in.cosine + to.z);
    half_x = (to.x - in.sine) * scale;
    half_y = to.y * scale;
    tan2_h = half_x * half_x + half_y * half_y;
    cos_h = 1.0 / std::sqrt(1.0 + tan2_h);
    cos_d = (in.cosine - in.sine * half_x) * cos_h;
  }

  /// dω/(dhx dhy) = 4 cos θd cos³θh: what a density of slopes is divided by to be one per
  /// steradian of exit directions.
  double sr_per_slope_area() const { return 4.0 * cos_d * cos_h * cos_h * cos_h; }
};

/// facet_frame() without going through angles.
inline FacetFrame<double> facet_frame(const Incidence& in, const optics::Vec3<double>& to) {
  const double sine = std::sqrt(to.x * to.x + to.y * to.y);
  const double cos_phi = sine > 0.0 ? to.x / sine : 1.0;
  const double sin_phi = sine > 0.0 ? to.y / sine : 0.0;
  using optics::Beam;
  using optics::Vec3;
  const Beam<double> incident{Vec3<double>(0.0, 1.0, 0.0), Vec3<double>(in.cosine, 0.0, in.sine),
                              Vec3<double>(in.sine, 0.0, -in.cosine)};
  const Beam<double> exit{Vec3<double>(-sin_phi, cos_phi, 0.0),
                          Vec3<double>(-to.z * cos_phi, -to.z * sin_phi, sine), to};
  return facet_frame(incident, exit);
}

/// θr and φr of a direction above the horizon.
inline Geometry<double> geometry_of(double theta_i, const optics::Vec3<double>& to) {
  const double sine = std::sqrt(to.x * to.x + to.y * to.y);
  return {theta_i, std::atan2(sine, to.z), std::atan2(to.y, to.x)};
}

/// Where a facet with slopes `half_x`, `half_y` mirrors the light to; may lie below the horizon.
inline optics::Vec3<double> mirrored(const Incidence& in, double half_x, double half_y) {
  const double cos2_h = 1.0 / (1.0 + half_x * half_x + half_y * half_y);
  const double twice = 2.0 * (in.cosine - in.sine * half_x) * cos2_h;
  return {in.sine + twice * half_x, twice * half_y, twice - in.cosine};
}

/// Slope t at which facets of azimuth ψ mirror to the horizon: cos θi t² + 2 sin θi cos ψ t = cos
/// θi.
inline double horizon_slope(const Incidence& in, double cos_psi) {
  const double b = in.sine * cos_psi;
  const double root = std::sqrt(b * b + in.cosine * in.cosine);
  return b > 0.0 ? in.cosine / (b + root) : (root - b) / in.cosine;
}

}  // namespace umov::brdf
