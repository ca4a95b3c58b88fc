#include "protocol/frame.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace umov::protocol {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes ack_frame(std::uint16_t sequence) {
  Bytes frame(wire_frame_size<RecordAck>);
  frame.resize(FrameWriter::write(sequence, RecordAck{77, sequence}, frame));
  return frame;
}

void append(Bytes& to, const Bytes& more) {
  to.insert(to.end(), more.begin(), more.end());
}

std::vector<int> sequences_in(FrameReader& reader, const Bytes& bytes) {
  std::vector<int> sequences;
  reader.feed(bytes, [&](const FrameView& frame) { sequences.push_back(frame.sequence); });
  return sequences;
}

TEST(Frame, AMessageArrivesWithTypeSequenceAndContents) {
  FrameReader reader;
  int seen = 0;
  reader.feed(ack_frame(0xbeef), [&](const FrameView& frame) {
    ++seen;
    EXPECT_EQ(frame.type, RecordAck::info.id);
    EXPECT_EQ(frame.sequence, 0xbeef);
    RecordAck ack;
    ASSERT_TRUE(decode(frame.payload, ack).ok());
    EXPECT_EQ(ack.program_id, 77u);
    EXPECT_EQ(ack.next_index, 0xbeefu);
  });
  EXPECT_EQ(seen, 1);
}

TEST(Frame, TheChunksTheBytesComeInDoNotMatter) {
  Bytes stream;
  std::vector<int> expected;
  for (std::uint16_t i = 0; i < 200; ++i) {
    append(stream, ack_frame(i));
    expected.push_back(i);
  }
  std::mt19937_64 random(4);
  for (int round = 0; round < 50; ++round) {
    FrameReader reader;
    std::vector<int> found;
    for (std::size_t at = 0; at < stream.size();) {
      const std::size_t size = std::min<std::size_t>(random() % 40, stream.size() - at);
      const auto some =
          sequences_in(reader, Bytes(stream.begin() + static_cast<std::ptrdiff_t>(at),
                                     stream.begin() + static_cast<std::ptrdiff_t>(at + size)));
      found.insert(found.end(), some.begin(), some.end());
      at += size;
    }
    ASSERT_EQ(found, expected);
  }
}

TEST(Frame, NoDamageToOneByteCostsMoreThanTwoFrames) {
  // Every byte of a stream of three frames is changed to every other value. What remains must be
  // frames that were sent: only the damaged one may be missing, and its successor when the
  // delimiter between them was hit.
  Bytes stream = ack_frame(1);
  append(stream, ack_frame(2));
  append(stream, ack_frame(3));
  for (std::size_t at = 0; at < stream.size(); ++at) {
    for (int change = 1; change < 256; ++change) {
      Bytes damaged = stream;
      damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ change);
      const bool hit_delimiter = stream[at] == frame_delimiter;
      append(damaged, ack_frame(4));
      append(damaged, ack_frame(5));
      FrameReader reader;
      const std::vector<int> found = sequences_in(reader, damaged);
      ASSERT_GE(found.size(), hit_delimiter ? 3u : 4u) << "byte " << at << " change " << change;
      ASSERT_TRUE(std::ranges::is_sorted(found));
      ASSERT_EQ(found.back(), 5);
      const FrameCounters& counters = reader.counters();
      ASSERT_GE(counters.bad_crc + counters.oversize + counters.garbage, 1u);
    }
  }
}

TEST(Frame, NoiseIsCountedAndNothingInItIsTakenForAFrame) {
  std::mt19937_64 random(5);
  FrameReader reader;
  Bytes noise(1 << 20);
  for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
  EXPECT_TRUE(sequences_in(reader, noise).empty());
  const FrameCounters& counters = reader.counters();
  EXPECT_EQ(counters.good, 0u);
  EXPECT_GT(counters.bad_crc + counters.garbage, 1000u);
  EXPECT_GT(counters.oversize, 1000u);
  Bytes after{frame_delimiter};
  append(after, ack_frame(9));
  EXPECT_EQ(sequences_in(reader, after), std::vector<int>{9});
}

TEST(Frame, RandomPayloadsOfEveryLengthComeBack) {
  std::mt19937_64 random(6);
  FrameReader reader;
  for (std::size_t size = 0; size <= max_payload_size; ++size) {
    Bytes payload(size);
    for (auto& byte : payload) byte = static_cast<std::uint8_t>(random() % 4);
    Bytes frame(max_wire_frame_size);
    frame.resize(FrameWriter::write_raw(0x42, 7, payload, frame));
    ASSERT_GT(frame.size(), 0u);
    int seen = 0;
    reader.feed(frame, [&](const FrameView& view) {
      ++seen;
      EXPECT_TRUE(std::ranges::equal(view.payload, payload));
    });
    ASSERT_EQ(seen, 1);
  }
}

TEST(Frame, WhatDoesNotFitIsNotWritten) {
  Bytes out(max_wire_frame_size);
  EXPECT_EQ(FrameWriter::write_raw(1, 1, Bytes(max_payload_size + 1), out), 0u);
  Bytes small(wire_frame_size<RecordAck> - 1);
  EXPECT_EQ(FrameWriter::write(std::uint16_t{1}, RecordAck{}, small), 0u);
  EXPECT_EQ(FrameWriter::write(std::uint16_t{1}, ClearFault{0}, out), 0u) << "out of range";
}

}  // namespace
}  // namespace umov::protocol
