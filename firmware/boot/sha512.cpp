#include "firmware/boot/sha512.hpp"

#include <algorithm>
#include <bit>
#include <type_traits>
#include <utility>

namespace umov::firmware::boot {
namespace {

/// FIPS 180-4, 4.2.3: fractions of the cube roots of the first eighty primes.
constexpr std::array<std::uint64_t, 80> round_constants = {
    0x428A2F98D728AE22, 0x7137449123EF65CD, 0xB5C0FBCFEC4D3B2F, 0xE9B5DBA58189DBBC,
    0x3956C25BF348B538, 0x59F111F1B605D019, 0x923F82A4AF194F9B, 0xAB1C5ED5DA6D8118,
    0xD807AA98A3030242, 0x12835B0145706FBE, 0x243185BE4EE4B28C, 0x550C7DC3D5FFB4E2,
    0x72BE5D74F27B896F, 0x80DEB1FE3B1696B1, 0x9BDC06A725C71235, 0xC19BF174CF692694,
    0xE49B69C19EF14AD2, 0xEFBE4786384F25E3, 0x0FC19DC68B8CD5B5, 0x240CA1CC77AC9C65,
    0x2DE92C6F592B0275, 0x4A7484AA6EA6E483, 0x5CB0A9DCBD41FBD4, 0x76F988DA831153B5,
    0x983E5152EE66DFAB, 0xA831C66D2DB43210, 0xB00327C898FB213F, 0xBF597FC7BEEF0EE4,
    0xC6E00BF33DA88FC2, 0xD5A79147930AA725, 0x06CA6351E003826F, 0x142929670A0E6E70,
    0x27B70A8546D22FFC, 0x2E1B21385C26C926, 0x4D2C6DFC5AC42AED, 0x53380D139D95B3DF,
    0x650A73548BAF63DE, 0x766A0ABB3C77B2A8, 0x81C2C92E47EDAEE6, 0x92722C851482353B,
    0xA2BFE8A14CF10364, 0xA81A664BBC423001, 0xC24B8B70D0F89791, 0xC76C51A30654BE30,
    0xD192E819D6EF5218, 0xD69906245565A910, 0xF40E35855771202A, 0x106AA07032BBD1B8,
    0x19A4C116B8D2D0C8, 0x1E376C085141AB53, 0x2748774CDF8EEB99, 0x34B0BCB5E19B48A8,
    0x391C0CB3C5C95A63, 0x4ED8AA4AE3418ACB, 0x5B9CCA4F7763E373, 0x682E6FF3D6B2B8A3,
    0x748F82EE5DEFB2FC, 0x78A5636F43172F60, 0x84C87814A1F0AB72, 0x8CC702081A6439EC,
    0x90BEFFFA23631E28, 0xA4506CEBDE82BDE9, 0xBEF9A3F7B2C67915, 0xC67178F2E372532B,
    0xCA273ECEEA26619C, 0xD186B8C721C0C207, 0xEADA7DD6CDE0EB1E, 0xF57D4F7FEE6ED178,
    0x06F067AA72176FBA, 0x0A637DC5A2C898A6, 0x113F9804BEF90DAE, 0x1B710B35131C471B,
    0x28DB77F523047D84, 0x32CAAB7B40C72493, 0x3C9EBE0A15C9BEBC, 0x431D67C49C100D4C,
    0x4CC5D4BECB3E42B6, 0x597F299CFC657E2A, 0x5FCB6FAB3AD6FAEC, 0x6C44198C4A475817};

}  // namespace

void Sha512::take_block(const std::uint8_t* block) {
  // The message schedule as a ring of its last sixteen words.
  std::array<std::uint64_t, 16> w;
  for (std::size_t i = 0; i < 16; ++i) {
    std::uint64_t word = 0;
    for (std::size_t b = 0; b < 8; ++b) word = word << 8 | block[8 * i + b];
    w[i] = word;
  }
  std::array<std::uint64_t, 8> v = state_;
  // Eight rounds in a row have the names of a to h move round once, instead of the words.
  for (std::size_t t = 0; t < 80; t += 8) {
    if (t >= 16) {
      for (std::size_t i = t; i < t + 8; ++i) {
        const std::uint64_t w15 = w[(i + 1) % 16], w2 = w[(i + 14) % 16];
        const std::uint64_t s0 = std::rotr(w15, 1) ^ std::rotr(w15, 8) ^ w15 >> 7;
        const std::uint64_t s1 = std::rotr(w2, 19) ^ std::rotr(w2, 61) ^ w2 >> 6;
        w[i % 16] += s0 + w[(i + 9) % 16] + s1;
      }
    }
    const auto round = [&]<std::size_t r>(std::integral_constant<std::size_t, r>) {
      constexpr auto place = [](std::size_t letter) { return (letter + 8 - r) % 8; };
      const std::uint64_t a = v[place(0)], b = v[place(1)], c = v[place(2)], e = v[place(4)],
                          f = v[place(5)], g = v[place(6)];
      const std::uint64_t sum1 = std::rotr(e, 14) ^ std::rotr(e, 18) ^ std::rotr(e, 41);
      const std::uint64_t t1 =
          v[place(7)] + sum1 + (g ^ (e & (f ^ g))) + round_constants[t + r] + w[(t + r) % 16];
      const std::uint64_t sum0 = std::rotr(a, 28) ^ std::rotr(a, 34) ^ std::rotr(a, 39);
      v[place(3)] += t1;
      v[place(7)] = t1 + sum0 + ((a & (b | c)) | (b & c));
    };
    [&]<std::size_t... r>(std::index_sequence<r...>) {
      (round(std::integral_constant<std::size_t, r>{}), ...);
    }
    (std::make_index_sequence<8>{});
  }
  for (std::size_t i = 0; i < 8; ++i) state_[i] += v[i];
}

void Sha512::update(std::span<const std::uint8_t> bytes) {
  total_bytes_ += bytes.size();
  while (!bytes.empty()) {
    if (waiting_bytes_ == 0 && bytes.size() >= block_bytes) {
      take_block(bytes.data());
      bytes = bytes.subspan(block_bytes);
      continue;
    }
    const std::size_t size = std::min(block_bytes - waiting_bytes_, bytes.size());
    std::copy_n(bytes.begin(), size,
                waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_bytes_));
    waiting_bytes_ += size;
    bytes = bytes.subspan(size);
    if (waiting_bytes_ == block_bytes) {
      take_block(waiting_.data());
      waiting_bytes_ = 0;
    }
  }
}

Sha512::Digest Sha512::finish() {
  // One bit, zeros, and the length in bits as a 128-bit number.
  const std::uint64_t bits = total_bytes_ * 8;
  constexpr std::uint8_t one_bit = 0x80, zero = 0;
  update(std::span(&one_bit, 1));
  while (waiting_bytes_ != block_bytes - 16) update(std::span(&zero, 1));
  std::array<std::uint8_t, 16> length{};
  for (std::size_t i = 0; i < 8; ++i) {
    length[8 + i] = static_cast<std::uint8_t>(bits >> (56 - 8 * i));
  }
  update(length);
  Digest digest;
  for (std::size_t i = 0; i < digest.size(); ++i) {
    digest[i] = static_cast<std::uint8_t>(state_[i / 8] >> (56 - 8 * (i % 8)));
  }
  return digest;
}

}  // namespace umov::firmware::boot
