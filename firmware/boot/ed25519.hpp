// Verification of Ed25519 signatures (RFC 8032, 5.1.7), for messages that are read piece by piece.
// No heap; less than 3 KB of stack.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/boot/sha512.hpp"

namespace umov::firmware::boot {

using PublicKey = std::array<std::uint8_t, 32>;
using Signature = std::array<std::uint8_t, 64>;

/// update() with the message, in pieces of any size, then good() once. Strict: a key that is no
/// point, and a number S of the group's order or more, are refused; what is left is compared with R
/// as bytes, as libsodium does.
class SignatureCheck {
 public:
  SignatureCheck(const PublicKey& key, const Signature& signature);

  void update(std::span<const std::uint8_t> message) { hash_.update(message); }
  bool good();

 private:
  PublicKey key_;
  Signature signature_;
  Sha512 hash_;
};

}  // namespace umov::firmware::boot
