#include "protocol/cobs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace umov::protocol {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes encoded(const Bytes& bytes) {
  Bytes out(cobs_encoded_max(bytes.size()));
  out.resize(cobs_encode(bytes, out));
  return out;
}

template <std::size_t Capacity>
CobsEvent push_all(CobsDecoder<Capacity>& decoder, const Bytes& bytes) {
  CobsEvent event = CobsEvent::more;
  for (const std::uint8_t byte : bytes) event = decoder.push(byte);
  return event;
}

Bytes counting(std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(1 + i % 255);
  return bytes;
}

TEST(Cobs, TheEncodingOfTheKnownExamplesIsAsPublished) {
  EXPECT_EQ(encoded({}), (Bytes{0x01}));
  EXPECT_EQ(encoded({0x00}), (Bytes{0x01, 0x01}));
  EXPECT_EQ(encoded({0x00, 0x00}), (Bytes{0x01, 0x01, 0x01}));
  EXPECT_EQ(encoded({0x11, 0x22, 0x00, 0x33}), (Bytes{0x03, 0x11, 0x22, 0x02, 0x33}));
  EXPECT_EQ(encoded({0x11, 0x00, 0x00, 0x00}), (Bytes{0x02, 0x11, 0x01, 0x01, 0x01}));
}

TEST(Cobs, ABlockOf254BytesGetsNoCodeByteAfterItUnlessMoreFollows) {
  Bytes expected = counting(254);
  expected.insert(expected.begin(), 0xff);
  EXPECT_EQ(encoded(counting(254)), expected);

  expected.push_back(0x02);
  expected.push_back(0xff);
  EXPECT_EQ(encoded(counting(255)), expected);
}

TEST(Cobs, WhatIsEncodedDecodesToTheSameAndHoldsNoZero) {
  std::mt19937_64 random(1);
  CobsDecoder<1000> decoder;
  for (int round = 0; round < 4000; ++round) {
    Bytes bytes(random() % 900);
    const bool sparse = round % 2 == 0;
    for (auto& byte : bytes) {
      byte = sparse && random() % 64 != 0 ? static_cast<std::uint8_t>(1 + random() % 255)
                                          : static_cast<std::uint8_t>(random() % 3);
    }
    Bytes wire = encoded(bytes);
    ASSERT_EQ(std::count(wire.begin(), wire.end(), 0), 0);
    ASSERT_LE(wire.size(), cobs_encoded_max(bytes.size()));
    wire.push_back(frame_delimiter);
    ASSERT_EQ(push_all(decoder, wire), CobsEvent::complete);
    ASSERT_TRUE(std::ranges::equal(decoder.decoded(), bytes)) << "round " << round;
  }
}

TEST(Cobs, AnOutputThatIsTooShortIsLeftAlone) {
  Bytes out(cobs_encoded_max(10) - 1, 0xaa);
  EXPECT_EQ(cobs_encode(counting(10), out), 0u);
  EXPECT_EQ(out, Bytes(out.size(), 0xaa));
}

TEST(Cobs, ADelimiterInTheMiddleOfABlockEndsTheFrameAsMalformed) {
  CobsDecoder<16> decoder;
  EXPECT_EQ(push_all(decoder, {0x05, 0x01, 0x02, 0x00}), CobsEvent::malformed);
  EXPECT_EQ(push_all(decoder, {0x02, 0x07, 0x00}), CobsEvent::complete);
  EXPECT_EQ(decoder.decoded().size(), 1u);
}

TEST(Cobs, AFrameBeyondTheCapacityIsReportedOnceAndTheNextOneIsGood) {
  CobsDecoder<16> decoder;
  Bytes wire = encoded(counting(17));
  wire.push_back(0);
  EXPECT_EQ(push_all(decoder, wire), CobsEvent::overlong);
  wire = encoded(counting(16));
  wire.push_back(0);
  EXPECT_EQ(push_all(decoder, wire), CobsEvent::complete);
}

TEST(Cobs, LoneDelimitersAreIdle) {
  CobsDecoder<16> decoder;
  EXPECT_EQ(decoder.push(0), CobsEvent::idle);
  EXPECT_EQ(decoder.push(0), CobsEvent::idle);
}

}  // namespace
}  // namespace umov::protocol
