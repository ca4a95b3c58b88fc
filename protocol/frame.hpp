// Frames: type, sequence number, payload and CRC, byte-stuffed and ended by 0.
//
//   raw frame = type (1) | sequence (2) | payload (0 … 128) | CRC-32C of all before it (4)
//   on the wire = COBS(raw frame) | 0
//
// Freestanding C++20, no heap.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/cobs.hpp"
#include "protocol/codec.hpp"
#include "protocol/crc32c.hpp"

namespace umov::protocol {

inline constexpr std::size_t frame_header_size = 3;
inline constexpr std::size_t frame_crc_size = 4;

/// Bytes of a frame before stuffing.
constexpr std::size_t raw_frame_size(std::size_t payload_size) {
  return frame_header_size + payload_size + frame_crc_size;
}

inline constexpr std::size_t max_raw_frame_size = raw_frame_size(max_payload_size);

/// Largest frame on the wire, delimiter included: what a send buffer must hold.
inline constexpr std::size_t max_wire_frame_size = cobs_encoded_max(max_raw_frame_size) + 1;

/// Largest frame of message `M` on the wire, delimiter included.
template <class M>
inline constexpr std::size_t wire_frame_size = cobs_encoded_max(raw_frame_size(wire_size<M>)) + 1;

/// A frame that has passed its CRC. `payload` points into the reader.
struct FrameView {
  std::uint8_t type = 0;
  std::uint16_t sequence = 0;
  std::span<const std::uint8_t> payload{};
};

/// Turns messages into frames.
class FrameWriter {
 public:
  /// Writes a frame of any payload, delimiter included. Returns its size, 0 when the payload is
  /// longer than max_payload_size or `out` is too short for the largest frame of that payload.
  static constexpr std::size_t write_raw(std::uint8_t type, std::uint16_t sequence,
                                         std::span<const std::uint8_t> payload,
                                         std::span<std::uint8_t> out) {
    if (payload.size() > max_payload_size) return 0;
    std::array<std::uint8_t, max_raw_frame_size> raw{};
    std::size_t size = 0;
    raw[size++] = type;
    raw[size++] = static_cast<std::uint8_t>(sequence & 0xffu);
    raw[size++] = static_cast<std::uint8_t>(sequence >> 8);
    for (const std::uint8_t byte : payload) raw[size++] = byte;
    const std::uint32_t crc = crc32c(std::span<const std::uint8_t>(raw.data(), size));
    for (int i = 0; i < 4; ++i) raw[size++] = static_cast<std::uint8_t>((crc >> (8 * i)) & 0xffu);
    if (out.size() < cobs_encoded_max(size) + 1) return 0;
    const std::size_t written = cobs_encode(std::span<const std::uint8_t>(raw.data(), size), out);
    out[written] = frame_delimiter;
    return written + 1;
  }

  /// Writes a frame of `message`. Returns its size; 0 when a field is out of range or `out` is
  /// shorter than wire_frame_size<M>.
  template <class M>
  static constexpr std::size_t write(std::uint16_t sequence, const M& message,
                                     std::span<std::uint8_t> out) {
    std::array<std::uint8_t, wire_size<M>> payload{};
    if (!encode(message, payload).ok()) return 0;
    return write_raw(M::info.id, sequence, payload, out);
  }
};

/// What a reader has met, for diagnostics. Everything that is not `good` was dropped.
struct FrameCounters {
  std::uint32_t good = 0;
  std::uint32_t bad_crc = 0;
  std::uint32_t oversize = 0;  ///< longer than any frame of the protocol
  std::uint32_t garbage = 0;   ///< not byte-stuffed properly, or too short to be a frame
};

/// Finds frames in a stream of bytes that comes in chunks of any size.
class FrameReader {
 public:
  /// Takes bytes from the front of `bytes` until a good frame is complete (true: `frame` is valid
  /// until the next call) or none are left (false). Call in a loop.
  constexpr bool next(std::span<const std::uint8_t>& bytes, FrameView& frame) {
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (accept(decoder_.push(bytes[i]), frame)) {
        bytes = bytes.subspan(i + 1);
        return true;
      }
    }
    bytes = {};
    return false;
  }

  /// Calls `on_frame(const FrameView&)` for every good frame that `bytes` completes.
  template <class Handler>
  constexpr void feed(std::span<const std::uint8_t> bytes, Handler&& on_frame) {
    FrameView frame;
    while (next(bytes, frame)) on_frame(static_cast<const FrameView&>(frame));
  }

  /// Forgets a frame that has begun.
  constexpr void reset() { decoder_.reset(); }

  constexpr const FrameCounters& counters() const { return counters_; }

 private:
  constexpr bool accept(CobsEvent event, FrameView& frame) {
    switch (event) {
      case CobsEvent::more:
      case CobsEvent::idle:
        return false;
      case CobsEvent::overlong:
        ++counters_.oversize;
        return false;
      case CobsEvent::malformed:
        ++counters_.garbage;
        return false;
      case CobsEvent::complete:
        break;
    }
    const std::span<const std::uint8_t> raw = decoder_.decoded();
    if (raw.size() < raw_frame_size(0)) {
      ++counters_.garbage;
      return false;
    }
    const std::size_t covered = raw.size() - frame_crc_size;
    std::uint32_t sent = 0;
    for (std::size_t i = 0; i < frame_crc_size; ++i) {
      sent |= static_cast<std::uint32_t>(raw[covered + i]) << (8 * i);
    }
    if (crc32c(raw.first(covered)) != sent) {
      ++counters_.bad_crc;
      return false;
    }
    frame.type = raw[0];
    frame.sequence = static_cast<std::uint16_t>(raw[1] | (raw[2] << 8));
    frame.payload = raw.subspan(frame_header_size, covered - frame_header_size);
    ++counters_.good;
    return true;
  }

  CobsDecoder<max_raw_frame_size> decoder_{};
  FrameCounters counters_{};
};

}  // namespace umov::protocol
