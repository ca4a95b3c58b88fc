// How a message is declared: every field once, with unit, range and meaning. The codec, the
// schema hash, PROTOCOL.md and the test vectors are all derived from these declarations.
// Freestanding C++20, no heap.
#pragma once

#include <cstdint>
#include <string_view>

namespace umov::protocol {

/// Who sends a message.
enum class Sender : std::uint8_t { host, device };

/// Identity and meaning of a message. `id` is the type byte on the wire.
struct MessageInfo {
  std::uint8_t id;
  std::string_view name;
  Sender sender;
  std::string_view doc;
};

/// One field of message `M`. `Member` is an integer or a std::array of integers; on the wire it is
/// little-endian, without padding, in declaration order. Values outside [min, max] are refused by
/// both ends when `min < max`; `min == max == 0` means any value of the type.
template <class M, class Member>
struct Field {
  std::string_view name;
  Member M::*member;
  std::string_view unit;
  std::int64_t min;
  std::int64_t max;
  std::string_view doc;
};

template <class M, class Member>
constexpr Field<M, Member> field(std::string_view name, Member M::*member, std::string_view unit,
                                 std::string_view doc, std::int64_t min = 0, std::int64_t max = 0) {
  return {name, member, unit, min, max, doc};
}

}  // namespace umov::protocol
