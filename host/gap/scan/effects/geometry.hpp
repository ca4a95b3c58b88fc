// Effects of the stages and of the sample's mount: what the angles really are.
#pragma once

#include <cmath>

#include "host/gap/scan/effect_list.hpp"
#include "host/gap/scan/record.hpp"
#include "host/optics/angles.hpp"

namespace umov::gap::scan {

/// Where the axes truly stand, radians, and how the sample's normal leans.
template <class T>
struct Pose {
  T theta_i, theta_r, phi_r, polarizer, analyzer;
  T tilt_out_of_plane;
};

inline bool changes_geometry(EffectId id) {
  switch (id) {
    case EffectId::incidence_zero:
    case EffectId::detector_zero:
    case EffectId::sample_tilt_in_plane:
    case EffectId::sample_tilt_out_of_plane:
    case EffectId::detector_eccentricity:
    case EffectId::backlash:
    case EffectId::finite_aperture:
    case EffectId::beam_divergence:
      return true;
    default:
      return false;
  }
}

/// True where derivatives to the effect's parameters need a pose that carries them.
inline bool moves_pose(EffectId id) {
  return changes_geometry(id) || id == EffectId::polarizer_rotation ||
         id == EffectId::analyzer_rotation;
}

template <class T>
Pose<T> true_pose(const Record& r, const Switched<T>& on) {
  const double radian = optics::radians(1.0);
  Pose<T> pose{T(r.theta_i), T(r.theta_r), T(r.phi_r), T(r.polarizer), T(r.analyzer), T(0.0)};
  if (const T* p = on[EffectId::incidence_zero]) pose.theta_i += p[0] * radian;
  if (const T* p = on[EffectId::detector_zero]) pose.theta_r += p[0] * radian;
  if (const T* p = on[EffectId::detector_eccentricity]) {
    using std::sin;
    pose.theta_r += p[0] * radian * sin(T(r.theta_r + p[1] * radian));
  }
  if (const T* p = on[EffectId::backlash]) {
    pose.theta_r -= p[0] * (0.5 * radian * static_cast<double>(r.direction));
  }
  // A sample turned about its normal leans the other way.
  const double side = r.sample_flipped ? -1.0 : 1.0;
  if (const T* p = on[EffectId::sample_tilt_in_plane]) {
    pose.theta_i += p[0] * (radian * side);
    // In the plane at azimuth φ the normal leans by its component along that half plane.
    pose.theta_r -= p[0] * (radian * side * std::cos(r.phi_r));
  }
  if (const T* p = on[EffectId::sample_tilt_out_of_plane])
    pose.tilt_out_of_plane += p[0] * (radian * side);
  if (const T* p = on[EffectId::polarizer_rotation]) pose.polarizer += p[0] * radian;
  if (const T* p = on[EffectId::analyzer_rotation]) pose.analyzer += p[0] * radian;
  return pose;
}

}  // namespace umov::gap::scan
