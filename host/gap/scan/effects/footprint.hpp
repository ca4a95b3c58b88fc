// How much of the beam falls on the sample and into the detector's field, and the detector's own
// shadow.
#pragma once

#include <array>
#include <cmath>

#include "host/gap/scan/effect_list.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/dual.hpp"

namespace umov::gap::scan {

/// erf for dual numbers.
template <class T>
T error_function(const T& x) {
  const double a = optics::value_of(x);
  return optics::lift<T, 1>(std::erf(a), {2.0 / std::sqrt(optics::pi) * std::exp(-a * a)}, {x});
}

/// Nodes and weights of 12-point Gauss-Legendre quadrature on (0, 1): the half with its mirror.
inline constexpr std::array<double, 6> half_nodes = {0.1252334085114689, 0.3678314989981802,
                                                     0.5873179542866175, 0.7699026741943047,
                                                     0.9041172563704749, 0.9815606342467192};
inline constexpr std::array<double, 6> half_weights = {0.2491470458134028, 0.2334925365383548,
                                                       0.2031674267230659, 0.1600783285433462,
                                                       0.1069393259953184, 0.0471753363865118};

/// Share of a Gaussian beam, 1/e² radius `ratio` times a disc's radius and stretched along x by
/// 1/`cosine`, that falls on the disc.
template <class T>
T share_on_disc(const T& ratio, const T& cosine) {
  using std::exp;
  T sum(0.0);
  const T y_scale = std::sqrt(2.0) / ratio;
  const T x_scale = y_scale * cosine;
  for (std::size_t i = 0; i < half_nodes.size(); ++i) {
    const double y = half_nodes[i];
    const T density = exp(T(-(y_scale * y) * (y_scale * y)));
    sum += half_weights[i] * density * error_function(T(x_scale * std::sqrt(1.0 - y * y)));
  }
  return sum * y_scale * (2.0 / std::sqrt(optics::pi));
}

/// Factor for both edges. Normalised to normal incidence and view, where the gain is calibrated.
template <class T>
T footprint(const T& cos_i, const T& cos_r, const Switched<T>& on) {
  T factor(1.0);
  if (const T* p = on[EffectId::beam_overfill])
    factor *= share_on_disc(p[0], cos_i) / share_on_disc(p[0], T(1.0));
  if (const T* p = on[EffectId::detector_underfill]) {
    // Seen along the arm the footprint is 1/cos θi long and foreshortened by cos θr.
    const T stretch = cos_i / (cos_r + 1e-3);
    factor *= share_on_disc(p[0], stretch) / share_on_disc(p[0], T(1.0));
  }
  return factor;
}

/// Share of the beam that the detector's head keeps from the sample when it stands `off_retro`
/// radians from the way back to the source: a disc before a Gaussian beam.
template <class T>
T shadow(const T& off_retro, const Switched<T>& on) {
  using std::exp;
  const T* p = on[EffectId::retro_occlusion];
  if (p == nullptr) return T(0.0);
  const double radian = optics::radians(1.0);
  const T disc = p[0] * radian;
  const T width = p[1] * radian;
  const T inverse2 = 1.0 / (width * width);
  if (optics::value_of(off_retro) > optics::value_of(disc) + 6 * optics::value_of(width))
    return T(0.0);
  T sum(0.0);
  for (std::size_t side = 0; side < 2; ++side) {
    for (std::size_t i = 0; i < half_nodes.size(); ++i) {
      const double t = 0.5 * (1.0 + (side == 0 ? -half_nodes[i] : half_nodes[i]));
      const T radius = t * disc;
      // exp(-(r² + b²)/2w²) I0(r b/w²), the Bessel function scaled by its exponential.
      const T argument = radius * off_retro * inverse2;
      const double a = optics::value_of(argument);
      double scaled = 0, slope = 0;  // I0(a) exp(-a) and its derivative
      if (a < 600) {
        const double e = std::exp(-a);
        scaled = std::cyl_bessel_i(0.0, a) * e;
        slope = std::cyl_bessel_i(1.0, a) * e - scaled;
      } else {
        scaled = 1.0 / std::sqrt(2 * optics::pi * a);
        slope = -0.5 * scaled / a;
      }
      const T bessel = optics::lift<T, 1>(scaled, {slope}, {argument});
      const T gap = radius - off_retro;
      sum += 0.5 * half_weights[i] * radius * exp(T(-0.5 * gap * gap * inverse2)) * bessel;
    }
  }
  return sum * disc * inverse2;
}

}  // namespace umov::gap::scan
