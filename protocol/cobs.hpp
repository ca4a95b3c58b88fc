// Consistent overhead byte stuffing: removes the byte 0 from a frame so that 0 can end it.
//
// A block is a code byte c followed by c - 1 bytes other than 0; it stands for those bytes and,
// unless c = 255 or the block is the last one, for a 0 after them. Whatever goes wrong inside a
// frame, the next 0 on the wire is the start of a new one: nothing in a frame says how long it is.
// Freestanding C++20, no heap.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace umov::protocol {

/// Ends every frame on the wire and occurs nowhere inside one.
inline constexpr std::uint8_t frame_delimiter = 0;

/// Largest encoded size of `size` bytes, delimiter not included.
constexpr std::size_t cobs_encoded_max(std::size_t size) {
  return size + size / 254 + 1;
}

/// Encodes `in` into `out` without the delimiter. Returns the number of bytes written,
/// at least 1; 0 when `out` is shorter than cobs_encoded_max(in.size()).
constexpr std::size_t cobs_encode(std::span<const std::uint8_t> in, std::span<std::uint8_t> out) {
  if (out.size() < cobs_encoded_max(in.size())) return 0;
  std::size_t code_at = 0;
  std::size_t next = 1;
  std::uint8_t code = 1;
  for (std::size_t i = 0; i < in.size(); ++i) {
    if (in[i] != 0) {
      out[next++] = in[i];
      ++code;
    }
    const bool full_block = code == 0xff && i + 1 < in.size();
    if (in[i] == 0 || full_block) {
      out[code_at] = code;
      code_at = next++;
      code = 1;
    }
  }
  out[code_at] = code;
  return next;
}

/// What a decoder makes of the last byte it was given.
enum class CobsEvent : std::uint8_t {
  more,       ///< inside a frame
  idle,       ///< a delimiter with nothing before it
  complete,   ///< a frame has ended; `decoded()` holds it until the next push
  malformed,  ///< a frame has ended in the middle of a block
  overlong,   ///< a frame has ended that is longer than the capacity
};

/// Decodes a stream byte by byte into a buffer of `Capacity` bytes. Every delimiter starts afresh,
/// so at most the damaged frame (or, when its delimiter is what was damaged, it and the next) is
/// lost.
template <std::size_t Capacity>
class CobsDecoder {
 public:
  constexpr CobsEvent push(std::uint8_t byte) {
    if (byte == frame_delimiter) return end();
    if (!started_) {
      started_ = true;
      size_ = 0;
    }
    if (left_in_block_ == 0) {
      if (zero_is_due_) append(0);
      left_in_block_ = static_cast<std::uint8_t>(byte - 1);
      zero_is_due_ = byte != 0xff;
    } else {
      append(byte);
      --left_in_block_;
    }
    return CobsEvent::more;
  }

  /// The frame last completed.
  constexpr std::span<const std::uint8_t> decoded() const {
    return std::span<const std::uint8_t>(buffer_.data(), size_);
  }

  /// Forgets a frame that has begun.
  constexpr void reset() {
    started_ = false;
    overlong_ = false;
    zero_is_due_ = false;
    left_in_block_ = 0;
  }

 private:
  constexpr void append(std::uint8_t byte) {
    if (size_ < Capacity) {
      buffer_[size_++] = byte;
    } else {
      overlong_ = true;
    }
  }

  constexpr CobsEvent end() {
    const CobsEvent event = !started_             ? CobsEvent::idle
                            : overlong_           ? CobsEvent::overlong
                            : left_in_block_ != 0 ? CobsEvent::malformed
                                                  : CobsEvent::complete;
    reset();
    return event;
  }

  std::array<std::uint8_t, Capacity> buffer_{};
  std::size_t size_ = 0;
  std::uint8_t left_in_block_ = 0;
  bool started_ = false;
  bool overlong_ = false;
  bool zero_is_due_ = false;
};

}  // namespace umov::protocol
