// Detector and electronics: what becomes of a signal in volts on the way to the record.
#pragma once

#include <cmath>

#include "host/gap/scan/effect_list.hpp"
#include "host/gap/scan/record.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/dual.hpp"

namespace umov::gap::scan {

/// In-phase and quadrature part of a record, volts referred to range 1.
template <class T>
struct Lockin {
  T x, y;
};

template <class T>
Lockin<T> detected(T signal, const Record& r, const Switched<T>& on) {
  using std::cos;
  using std::pow;
  using std::sin;
  using std::sqrt;
  if (const T* p = on[EffectId::detector_nonlinearity]) signal = signal / (1.0 + p[0] * signal);
  if (const T* p = on[EffectId::detector_saturation]) {
    // (1 + x⁴)^(-1/4): linear far below the knee, flat above it.
    const T x = p[0] * signal;
    const T x2 = x * x;
    signal = signal / sqrt(sqrt(1.0 + x2 * x2));
  }
  T gain(1.0);
  if (const T* p = on[EffectId::gain_ratio_error]) {
    if (r.gain == 10) gain += p[0];
    if (r.gain == 100) gain += p[1];
    if (r.gain == 1000) gain += p[2];
  }
  Lockin<T> out{T(signal * gain), T(0.0)};
  if (const T* p = on[EffectId::low_signal_pedestal]) {
    const T pedestal = p[0] / r.gain;
    const T size2 = out.x * out.x + pedestal * pedestal;
    const double sign = optics::value_of(out.x) < 0 ? -1.0 : 1.0;
    out.x = sign * optics::sqrt_or_zero(size2);
  }
  if (const T* p = on[EffectId::lockin_phase]) {
    const T phase = p[0] * optics::radians(1.0);
    out.y = out.x * sin(phase);
    out.x = out.x * cos(phase);
  }
  if (const T* p = on[EffectId::dark_offset]) {
    out.x += p[0];
    out.y += p[0] * p[1];
  }
  return out;
}

/// Relative light on the sample, as the monitor does not see it.
template <class T>
T source_level(const Record& r, const Switched<T>& on) {
  using std::exp;
  T level(1.0);
  if (const T* p = on[EffectId::laser_drift]) level += p[0] * (r.time - 0.5);
  if (const T* p = on[EffectId::laser_warmup]) level -= p[0] * exp(T(-r.time_s / p[1]));
  return level;
}

}  // namespace umov::gap::scan
