// Integers wider than 64 bits, for targets whose compiler has none. Exact; overflow wraps.
#pragma once

#include <bit>
#include <cstdint>

namespace umov::firmware {

/// Unsigned 128-bit integer.
struct Uint128 {
  std::uint64_t high = 0;
  std::uint64_t low = 0;

  constexpr Uint128() = default;
  constexpr Uint128(std::uint64_t value) : low(value) {}
  constexpr Uint128(std::uint64_t high_part, std::uint64_t low_part)
      : high(high_part), low(low_part) {}

  friend constexpr bool operator==(const Uint128&, const Uint128&) = default;
  friend constexpr bool operator<(const Uint128& a, const Uint128& b) {
    return a.high != b.high ? a.high < b.high : a.low < b.low;
  }
  friend constexpr bool operator>=(const Uint128& a, const Uint128& b) { return !(a < b); }
  friend constexpr Uint128 operator+(const Uint128& a, const Uint128& b) {
    const std::uint64_t low_sum = a.low + b.low;
    return {a.high + b.high + (low_sum < a.low ? 1u : 0u), low_sum};
  }
  friend constexpr Uint128 operator-(const Uint128& a, const Uint128& b) {
    return {a.high - b.high - (a.low < b.low ? 1u : 0u), a.low - b.low};
  }
  /// 0 <= shift < 128
  friend constexpr Uint128 operator<<(const Uint128& a, unsigned shift) {
    if (shift == 0) return a;
    if (shift >= 64) return {a.low << (shift - 64), 0};
    return {(a.high << shift) | (a.low >> (64 - shift)), a.low << shift};
  }
  friend constexpr Uint128 operator>>(const Uint128& a, unsigned shift) {
    if (shift == 0) return a;
    if (shift >= 64) return {0, a.high >> (shift - 64)};
    return {a.high >> shift, (a.low >> shift) | (a.high << (64 - shift))};
  }
};

/// Full product of two 64-bit numbers.
constexpr Uint128 multiply(std::uint64_t a, std::uint64_t b) {
  const std::uint64_t a0 = a & 0xffffffffu, a1 = a >> 32, b0 = b & 0xffffffffu, b1 = b >> 32;
  const std::uint64_t p00 = a0 * b0, p01 = a0 * b1, p10 = a1 * b0, p11 = a1 * b1;
  const std::uint64_t middle = (p00 >> 32) + (p01 & 0xffffffffu) + (p10 & 0xffffffffu);
  return {p11 + (p01 >> 32) + (p10 >> 32) + (middle >> 32), (middle << 32) | (p00 & 0xffffffffu)};
}

/// Product modulo 2^128.
constexpr Uint128 multiply(const Uint128& a, std::uint64_t b) {
  Uint128 product = multiply(a.low, b);
  product.high += a.high * b;
  return product;
}

constexpr unsigned bit_width(const Uint128& a) {
  return a.high != 0 ? 64u + static_cast<unsigned>(std::bit_width(a.high))
                     : static_cast<unsigned>(std::bit_width(a.low));
}

/// Quotient rounded down; divisor not 0.
constexpr Uint128 divide(const Uint128& dividend, std::uint64_t divisor) {
  if (dividend.high == 0) return dividend.low / divisor;
  Uint128 quotient{dividend.high / divisor, 0};
  std::uint64_t remainder = dividend.high % divisor;
  for (int bit = 63; bit >= 0; --bit) {
    const bool carry = (remainder >> 63) != 0;
    remainder = (remainder << 1) | ((dividend.low >> bit) & 1u);
    if (carry || remainder >= divisor) {
      remainder -= divisor;
      quotient.low |= std::uint64_t{1} << bit;
    }
  }
  return quotient;
}

/// Quotient rounded up.
constexpr Uint128 divide_up(const Uint128& dividend, std::uint64_t divisor) {
  return divide(dividend + Uint128{divisor - 1}, divisor);
}

/// a * b / divisor rounded to nearest; the result must fit 64 bits.
constexpr std::uint64_t multiply_divide(std::uint64_t a, std::uint64_t b, std::uint64_t divisor) {
  return divide(multiply(a, b) + Uint128{divisor / 2}, divisor).low;
}

/// a * b / 2^shift rounded down, 0 <= shift < 64; the result must fit 64 bits.
constexpr std::uint64_t multiply_shift(std::uint64_t a, std::uint64_t b, unsigned shift) {
  if ((b >> 32) == 0 && shift <= 32) {  // two products instead of four
    const std::uint64_t low = (a & 0xffffffffu) * b;
    return (((a >> 32) * b) << (32 - shift)) + (low >> shift);
  }
  return (multiply(a, b) >> shift).low;
}

/// Largest r with r^2 <= a.
constexpr std::uint64_t square_root(const Uint128& a) {
  std::uint64_t root = 0;
  const unsigned width = bit_width(a);
  for (int bit = static_cast<int>((width + 1) / 2); bit >= 0; --bit) {
    if (bit > 63) continue;
    const std::uint64_t trial = root | (std::uint64_t{1} << bit);
    if (a >= multiply(trial, trial)) root = trial;
  }
  return root;
}

/// Smallest r with r^2 >= a; a < 2^126.
constexpr std::uint64_t square_root_up(const Uint128& a) {
  const std::uint64_t root = square_root(a);
  return multiply(root, root) == a ? root : root + 1;
}

/// Smallest r with r^3 >= a; a < 2^126.
constexpr std::uint64_t cube_root_up(const Uint128& a) {
  std::uint64_t root = 0;  // largest with root^3 < a
  if (a == Uint128{}) return 0;
  for (int bit = static_cast<int>((bit_width(a) + 2) / 3); bit >= 0; --bit) {
    const std::uint64_t trial = root | (std::uint64_t{1} << bit);
    const Uint128 square = multiply(trial, trial);
    if (bit_width(square) + static_cast<unsigned>(std::bit_width(trial)) > 128) continue;
    if (multiply(square, trial) < a) root = trial;
  }
  return root + 1;
}

}  // namespace umov::firmware
