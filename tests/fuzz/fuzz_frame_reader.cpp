// Any bytes through the frame reader and every frame that comes out through every decoder.
// fuzz-link: umov_protocol
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "protocol/frame.hpp"

namespace {

using namespace umov::protocol;

/// What a message decodes to must encode to the same bytes again.
template <class M>
void decode_and_encode(std::span<const std::uint8_t> payload) {
  M message{};
  if (!decode(payload, message).ok()) return;
  std::array<std::uint8_t, wire_size<M>> again{};
  if (!encode(message, again).ok()) std::abort();
  for (std::size_t i = 0; i < payload.size(); ++i) {
    if (again[i] != payload[i]) std::abort();
  }
}

void decode_all(std::span<const std::uint8_t> payload) {
  for_each_message([&]<class M>() { decode_and_encode<M>(payload); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  decode_all(bytes);

  FrameReader reader;
  std::size_t frames = 0;
  reader.feed(bytes, [&](const FrameView& frame) {
    ++frames;
    decode_all(frame.payload);
  });
  // A CRC is hard to guess: give the decoders behind it the same bytes in a frame of their own,
  // after whatever the input left in the reader.
  std::array<std::uint8_t, max_wire_frame_size> frame{};
  const std::size_t payload_size = size < max_payload_size ? size : max_payload_size;
  const std::size_t written = FrameWriter::write_raw(1, 2, bytes.first(payload_size), frame);
  const std::uint8_t delimiter = 0;
  reader.feed(std::span<const std::uint8_t>(&delimiter, 1), [](const FrameView&) {});
  std::size_t found = 0;
  reader.feed(std::span<const std::uint8_t>(frame).first(written), [&](const FrameView& view) {
    ++found;
    if (view.payload.size() != payload_size) std::abort();
    decode_all(view.payload);
  });
  if (found != 1 || reader.counters().good < frames + 1) std::abort();
  return 0;
}
