// Reflection and refraction at a smooth face, and the products of Mueller matrices they need:
// written out, for most elements of their matrices are 0.
#pragma once

#include <algorithm>
#include <cmath>

#include "host/optics/fresnel.hpp"
#include "host/optics/mueller.hpp"
#include "host/trace/scene.hpp"

namespace umov::trace {

/// A matrix [[mean, half_difference, 0, 0], [half_difference, mean, 0, 0], [0, 0, cross_re,
/// -cross_im], [0, 0, cross_im, cross_re]] in the plane of incidence.
using Specular = optics::FresnelReflection<double>;

/// (n2 + iκ2)/(n1 + iκ1), κ not below 0.
struct RelativeIndex {
  double n, kappa;
};

inline RelativeIndex relative_index(double n1, double kappa1, double n2, double kappa2) {
  const double scale = 1.0 / (n1 * n1 + kappa1 * kappa1);
  return {(n2 * n1 + kappa2 * kappa1) * scale, std::max(0.0, kappa2 * n1 - n2 * kappa1) * scale};
}

/// What `reflection` leaves: T_s = 1 - R_s, T_p = 1 - R_p, no phase between them. That is exact
/// without absorption and right to order κ with it. As powers: n²-laws of radiance are for whoever
/// counts solid angles.
inline Specular transmission(const Specular& reflection) {
  const double mean = std::max(0.0, 1.0 - reflection.mean);
  const double s = std::max(0.0, mean - reflection.half_difference);
  const double p = std::max(0.0, mean + reflection.half_difference);
  return {0.5 * (s + p), 0.5 * (s - p), std::sqrt(s * p), 0.0};
}

/// specular · m, times `scale`.
inline optics::Mueller<double> specular_product(const Specular& f, double scale,
                                                const optics::Mueller<double>& m) {
  const double mean = f.mean * scale;
  const double half = f.half_difference * scale;
  const double re = f.cross_re * scale;
  const double im = f.cross_im * scale;
  optics::Mueller<double> out;
  for (int c = 0; c < 4; ++c) {
    out[c][0] = mean * m[c][0] + half * m[c][1];
    out[c][1] = half * m[c][0] + mean * m[c][1];
    out[c][2] = re * m[c][2] - im * m[c][3];
    out[c][3] = im * m[c][2] + re * m[c][3];
  }
  return out;
}

/// rotation(cos2, sin2) · m, in place.
inline void rotate(optics::Mueller<double>& m, double cos2, double sin2) {
  for (int c = 0; c < 4; ++c) {
    const double q = m[c][1];
    m[c][1] = cos2 * q + sin2 * m[c][2];
    m[c][2] = cos2 * m[c][2] - sin2 * q;
  }
}

/// Share of what comes in unpolarised (column 0 of `m`) that leaves `specular`.
inline double specular_intensity(const Specular& f, const optics::Mueller<double>& m) {
  return f.mean * m[0][0] + f.half_difference * m[0][1];
}

/// Direction behind a face with normal on the side of arrival; `cosine` = -k·normal > 0, `ratio` =
/// n1/n2 < 1/sin θ.
inline Vec3 refracted(const Vec3& k, const Vec3& normal, double cosine, double ratio) {
  const double cosine2 = std::sqrt(std::max(0.0, 1.0 - ratio * ratio * (1.0 - cosine * cosine)));
  const Vec3 out = ratio * k + (ratio * cosine - cosine2) * normal;
  return out / std::sqrt(out.x * out.x + out.y * out.y + out.z * out.z);
}

}  // namespace umov::trace
