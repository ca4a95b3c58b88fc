// Hash of all message declarations. Host and device talk only when theirs are equal, so a field
// added on one side is a clear refusal instead of shifted bytes. Freestanding C++20, no heap.
#pragma once

#include <cstdint>
#include <string_view>
#include <type_traits>

#include "protocol/codec.hpp"
#include "protocol/messages.hpp"

namespace umov::protocol {

/// FNV-1a, 64 bit.
class Fnv1a64 {
 public:
  constexpr void byte(std::uint8_t value) {
    hash_ ^= value;
    hash_ *= 0x100000001b3u;
  }
  constexpr void text(std::string_view characters) {
    for (const char c : characters) byte(static_cast<std::uint8_t>(c));
    byte(0);  // "ab","c" and "a","bc" differ
  }
  constexpr void number(std::uint64_t value) {
    for (int i = 0; i < 8; ++i) byte(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  constexpr std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

/// Covers version, and of every message type byte, name, sender and of every field name, element
/// size, signedness, count, unit and range, in order. Explanatory texts may change freely.
constexpr std::uint64_t compute_schema_hash() {
  Fnv1a64 hash;
  hash.number(protocol_version);
  for_each_message([&]<class M>() {
    hash.byte(M::info.id);
    hash.text(M::info.name);
    hash.byte(static_cast<std::uint8_t>(M::info.sender));
    for_each_field<M>([&]<class Member>(const Field<M, Member>& declared) {
      using Element = typename FieldShape<Member>::Element;
      hash.text(declared.name);
      hash.byte(sizeof(Element));
      // Plain char is signed on x86 and unsigned on ARM; it is text here, neither.
      hash.byte(std::is_same_v<Element, char> ? 2 : (std::is_signed_v<Element> ? 1 : 0));
      hash.number(FieldShape<Member>::count);
      hash.text(declared.unit);
      hash.number(static_cast<std::uint64_t>(declared.min));
      hash.number(static_cast<std::uint64_t>(declared.max));
    });
  });
  return hash.value();
}

inline constexpr std::uint64_t schema_hash = compute_schema_hash();

}  // namespace umov::protocol
