// Bytes of a message, derived from its declaration: integers and arrays of integers, little-endian,
// in the order of `fields`, without padding. Freestanding C++20, no heap.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>

#include "protocol/field.hpp"
#include "protocol/messages.hpp"

namespace umov::protocol {

/// What a field is made of: `Element` x `count`.
template <class Member>
struct FieldShape {
  using Element = Member;
  static constexpr std::size_t count = 1;
  static constexpr bool is_array = false;
};
template <class T, std::size_t N>
struct FieldShape<std::array<T, N>> {
  using Element = T;
  static constexpr std::size_t count = N;
  static constexpr bool is_array = true;
};

/// Bytes of one field on the wire.
template <class Member>
inline constexpr std::size_t field_size =
    sizeof(typename FieldShape<Member>::Element) * FieldShape<Member>::count;

/// Calls `visit(field)` for every declared field of message `M`, in wire order.
template <class M, class Visitor>
constexpr void for_each_field(Visitor&& visit) {
  std::apply([&](const auto&... declared) { (visit(declared), ...); }, M::fields);
}

/// Calls `visit.template operator()<M>()` for every message of the protocol.
template <class Visitor>
constexpr void for_each_message(Visitor&& visit) {
  [&]<class... M>(std::type_identity<std::tuple<M...>>) {
    (visit.template operator()<M>(), ...);
  }(std::type_identity<AllMessages>{});
}

namespace codec_detail {

template <class M, class... Member>
constexpr std::size_t sum_of_sizes(const std::tuple<Field<M, Member>...>&) {
  return (field_size<Member> + ... + 0);
}

template <class T>
constexpr bool within(T value, std::int64_t min, std::int64_t max) {
  if (min >= max) return true;
  if constexpr (std::is_same_v<T, char>) {
    return std::int64_t{value} >= min && std::int64_t{value} <= max;
  } else {
    return std::cmp_greater_equal(value, min) && std::cmp_less_equal(value, max);
  }
}

template <class T>
constexpr void put(T value, std::uint8_t*& to) {
  auto bits = static_cast<std::make_unsigned_t<T>>(value);
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    *to++ = static_cast<std::uint8_t>(bits & 0xffu);
    if constexpr (sizeof(T) > 1) bits = static_cast<std::make_unsigned_t<T>>(bits >> 8);
  }
}

template <class T>
constexpr T take(const std::uint8_t*& from) {
  using Bits = std::make_unsigned_t<T>;
  Bits bits = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bits = static_cast<Bits>(bits | static_cast<Bits>(static_cast<Bits>(*from++) << (8 * i)));
  }
  return static_cast<T>(bits);
}

}  // namespace codec_detail

/// Bytes of message `M` on the wire.
template <class M>
inline constexpr std::size_t wire_size = codec_detail::sum_of_sizes(M::fields);

/// No message of any version is longer; both ends size their buffers by it.
inline constexpr std::size_t max_payload_size = 128;

enum class CodecStatus : std::uint8_t { ok, bad_length, out_of_range };

/// How coding a message went. `field` is the number (from 0) of the field out of range, else -1.
struct CodecResult {
  CodecStatus status = CodecStatus::ok;
  std::int8_t field = -1;
  constexpr bool ok() const { return status == CodecStatus::ok; }
};

/// Whether every field of `message` lies in its declared range.
template <class M>
constexpr CodecResult check_ranges(const M& message) {
  CodecResult result;
  std::int8_t number = 0;
  for_each_field<M>([&](const auto& declared) {
    const auto& value = message.*(declared.member);
    bool inside = true;
    if constexpr (FieldShape<std::remove_cvref_t<decltype(value)>>::is_array) {
      for (const auto element : value) {
        inside = inside && codec_detail::within(element, declared.min, declared.max);
      }
    } else {
      inside = codec_detail::within(value, declared.min, declared.max);
    }
    if (!inside && result.ok()) result = {CodecStatus::out_of_range, number};
    ++number;
  });
  return result;
}

/// Writes `message` to the first wire_size<M> bytes of `out`.
/// bad_length when `out` is shorter, out_of_range when a field is; then nothing is written.
template <class M>
constexpr CodecResult encode(const M& message, std::span<std::uint8_t> out) {
  static_assert(wire_size<M> <= max_payload_size);
  if (out.size() < wire_size<M>) return {CodecStatus::bad_length, -1};
  if (const CodecResult ranges = check_ranges(message); !ranges.ok()) return ranges;
  std::uint8_t* to = out.data();
  for_each_field<M>([&](const auto& declared) {
    const auto& value = message.*(declared.member);
    if constexpr (FieldShape<std::remove_cvref_t<decltype(value)>>::is_array) {
      for (const auto element : value) codec_detail::put(element, to);
    } else {
      codec_detail::put(value, to);
    }
  });
  return {};
}

/// Reads a message from a payload of exactly wire_size<M> bytes. `message` changes only when the
/// result is ok.
template <class M>
constexpr CodecResult decode(std::span<const std::uint8_t> payload, M& message) {
  if (payload.size() != wire_size<M>) return {CodecStatus::bad_length, -1};
  M read{};
  const std::uint8_t* from = payload.data();
  for_each_field<M>([&](const auto& declared) {
    auto& value = read.*(declared.member);
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (FieldShape<Value>::is_array) {
      for (auto& element : value) {
        element = codec_detail::take<typename FieldShape<Value>::Element>(from);
      }
    } else {
      value = codec_detail::take<Value>(from);
    }
  });
  const CodecResult ranges = check_ranges(read);
  if (ranges.ok()) message = read;
  return ranges;
}

/// Name of the message with this type byte, empty if there is none.
constexpr std::string_view message_name(std::uint8_t id) {
  std::string_view name;
  for_each_message([&]<class M>() {
    if (M::info.id == id) name = M::info.name;
  });
  return name;
}

namespace codec_detail {

constexpr bool declarations_are_sound() {
  bool sound = true;
  std::array<int, 256> uses{};
  for_each_message([&]<class M>() {
    sound = sound && ++uses[M::info.id] == 1 && wire_size<M> <= max_payload_size;
  });
  return sound;
}
static_assert(declarations_are_sound(), "two messages share a type byte, or one is too long");

}  // namespace codec_detail
}  // namespace umov::protocol
