// Complex amplitudes in real arithmetic, and the Mueller matrix of a Jones matrix.
#pragma once

#include "host/optics/fresnel.hpp"
#include "host/optics/mueller.hpp"

namespace umov::brdf {

using optics::ComplexValue;

template <class T>
ComplexValue<T> times(const ComplexValue<T>& x, const ComplexValue<T>& y) {
  return {T(x.re * y.re - x.im * y.im), T(x.re * y.im + x.im * y.re)};
}

template <class T>
ComplexValue<T> scaled(const ComplexValue<T>& x, const T& scale) {
  return {T(x.re * scale), T(x.im * scale)};
}

/// conj(x) · y.
template <class T>
ComplexValue<T> conjugate_times(const ComplexValue<T>& x, const ComplexValue<T>& y) {
  return {T(x.re * y.re + x.im * y.im), T(x.re * y.im - x.im * y.re)};
}

/// x/y, for y ≠ 0.
template <class T>
ComplexValue<T> quotient(const ComplexValue<T>& x, const ComplexValue<T>& y) {
  const T scale = 1.0 / (y.re * y.re + y.im * y.im);
  return scaled(conjugate_times(y, x), scale);
}

/// Amplitudes out of (first letter) from in (second letter): E_s' = ss E_s + sp E_p.
template <class T>
struct Jones {
  ComplexValue<T> ss, sp, ps, pp;
};

/// With the Stokes signs of docs/physics.md: V > 0 is (1, i)/√2.
template <class T>
optics::Mueller<T> mueller_of(const Jones<T>& j) {
  const auto power = [](const ComplexValue<T>& x) { return T(x.re * x.re + x.im * x.im); };
  const T ss = power(j.ss), sp = power(j.sp), ps = power(j.ps), pp = power(j.pp);
  const ComplexValue<T> s_row = conjugate_times(j.ss, j.sp), p_row = conjugate_times(j.ps, j.pp);
  const ComplexValue<T> s_column = conjugate_times(j.ss, j.ps),
                        p_column = conjugate_times(j.sp, j.pp);
  const ComplexValue<T> straight = conjugate_times(j.ss, j.pp),
                        crossed = conjugate_times(j.sp, j.ps);
  optics::Mueller<T> m(T(0.0));
  optics::set_element(m, 0, 0, T(0.5 * (ss + sp + ps + pp)));
  optics::set_element(m, 0, 1, T(0.5 * (ss - sp + ps - pp)));
  optics::set_element(m, 1, 0, T(0.5 * (ss + sp - ps - pp)));
  optics::set_element(m, 1, 1, T(0.5 * (ss - sp - ps + pp)));
  optics::set_element(m, 0, 2, T(s_row.re + p_row.re));
  optics::set_element(m, 0, 3, T(-1.0 * (s_row.im + p_row.im)));
  optics::set_element(m, 1, 2, T(s_row.re - p_row.re));
  optics::set_element(m, 1, 3, T(p_row.im - s_row.im));
  optics::set_element(m, 2, 0, T(s_column.re + p_column.re));
  optics::set_element(m, 2, 1, T(s_column.re - p_column.re));
  optics::set_element(m, 3, 0, T(s_column.im + p_column.im));
  optics::set_element(m, 3, 1, T(s_column.im - p_column.im));
  optics::set_element(m, 2, 2, T(straight.re + crossed.re));
  optics::set_element(m, 2, 3, T(crossed.im - straight.im));
  optics::set_element(m, 3, 2, T(straight.im + crossed.im));
  optics::set_element(m, 3, 3, T(straight.re - crossed.re));
  return m;
}

}  // namespace umov::brdf
