// The frame that facet models share: half vector, angles to it, and the rotations between the
// facet's scattering plane and the {s, p} bases of the two beams.
#pragma once

#include <type_traits>

#include "host/brdf/gradient.hpp"
#include "host/optics/dual.hpp"
#include "host/optics/frames.hpp"
#include "host/optics/fresnel.hpp"
#include "host/optics/mueller.hpp"

namespace umov::brdf {

/// Directions in radians. `theta_r` may be negative in plane (phi_r = 0): the retro side.
template <class T>
struct Geometry {
  T theta_i, theta_r, phi_r;
};

/// Everything about a geometry that the models ask for. v = k_r - k_i (unit vectors) points along
/// the half vector h; θh is the polar angle of h, θd the angle between either beam and h.
template <class A>
struct FacetFrame {
  A cos_i, sin_i, cos_r, sin_r;  ///< sin_r >= 0
  A half_x, half_y;              ///< slopes v_x/v_z, v_y/v_z of the facet that mirrors i into r
  A tan2_h;                      ///< tan²θh
  A cos_h, cos_d, sin_d;
  A v_z;     ///< cos θi + cos θr
  A chord2;  ///< squared chord between exit and mirror direction, 4 sin²(α/2)
  optics::DoubleAngle<A> entry, exit;
};

/// `in` and `out` as optics::incident_beam() and optics::exit_beam() make them.
template <class A>
FacetFrame<A> facet_frame(const optics::Beam<A>& in, const optics::Beam<A>& out) {
  using std::sqrt;
  FacetFrame<A> f;
  f.cos_i = -in.k.z;
  f.sin_i = in.k.x;
  f.cos_r = out.k.z;
  f.sin_r = optics::sqrt_or_zero(A(out.k.x * out.k.x + out.k.y * out.k.y));
  const optics::Vec3<A> v = out.k - in.k;
  const optics::Vec3<A> sum = out.k + in.k;
  f.v_z = v.z;
  f.half_x = v.x / v.z;
  f.half_y = v.y / v.z;
  f.tan2_h = f.half_x * f.half_x + f.half_y * f.half_y;
  f.cos_h = 1.0 / sqrt(1.0 + f.tan2_h);
  // |k_r - k_i| = 2 cos θd and |k_r + k_i| = 2 sin θd lose no digits at either end.
  f.cos_d = 0.5 * sqrt(optics::dot(v, v));
  f.sin_d = 0.5 * optics::sqrt_or_zero(optics::dot(sum, sum));
  const optics::Vec3<A> off_mirror(v.x, v.y, out.k.z + in.k.z);
  f.chord2 = optics::dot(off_mirror, off_mirror);
  const optics::Vec3<A> normal = optics::scattering_plane_normal(in, out);
  f.entry = optics::rotation_to(in, normal);
  f.exit = optics::rotation_to(out, normal);
  return f;
}

template <class A>
FacetFrame<A> facet_frame(const Geometry<A>& geometry) {
  return facet_frame(optics::incident_beam(geometry.theta_i),
                     optics::exit_beam(geometry.theta_r, geometry.phi_r));
}

/// A function of n, κ and a cosine, such as a Fresnel reflectance, by `compute` of any scalar type.
/// Its few partial derivatives are formed on their own and lifted to T: T may carry many more, of
/// which most are zero here.
template <class T, class A, class Compute>
T lifted(const T& n, const T& kappa, const A& cosine, Compute compute) {
  if constexpr (!optics::DualNumber<T>) {
    return compute(n, kappa, cosine);
  } else if constexpr (std::is_same_v<A, T>) {
    using Small = Gradient<3>;
    const Small x = compute(Small(n.a, 0), Small(kappa.a, 1), Small(cosine.a, 2));
    return optics::lift<T, 3>(x.a, x.v, {n, kappa, cosine});
  } else {
    using Small = Gradient<2>;
    const Small x = compute(Small(n.a, 0), Small(kappa.a, 1), Small(cosine));
    return optics::lift<T, 2>(x.a, x.v, {n, kappa});
  }
}

/// fresnel_reflection() with its partial derivatives lifted likewise.
template <class T, class A>
optics::FresnelReflection<T> facet_reflection(const T& n, const T& kappa, const A& cosine) {
  if constexpr (!optics::DualNumber<T>) {
    return optics::fresnel_reflection(n, kappa, cosine);
  } else if constexpr (std::is_same_v<A, T>) {
    using Small = Gradient<3>;
    const auto r = optics::fresnel_reflection(Small(n.a, 0), Small(kappa.a, 1), Small(cosine.a, 2));
    const auto up = [&](const Small& x) {
      return optics::lift<T, 3>(x.a, x.v, {n, kappa, cosine});
    };
    return {up(r.mean), up(r.half_difference), up(r.cross_re), up(r.cross_im)};
  } else {
    using Small = Gradient<2>;
    const auto r = optics::fresnel_reflection(Small(n.a, 0), Small(kappa.a, 1), Small(cosine));
    const auto up = [&](const Small& x) { return optics::lift<T, 2>(x.a, x.v, {n, kappa}); };
    return {up(r.mean), up(r.half_difference), up(r.cross_re), up(r.cross_im)};
  }
}

/// A Mueller matrix in the facet's scattering plane: [[m00, m01, 0, 0], [m01, m11, 0, 0], [0, 0,
/// m22, m23], [0, 0, -m23, m22]]. Facets reflect with m11 = m00; blurred forward light has less.
template <class T>
struct FacetMatrix {
  T m00, m01, m11, m22, m23;
};

template <class T>
FacetMatrix<T> scaled_reflection(const optics::FresnelReflection<T>& r, const T& scale) {
  const T m00 = r.mean * scale;
  return {m00, T(r.half_difference * scale), m00, T(r.cross_re * scale), T(-r.cross_im * scale)};
}

/// sum += R(-β_out) · m · R(β_in), written out: only five numbers of m differ.
template <class T, class A>
void add_facet(optics::Mueller<T>& sum, const FacetMatrix<T>& m, const FacetFrame<A>& frame) {
  const A& ci = frame.entry.cos2;
  const A& si = frame.entry.sin2;
  const A& co = frame.exit.cos2;
  const A& so = frame.exit.sin2;
  const A cc = co * ci, ss = so * si, cs = co * si, sc = so * ci;
  // GLM stores columns: sum[column][row].
  sum[0][0] += m.m00;
  sum[0][1] += m.m01 * co;
  sum[0][2] += m.m01 * so;
  sum[1][0] += m.m01 * ci;
  sum[1][1] += m.m11 * cc + m.m22 * ss;
  sum[1][2] += m.m11 * sc - m.m22 * cs;
  sum[1][3] += m.m23 * si;
  sum[2][0] += m.m01 * si;
  sum[2][1] += m.m11 * cs - m.m22 * sc;
  sum[2][2] += m.m11 * ss + m.m22 * cc;
  sum[2][3] -= m.m23 * ci;
  sum[3][1] -= m.m23 * so;
  sum[3][2] += m.m23 * co;
  sum[3][3] += m.m22;
}

/// sum += value · depolarizer.
template <class T>
void add_depolarized(optics::Mueller<T>& sum, const T& value) {
  sum[0][0] += value;
}

}  // namespace umov::brdf
