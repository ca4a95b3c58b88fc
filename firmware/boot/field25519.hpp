// Numbers modulo p = 2^255 − 19, eight words of 32 bits, the least first. Values are kept below
// 2^256 and reduced fully only where they are compared or written out. No secrets pass here, so
// nothing is done about timing.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace umov::firmware::boot {

using Words256 = std::array<std::uint32_t, 8>;

struct Field {
  Words256 w{};
};

inline constexpr Field field_zero{};
inline constexpr Field field_one{{1}};

Field add(const Field& a, const Field& b);
Field subtract(const Field& a, const Field& b);
Field multiply(const Field& a, const Field& b);
inline Field square(const Field& a) {
  return multiply(a, a);
}
/// a^(p−2), which is 1/a, and 0 for 0.
Field invert(const Field& a);
/// a^((p−5)/8), for square roots (RFC 8032 5.1.3).
Field power_p58(const Field& a);
/// The one value below p.
Field reduced(const Field& a);
bool is_zero(const Field& a);
/// Lowest bit of the reduced value: the "sign" of RFC 8032.
bool is_odd(const Field& a);

/// −1, 0, 1 as a is less than, equal to or greater than b.
int compare(const Words256& a, const Words256& b);
/// Little-endian bytes.
Words256 words_of(std::span<const std::uint8_t, 32> bytes);

}  // namespace umov::firmware::boot
