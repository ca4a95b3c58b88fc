#include "firmware/boot/field25519.hpp"

namespace umov::firmware::boot {
namespace {

constexpr Words256 prime = {0xFFFFFFEDu, 0xFFFFFFFFu, 0xFFFFFFFFu, 0xFFFFFFFFu,
                            0xFFFFFFFFu, 0xFFFFFFFFu, 0xFFFFFFFFu, 0x7FFFFFFFu};
/// 2^256 modulo p.
constexpr std::uint32_t fold = 38;

/// Adds carry · 2^256, twice where the first addition carries again.
void add_carry(Words256& w, std::uint32_t carry) {
  while (carry != 0) {
    std::uint64_t sum = std::uint64_t{carry} * fold;
    for (std::uint32_t& word : w) {
      sum += word;
      word = static_cast<std::uint32_t>(sum);
      sum >>= 32;
    }
    carry = static_cast<std::uint32_t>(sum);
  }
}

/// a − b, and whether it went below zero.
bool subtract_words(Words256& a, const Words256& b) {
  std::int64_t difference = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    difference += std::int64_t{a[i]} - b[i];
    a[i] = static_cast<std::uint32_t>(difference);
    difference >>= 32;
  }
  return difference < 0;
}

/// a^e for e = 2^255 − `below`, or 2^252 − `below`: all ones down to the last bits.
Field power(const Field& a, int bits, std::uint32_t below) {
  Field result = field_one;
  const std::uint32_t low = 0u - below;  // the lowest 32 bits of the exponent
  for (int bit = bits - 1; bit >= 0; --bit) {
    result = square(result);
    if (bit >= 32 || (low >> bit & 1u) != 0) result = multiply(result, a);
  }
  return result;
}

}  // namespace

int compare(const Words256& a, const Words256& b) {
  for (std::size_t i = 8; i-- > 0;) {
    if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
  }
  return 0;
}

Words256 words_of(std::span<const std::uint8_t, 32> bytes) {
  Words256 words{};
  for (std::size_t i = 0; i < 32; ++i) {
    words[i / 4] |= static_cast<std::uint32_t>(bytes[i]) << (8 * (i % 4));
  }
  return words;
}

Field add(const Field& a, const Field& b) {
  Field sum;
  std::uint64_t carry = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    carry += std::uint64_t{a.w[i]} + b.w[i];
    sum.w[i] = static_cast<std::uint32_t>(carry);
    carry >>= 32;
  }
  add_carry(sum.w, static_cast<std::uint32_t>(carry));
  return sum;
}

Field subtract(const Field& a, const Field& b) {
  Field difference = a;
  // Below zero it reads 2^256 too much, which is 38 too much modulo p.
  constexpr Words256 too_much = {fold};
  for (bool below = subtract_words(difference.w, b.w); below;) {
    below = subtract_words(difference.w, too_much);
  }
  return difference;
}

Field multiply(const Field& a, const Field& b) {
  std::array<std::uint32_t, 16> product{};
  for (std::size_t i = 0; i < 8; ++i) {
    std::uint64_t carry = 0;
    for (std::size_t j = 0; j < 8; ++j) {
      // At most (2^32 − 1)² + 2 (2^32 − 1) = 2^64 − 1.
      carry += std::uint64_t{a.w[i]} * b.w[j] + product[i + j];
      product[i + j] = static_cast<std::uint32_t>(carry);
      carry >>= 32;
    }
    product[i + 8] = static_cast<std::uint32_t>(carry);
  }
  Field result;
  std::uint64_t carry = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    carry += std::uint64_t{product[i + 8]} * fold + product[i];
    result.w[i] = static_cast<std::uint32_t>(carry);
    carry >>= 32;
  }
  add_carry(result.w, static_cast<std::uint32_t>(carry));
  return result;
}

Field invert(const Field& a) {
  return power(a, 255, 21);  // p − 2 = 2^255 − 21
}

Field power_p58(const Field& a) {
  return power(a, 252, 3);  // (p − 5) / 8 = 2^252 − 3
}

Field reduced(const Field& a) {
  // Below 2^256 = 2 p + 38: at most two subtractions.
  Field result = a;
  while (compare(result.w, prime) >= 0) subtract_words(result.w, prime);
  return result;
}

bool is_zero(const Field& a) {
  return reduced(a).w == field_zero.w;
}

bool is_odd(const Field& a) {
  return (reduced(a).w[0] & 1u) != 0;
}

}  // namespace umov::firmware::boot
