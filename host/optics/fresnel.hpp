// Reflection at a smooth interface from vacuum into n + iκ. Signs: docs/physics.md, section 1.
//
// Complex numbers are written out in real arithmetic, so that dual numbers pass through; κ = 0 and
// normal or grazing incidence have finite derivatives with respect to n, κ and cos θ. (At exact
// total reflection, n < 1, κ = 0 and sin θ = n, the derivative is infinite and is given as 0.)
#pragma once

#include <cmath>

#include "host/optics/dual.hpp"
#include "host/optics/mueller.hpp"

namespace umov::optics {

template <class T>
struct ComplexValue {
  T re, im;
};

/// Amplitude reflection coefficients r_s and r_p; r_p = -r_s at normal incidence.
template <class T>
struct FresnelAmplitudes {
  ComplexValue<T> s, p;
};

/// q = √(ε - sin²θ) = a + ib with a, b >= 0, ε = (n + iκ)².
template <class T>
ComplexValue<T> normal_wave_number(const T& n, const T& kappa, const T& cos_theta) {
  using std::sqrt;
  const T u = n * n - kappa * kappa - (1.0 - cos_theta * cos_theta);
  const T v = 2.0 * n * kappa;
  if (value_of(v) == 0.0 && value_of(u) >= 0.0) {
    const T a = sqrt_or_zero(u);
    return {a, value_of(a) > 0.0 ? T(v / (2.0 * a)) : T(0.0)};
  }
  const T modulus = sqrt(u * u + v * v);
  if (value_of(u) >= 0.0) {
    const T a = sqrt(0.5 * (modulus + u));
    return {a, v / (2.0 * a)};
  }
  const T b = sqrt(0.5 * (modulus - u));
  return {v / (2.0 * b), b};
}

/// `n` > 0, `kappa` >= 0, `cos_theta` in [0, 1].
template <class T>
FresnelAmplitudes<T> fresnel_amplitudes(const T& n, const T& kappa, const T& cos_theta) {
  const ComplexValue<T> q = normal_wave_number(n, kappa, cos_theta);
  const T q2 = q.re * q.re + q.im * q.im;
  // (c - q)/(c + q) and (εc - q)/(εc + q), both expanded with the conjugate of the denominator.
  const T s_sum = cos_theta + q.re;
  const T s_scale = 1.0 / (s_sum * s_sum + q.im * q.im);
  const T x = (n * n - kappa * kappa) * cos_theta;
  const T y = 2.0 * n * kappa * cos_theta;
  const T p_re = x + q.re;
  const T p_im = y + q.im;
  const T p_scale = 1.0 / (p_re * p_re + p_im * p_im);
  return {{(cos_theta * cos_theta - q2) * s_scale, -2.0 * cos_theta * q.im * s_scale},
          {(x * x + y * y - q2) * p_scale, 2.0 * (y * q.re - x * q.im) * p_scale}};
}

/// The four numbers of a specular Mueller matrix in the scattering plane:
/// [[mean, half_difference, 0, 0], [half_difference, mean, 0, 0], [0, 0, cross_re, -cross_im],
///  [0, 0, cross_im, cross_re]], with cross = conj(r_s) r_p.
template <class T>
struct FresnelReflection {
  T mean;             ///< (R_s + R_p)/2, reflectance of unpolarised light
  T half_difference;  ///< (R_s - R_p)/2
  T cross_re, cross_im;
};

template <class T>
FresnelReflection<T> fresnel_reflection(const T& n, const T& kappa, const T& cos_theta) {
  const FresnelAmplitudes<T> r = fresnel_amplitudes(n, kappa, cos_theta);
  const T s = r.s.re * r.s.re + r.s.im * r.s.im;
  const T p = r.p.re * r.p.re + r.p.im * r.p.im;
  return {0.5 * (s + p), 0.5 * (s - p), r.s.re * r.p.re + r.s.im * r.p.im,
          r.s.re * r.p.im - r.s.im * r.p.re};
}

/// The same as a matrix.
template <class T>
Mueller<T> reflection_mueller(const FresnelReflection<T>& r) {
  Mueller<T> m(T(0.0));
  set_element(m, 0, 0, r.mean);
  set_element(m, 0, 1, r.half_difference);
  set_element(m, 1, 0, r.half_difference);
  set_element(m, 1, 1, r.mean);
  set_element(m, 2, 2, r.cross_re);
  set_element(m, 2, 3, T(-r.cross_im));
  set_element(m, 3, 2, r.cross_im);
  set_element(m, 3, 3, r.cross_re);
  return m;
}

template <class T>
Mueller<T> reflection_mueller(const T& n, const T& kappa, const T& cos_theta) {
  return reflection_mueller(fresnel_reflection(n, kappa, cos_theta));
}

template <class T>
T reflectance_s(const T& n, const T& kappa, const T& cos_theta) {
  const ComplexValue<T> r = fresnel_amplitudes(n, kappa, cos_theta).s;
  return r.re * r.re + r.im * r.im;
}

template <class T>
T reflectance_p(const T& n, const T& kappa, const T& cos_theta) {
  const ComplexValue<T> r = fresnel_amplitudes(n, kappa, cos_theta).p;
  return r.re * r.re + r.im * r.im;
}

/// Of unpolarised light.
template <class T>
T reflectance(const T& n, const T& kappa, const T& cos_theta) {
  return fresnel_reflection(n, kappa, cos_theta).mean;
}

/// 1 - reflectance: the share of unpolarised light that enters.
template <class T>
T transmittance(const T& n, const T& kappa, const T& cos_theta) {
  return 1.0 - reflectance(n, kappa, cos_theta);
}

}  // namespace umov::optics
