// How much of the beam falls on the sample and into the detector's field, and the detector's own
// shadow.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "host/gap/scan/effect_list.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/dual.hpp"

namespace umov::gap::scan {

/// Nodes and weights of 12-point Gauss-Legendre quadrature on (0, 1): the half with its mirror.
inline constexpr std::array<double, 6> half_nodes = {0.1252334085114689, 0.3678314989981802,
                                                     0.5873179542866175, 0.7699026741943047,
                                                     0.9041172563704749, 0.9815606342467192};
inline constexpr std::array<double, 6> half_weights = {0.2491470458134028, 0.2334925365383548,
                                                       0.2031674267230659, 0.1600783285433462,
                                                       0.1069393259953184, 0.0471753363865118};

/// Share of a Gaussian beam on a disc, with its derivatives.
struct DiscShare {
  double ratio = 0, cosine = 0;  ///< what it belongs to
  double value = 0, by_ratio = 0, by_cosine = 0;
};

inline DiscShare compute_disc_share(double ratio, double cosine) {
  const double y_scale = std::sqrt(2.0) / ratio, x_scale = y_scale * cosine;
  const double norm = 2.0 / std::sqrt(optics::pi);
  // Chords across the disc, by the angle about its centre (the edge is no edge there), as far as
  // the beam reaches.
  constexpr double reach = 4.5;
  const double widest = std::asin(std::min(1.0, reach / y_scale));
  double sum = 0, by_y_scale = 0, by_x_scale = 0;
  for (std::size_t i = 0; i < half_nodes.size(); ++i) {
    for (const double side : {-1.0, 1.0}) {
      const double angle = 0.5 * widest * (1.0 + side * half_nodes[i]);
      const double y = std::sin(angle), x = std::cos(angle);
      const double density =
          0.5 * widest * half_weights[i] * x * std::exp(-(y_scale * y) * (y_scale * y));
      const double along = std::erf(x_scale * x);
      sum += density * along;
      by_y_scale -= 2.0 * y_scale * y * y * density * along;
      by_x_scale += density * norm * x * std::exp(-(x_scale * x) * (x_scale * x));
    }
  }
  // By the scale of y at a constant cosine, which scales x too.
  const double by_scale = norm * (sum + y_scale * (by_y_scale + by_x_scale * cosine));
  return {ratio, cosine, norm * y_scale * sum, -by_scale * y_scale / ratio,
          norm * y_scale * y_scale * by_x_scale};
}

/// The same from memory where it was asked for before: a scan has few pairs of angles and many
/// records at each.
inline const DiscShare& disc_share(double ratio, double cosine) {
  constexpr std::size_t places = 1024;
  thread_local std::array<DiscShare, places> memory;
  const auto mixed = std::bit_cast<std::uint64_t>(ratio) * 0x9e3779b97f4a7c15U ^
                     std::bit_cast<std::uint64_t>(cosine) * 0xc2b2ae3d27d4eb4fU;
  DiscShare& at = memory[(mixed >> 40) % places];
  if (at.ratio != ratio || at.cosine != cosine) at = compute_disc_share(ratio, cosine);
  return at;
}

/// Share of a Gaussian beam, 1/e² radius `ratio` times a disc's radius and stretched along x by
/// 1/`cosine`, that falls on the disc.
template <class T>
T share_on_disc(const T& ratio, const T& cosine) {
  const DiscShare& share = disc_share(optics::value_of(ratio), optics::value_of(cosine));
  return optics::lift<T, 2>(share.value, {share.by_ratio, share.by_cosine}, {ratio, cosine});
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
