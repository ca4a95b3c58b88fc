// The whole signal chain of a record, from laser to lock-in, with any of the catalogue's effects:
//   X + iY = electronics(detector(C · a·M·s · cos θr · ΔΩ · monitor · …))
// Template over the scalar: doubles for signatures, dual numbers for derivatives.
#pragma once

#include <cmath>
#include <span>

#include "host/gap/scan/effects/detection.hpp"
#include "host/gap/scan/effects/footprint.hpp"
#include "host/gap/scan/effects/geometry.hpp"
#include "host/gap/scan/effects/polarizers.hpp"
#include "host/gap/scan/effects/sample.hpp"
#include "host/optics/frames.hpp"

namespace umov::gap::scan {

/// Everything the chain needs of the base model, per wavelength.
template <class T>
struct ChainBase {
  std::span<const Material<T>> materials;
  std::span<const T> log_gain;  ///< ln of C over its nominal value
  std::span<const double> gain_constant_v;
  double solid_angle_sr;
};

/// A bent pair of directions in the sample's frame, with the rotations from the beams' own bases.
template <class T>
struct LocalGeometry {
  brdf::Geometry<T> geometry;
  optics::DoubleAngle<T> entry, exit;
};

/// The sample's frame leans by `tilt` towards +y. `in` and `out` carry the bases of polariser and
/// analyser.
template <class T>
LocalGeometry<T> seen_from_sample(const optics::Beam<T>& in, const optics::Beam<T>& out,
                                  const T& tilt) {
  using std::atan2;
  using std::cos;
  using std::sin;
  using std::sqrt;
  using Vec = optics::Vec3<T>;
  const Vec normal(T(0.0), sin(tilt), cos(tilt));
  // The plane of incidence: across the normal, along the beam.
  const T along = optics::dot(in.k, normal);
  Vec x = in.k - normal * along;
  const T length2 = optics::dot(x, x);
  if (optics::value_of(length2) > 1e-20) {
    x = x * T(1.0 / sqrt(length2));
  } else {
    x = Vec(T(1.0), T(0.0), T(0.0));
  }
  const Vec y = optics::cross(normal, x);
  LocalGeometry<T> local;
  local.geometry.theta_i = atan2(optics::sqrt_or_zero(length2), T(-along));
  const T out_x = optics::dot(out.k, x), out_y = optics::dot(out.k, y),
          out_z = optics::dot(out.k, normal);
  // A signed polar angle and an azimuth within a right angle: no jump across the normal.
  const double side = optics::value_of(out_x) < 0 ? -1.0 : 1.0;
  const T across2 = out_x * out_x + out_y * out_y;
  if (optics::value_of(across2) > 1e-20) {
    local.geometry.theta_r = atan2(T(side * sqrt(across2)), out_z);
    local.geometry.phi_r = atan2(T(side * out_y), T(side * out_x));
  } else {
    local.geometry.theta_r = atan2(out_x, out_z);
    local.geometry.phi_r = T(0.0);
  }
  const Vec exit_s = y * T(cos(local.geometry.phi_r)) - x * T(sin(local.geometry.phi_r));
  local.entry = optics::rotation_to(in, y);
  local.exit = optics::rotation_to(out, exit_s);
  return local;
}

/// Offsets and weights of a seven-point rule of degree five: a centre and a hexagon.
struct HexagonRule {
  double radius, centre_weight, ring_weight;
};
/// For a disc of unit radius, and for a Gaussian of unit standard deviation on each axis
/// (Abramowitz and Stegun, 25.4.61 and 25.4.63).
inline const HexagonRule disc_rule{std::sqrt(2.0 / 3.0), 0.25, 0.125};
inline const HexagonRule gaussian_rule{2.0, 0.5, 1.0 / 12.0};

/// The direction `k` turned by small angles towards `s` and `p` of its beam.
template <class T>
optics::Beam<T> turned(const optics::Beam<T>& beam, const T& towards_s, const T& towards_p) {
  using std::sqrt;
  const T scale = 1.0 / sqrt(1.0 + towards_s * towards_s + towards_p * towards_p);
  const optics::Vec3<T> k = (beam.k + beam.s * towards_s + beam.p * towards_p) * scale;
  // Bases follow without turning about the beam.
  optics::Vec3<T> s = beam.s - k * optics::dot(beam.s, k);
  s = s * T(1.0 / sqrt(optics::dot(s, s)));
  return {s, optics::cross(k, s), k};
}

/// a·M·s·cos θr for one pair of directions.
template <class T, class A>
T contracted(const Material<T>& material, const optics::Beam<A>& in, const optics::Beam<A>& out,
             const A& tilt, const optics::Stokes<T>& source, const optics::Stokes<T>& detector,
             const Switched<T>& on) {
  const LocalGeometry<A> local = seen_from_sample(in, out, tilt);
  const optics::Mueller<T> m = sample_mueller(material, local.geometry, on);
  const optics::Stokes<T> entering(
      source[0], T(local.entry.cos2 * source[1] + local.entry.sin2 * source[2]),
      T(local.entry.cos2 * source[2] - local.entry.sin2 * source[1]), source[3]);
  const optics::Stokes<T> leaving = optics::apply(m, entering);
  const T q = local.exit.cos2 * leaving[1] - local.exit.sin2 * leaving[2];
  const T u = local.exit.cos2 * leaving[2] + local.exit.sin2 * leaving[1];
  using std::cos;
  return (detector[0] * leaving[0] + detector[1] * q + detector[2] * u) *
         cos(local.geometry.theta_r);
}

/// a·M·s·cos θr of a material, over the detector's disc and the beam's spread where these have one.
template <class T, class A>
T reflected(const Material<T>& material, const Record& r, const Pose<A>& pose, bool bent,
            const optics::Stokes<T>& source, const optics::Stokes<T>& detector,
            const Switched<T>& on, const Switched<A>& bending) {
  if (!bent) {
    // The commanded angles are the true ones: they carry no derivatives.
    const brdf::Geometry<double> geometry{r.theta_i, r.theta_r, r.phi_r};
    const optics::Mueller<T> m = sample_mueller(material, geometry, on);
    return optics::contract(detector, m, source) * std::cos(r.theta_r);
  }
  const optics::Beam<A> in = optics::incident_beam(pose.theta_i);
  const optics::Beam<A> out = optics::exit_beam(pose.theta_r, pose.phi_r);
  const A* aperture = bending[EffectId::finite_aperture];
  const A* divergence = bending[EffectId::beam_divergence];
  if (aperture == nullptr && divergence == nullptr)
    return contracted(material, in, out, pose.tilt_out_of_plane, source, detector, on);

  const double radian = optics::radians(1.0);
  // Both spreads are far below the lobe's width, where second moments tell.
  const auto spread = [&](const optics::Beam<A>& beam, const A& size, const HexagonRule& rule,
                          const auto& value) {
    T sum = rule.centre_weight * value(beam);
    for (int i = 0; i < 6; ++i) {
      const double angle = optics::pi / 3 * i;
      sum += rule.ring_weight * value(turned(beam, A(size * (rule.radius * std::cos(angle))),
                                             A(size * (rule.radius * std::sin(angle)))));
    }
    return sum;
  };
  const auto one_way_out = [&](const optics::Beam<A>& exit) {
    return contracted(material, in, exit, pose.tilt_out_of_plane, source, detector, on);
  };
  const auto one_way_in = [&](const optics::Beam<A>& incident) {
    return contracted(material, incident, out, pose.tilt_out_of_plane, source, detector, on);
  };
  const auto over_aperture = [&] {
    return spread(out, A(aperture[0] * (radian * r.iris_fraction)), disc_rule, one_way_out);
  };
  const auto over_divergence = [&] {
    return spread(in, A(divergence[0] * radian), gaussian_rule, one_way_in);
  };
  if (divergence == nullptr) return over_aperture();
  if (aperture == nullptr) return over_divergence();
  // Second moments of independent spreads add.
  return over_aperture() + over_divergence() - one_way_out(out);
}

/// What the record should read. `bent`: effects that move angles are among those switched on.
/// `bending` has the same effects as `on` with the scalar that angles are computed in: plain
/// numbers where no derivative by an angle is asked for.
template <class T, class A>
Lockin<T> record_signal(const Record& r, const ChainBase<T>& base, bool bent, const Switched<T>& on,
                        const Switched<A>& bending) {
  using std::cos;
  using std::exp;
  if (!r.shutter_open) return detected(T(0.0), r, on);
  const Pose<A> pose = true_pose(r, bending);
  const optics::Stokes<T> source = source_stokes(r, pose, on);
  const optics::Stokes<T> detector = detector_stokes(r, pose, on);

  const auto wavelength_nm = [&](std::size_t i) { return base.materials[i].wavelength_um * 1e3; };
  const auto is_at = [&](std::size_t i, const T& nm) {
    return std::abs(wavelength_nm(i) - optics::value_of(nm)) < 0.5;
  };
  T light(0.0);  // BRDF · cos θr as polariser and analyser select it
  if (!r.sample_removed) {
    if (!r.long_pass) {
      const Material<T>& own = base.materials[r.wavelength];
      light = reflected(own, r, pose, bent, source, detector, on, bending);
      const auto mix = [&](std::size_t other, const T& fraction) {
        const T foreign =
            reflected(base.materials[other], r, pose, bent, source, detector, on, bending);
        light += fraction * (foreign - light);
      };
      if (const T* p = on[EffectId::laser_crosstalk]) {
        for (std::size_t i = 0; i < base.materials.size(); ++i)
          if (is_at(i, p[2]) && is_at(r.wavelength, p[1])) mix(i, p[0]);
      }
      if (const T* p = on[EffectId::wavelength_error]) {
        if (is_at(r.wavelength, p[1]) && base.materials.size() > 1) {
          // Straight line to the neighbour: what is known of the spectrum in between.
          const std::size_t other =
              r.wavelength + 1 < base.materials.size() ? r.wavelength + 1 : r.wavelength - 1;
          mix(other, T(p[0] * (1.0 / (wavelength_nm(other) - wavelength_nm(r.wavelength)))));
        }
      }
      if (on[EffectId::beam_overfill] != nullptr || on[EffectId::detector_underfill] != nullptr)
        light *= footprint(T(cos(pose.theta_i)), T(cos(pose.theta_r)), on);
      if (on[EffectId::retro_occlusion] != nullptr) {
        const double cos_off = std::cos(r.theta_i) * std::cos(r.theta_r) -
                               std::sin(r.theta_i) * std::sin(r.theta_r) * std::cos(r.phi_r);
        light -= light * shadow(T(std::acos(std::min(1.0, std::max(-1.0, cos_off)))), on);
      }
    }
    if (const T* p = on[EffectId::laser_crosstalk]; p != nullptr && r.long_pass) {
      // Light of a longer wavelength that leaks in passes the filter.
      for (std::size_t i = r.wavelength + 1; i < base.materials.size(); ++i)
        if (is_at(i, p[2]) && is_at(r.wavelength, p[1]))
          light +=
              p[0] * reflected(base.materials[i], r, pose, bent, source, detector, on, bending);
    }
    if (const T* p = on[EffectId::fluorescence]) {
      if (r.wavelength == 0) light += p[0] * detector[0] * (std::cos(r.theta_r) / optics::pi);
    }
  }
  // The long-pass filter stands before the detector.
  if (const T* p = on[EffectId::stray_light]; p != nullptr && !r.long_pass)
    light += p[0] * detector[0];
  if (const T* p = on[EffectId::stray_forward]; p != nullptr && !r.long_pass) {
    const T width = p[1] * optics::radians(1.0);
    const double off =
        std::acos(std::min(1.0, std::max(-1.0, std::sin(r.theta_r) * std::cos(r.phi_r))));
    light += p[0] * detector[0] * exp(T(-0.5 * off * off / (width * width)));
  }
  const T constant =
      exp(base.log_gain[r.wavelength]) * (base.gain_constant_v[r.wavelength] * base.solid_angle_sr *
                                          r.monitor_v * r.iris_fraction * r.iris_fraction);
  return detected(T(light * constant * source_level(r, on)), r, on);
}

}  // namespace umov::gap::scan
