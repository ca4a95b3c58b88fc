#include "firmware/boot/ed25519.hpp"

#include <algorithm>

#include "firmware/boot/field25519.hpp"

namespace umov::firmware::boot {
namespace {

// RFC 8032, 5.1: −x² + y² = 1 + d x² y², base point B, order of its group L.
constexpr Field curve_d{{0x135978A3u, 0x75EB4DCAu, 0x4141D8ABu, 0x00700A4Du, 0x7779E898u,
                         0x8CC74079u, 0x2B6FFE73u, 0x52036CEEu}};
constexpr Field twice_d{{0x26B2F159u, 0xEBD69B94u, 0x8283B156u, 0x00E0149Au, 0xEEF3D130u,
                         0x198E80F2u, 0x56DFFCE7u, 0x2406D9DCu}};
constexpr Field root_of_minus_one{{0x4A0EA0B0u, 0xC4EE1B27u, 0xAD2FE478u, 0x2F431806u, 0x3DFBD7A7u,
                                   0x2B4D0099u, 0x4FC1DF0Bu, 0x2B832480u}};
constexpr Words256 group_order = {0x5CF5D3EDu, 0x5812631Au, 0xA2F79CD6u, 0x14DEF9DEu,
                                  0,           0,           0,           0x10000000u};

/// Extended homogeneous coordinates: x = X/Z, y = Y/Z, xy = T/Z.
struct Point {
  Field x, y, z, t;
};

constexpr Point neutral{field_zero, field_one, field_one, field_zero};
constexpr Point base{{{0x8F25D51Au, 0xC9562D60u, 0x9525A7B2u, 0x692CC760u, 0xFDD6DC5Cu, 0xC0A4E231u,
                       0xCD6E53FEu, 0x216936D3u}},
                     {{0x66666658u, 0x66666666u, 0x66666666u, 0x66666666u, 0x66666666u, 0x66666666u,
                       0x66666666u, 0x66666666u}},
                     field_one,
                     {{0xA5B7DDA3u, 0x6DDE8AB3u, 0x775152F5u, 0x20F09F80u, 0x64ABE37Du, 0x66EA4E8Eu,
                       0xD78B7665u, 0x67875F0Fu}}};

/// RFC 8032, 5.1.4; holds for any two points.
void add_to(Point& p, const Point& q) {
  const Field a = multiply(subtract(p.y, p.x), subtract(q.y, q.x));
  const Field b = multiply(add(p.y, p.x), add(q.y, q.x));
  const Field c = multiply(multiply(p.t, twice_d), q.t);
  Field d = multiply(p.z, q.z);
  d = add(d, d);
  const Field e = subtract(b, a), f = subtract(d, c), g = add(d, c), h = add(b, a);
  p = {multiply(e, f), multiply(g, h), multiply(f, g), multiply(e, h)};
}

void double_point(Point& p) {
  const Field a = square(p.x), b = square(p.y);
  Field c = square(p.z);
  c = add(c, c);
  const Field h = add(a, b);
  const Field e = subtract(h, square(add(p.x, p.y)));
  const Field g = subtract(a, b);
  const Field f = add(c, g);
  p = {multiply(e, f), multiply(g, h), multiply(f, g), multiply(e, h)};
}

/// RFC 8032, 5.1.3; false when the bytes are no point.
bool decode(const PublicKey& bytes, Point& point) {
  Words256 words = words_of(bytes);
  const bool odd = (words[7] >> 31) != 0;
  words[7] &= 0x7FFF'FFFFu;
  const Field y{words};
  if (reduced(y).w != y.w) return false;
  const Field y2 = square(y);
  const Field u = subtract(y2, field_one), v = add(multiply(curve_d, y2), field_one);
  // x = u v³ (u v⁷)^((p−5)/8), perhaps times the root of −1.
  const Field v3 = multiply(square(v), v);
  const Field uv7 = multiply(multiply(square(v3), v), u);
  Field x = multiply(multiply(u, v3), power_p58(uv7));
  const Field vx2 = multiply(v, square(x));
  if (!is_zero(subtract(vx2, u))) {
    if (!is_zero(add(vx2, u))) return false;
    x = multiply(x, root_of_minus_one);
  }
  if (is_zero(x) && odd) return false;
  if (is_odd(x) != odd) x = subtract(field_zero, x);
  point = {x, y, field_one, multiply(x, y)};
  return true;
}

PublicKey encode(const Point& p) {
  const Field inverse = invert(p.z);
  Field y = reduced(multiply(p.y, inverse));
  if (is_odd(multiply(p.x, inverse))) y.w[7] |= 0x8000'0000u;
  PublicKey bytes;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::uint8_t>(y.w[i / 4] >> (8 * (i % 4)));
  }
  return bytes;
}

/// A number of 512 bits modulo the group's order, bit by bit: its tens of thousands of instructions
/// are nothing beside the hash.
Words256 modulo_order(const Sha512::Digest& digest) {
  Words256 rest{};
  for (int bit = 511; bit >= 0; --bit) {
    std::uint32_t carry = digest[static_cast<std::size_t>(bit / 8)] >> (bit % 8) & 1u;
    for (std::uint32_t& word : rest) {
      const std::uint32_t top = word >> 31;
      word = word << 1 | carry;
      carry = top;
    }
    if (compare(rest, group_order) < 0) continue;
    std::int64_t difference = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      difference += std::int64_t{rest[i]} - group_order[i];
      rest[i] = static_cast<std::uint32_t>(difference);
      difference >>= 32;
    }
  }
  return rest;
}

/// s·B + k·A, both scalars together.
Point sum_of_products(const Words256& s, const Words256& k, const Point& a) {
  Point both = base;
  add_to(both, a);
  Point sum = neutral;
  for (int bit = 255; bit >= 0; --bit) {
    double_point(sum);
    const bool with_base = (s[static_cast<std::size_t>(bit / 32)] >> (bit % 32) & 1u) != 0;
    const bool with_a = (k[static_cast<std::size_t>(bit / 32)] >> (bit % 32) & 1u) != 0;
    if (with_base && with_a) {
      add_to(sum, both);
    } else if (with_base) {
      add_to(sum, base);
    } else if (with_a) {
      add_to(sum, a);
    }
  }
  return sum;
}

}  // namespace

SignatureCheck::SignatureCheck(const PublicKey& key, const Signature& signature)
    : key_(key), signature_(signature) {
  hash_.update(std::span(signature_).first(32));
  hash_.update(key_);
}

bool SignatureCheck::good() {
  const std::span<const std::uint8_t, 64> signature(signature_);
  const Words256 s = words_of(signature.last<32>());
  if (compare(s, group_order) >= 0) return false;
  Point a;
  if (!decode(key_, a)) return false;
  a.x = subtract(field_zero, a.x);
  a.t = subtract(field_zero, a.t);
  // R = s·B − k·A
  const PublicKey r = encode(sum_of_products(s, modulo_order(hash_.finish()), a));
  return std::equal(r.begin(), r.end(), signature.begin());
}

}  // namespace umov::firmware::boot
