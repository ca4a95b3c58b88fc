// Polariser and analyser: Stokes vectors of real ones, and a detector that prefers a polarisation.
#pragma once

#include <cmath>

#include "host/gap/scan/effects/geometry.hpp"
#include "host/optics/mueller.hpp"

namespace umov::gap::scan {

/// Light behind the polariser at unit power.
template <class T, class A>
optics::Stokes<T> source_stokes(const Record& r, const Pose<A>& pose, const Switched<T>& on) {
  using std::cos;
  using std::sin;
  if (r.polarizer_open) return {T(1.0), T(0.0), T(0.0), T(0.0)};
  T purity(1.0);
  if (const T* p = on[EffectId::polarizer_leakage]) purity = (1.0 - p[0]) / (1.0 + p[0]);
  const A twice = 2.0 * pose.polarizer;
  return {T(1.0), T(-purity * cos(twice)), T(purity * sin(twice)), T(0.0)};
}

/// Row vector of analyser and detector: the signal is its product with the light's Stokes vector.
template <class T, class A>
optics::Stokes<T> detector_stokes(const Record& r, const Pose<A>& pose, const Switched<T>& on) {
  using std::cos;
  using std::sin;
  const T* bias = on[EffectId::detector_polarization_bias];
  if (r.analyzer_open) {
    const T preference = bias != nullptr ? bias[0] : T(0.0);
    return {T(1.0), preference, T(0.0), T(0.0)};
  }
  T leaked(0.0);
  if (const T* p = on[EffectId::analyzer_leakage]) leaked = p[0];
  const A twice = 2.0 * pose.analyzer;
  const A along_s = -cos(twice);
  const A u = sin(twice);
  // Power passed in the axis and, by the extinction ratio, in the crossed one; the detector weighs
  // each with its preference.
  T through(0.5), across = 0.5 * leaked;
  if (bias != nullptr) {
    through *= 1.0 + bias[0] * along_s;
    across *= 1.0 - bias[0] * along_s;
  }
  const T sum = through + across;
  const T difference = through - across;
  return {sum, T(difference * along_s), T(difference * u), T(0.0)};
}

}  // namespace umov::gap::scan
