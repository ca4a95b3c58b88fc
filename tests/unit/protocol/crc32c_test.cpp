#include "protocol/crc32c.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace umov::protocol {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Straight from the definition, one bit at a time.
std::uint32_t bitwise(const Bytes& bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const std::uint8_t byte : bytes) {
    for (int bit = 0; bit < 8; ++bit) {
      const std::uint32_t feedback = (crc ^ (static_cast<std::uint32_t>(byte) >> bit)) & 1u;
      crc >>= 1;
      if (feedback != 0) crc ^= 0x82f63b78u;
    }
  }
  return ~crc;
}

TEST(Crc32c, TheCheckValueIsThatOfCastagnoli) {
  EXPECT_EQ(crc32c(Bytes{'1', '2', '3', '4', '5', '6', '7', '8', '9'}), 0xE3069283u);
}

TEST(Crc32c, TheValuesForStorageProtocolsHold) {  // RFC 3720, B.4
  EXPECT_EQ(crc32c(Bytes(32, 0x00)), 0x8a9136aau);
  EXPECT_EQ(crc32c(Bytes(32, 0xff)), 0x62a8ab43u);
  Bytes rising(32);
  for (std::size_t i = 0; i < 32; ++i) rising[i] = static_cast<std::uint8_t>(i);
  EXPECT_EQ(crc32c(rising), 0x46dd794eu);
}

TEST(Crc32c, TheTableAgreesWithTheDefinitionAndPiecesWithTheWhole) {
  std::mt19937_64 random(2);
  for (int round = 0; round < 300; ++round) {
    Bytes bytes(random() % 300);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    const std::uint32_t whole = crc32c(bytes);
    ASSERT_EQ(whole, bitwise(bytes));
    const std::span<const std::uint8_t> all(bytes);
    const std::size_t cut = bytes.empty() ? 0 : random() % bytes.size();
    ASSERT_EQ(crc32c(all.subspan(cut), crc32c(all.first(cut))), whole);
  }
}

TEST(Crc32c, EveryFlipOfOneTwoOrThreeBitsOfAFrameShows) {
  // 139 bytes hold every frame; the polynomial has Hamming distance 6 there, checked up to three.
  std::mt19937_64 random(3);
  Bytes bytes(139);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
  const std::uint32_t good = crc32c(bytes);
  const auto flip = [&](std::size_t bit) {
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1u << (bit % 8)));
  };
  const std::size_t bits = bytes.size() * 8;
  for (std::size_t bit = 0; bit < bits; ++bit) {
    flip(bit);
    ASSERT_NE(crc32c(bytes), good);
    flip(bit);
  }
  for (int round = 0; round < 20000; ++round) {
    const std::size_t a = random() % bits;
    const std::size_t b = (a + 1 + random() % (bits - 1)) % bits;
    flip(a);
    flip(b);
    ASSERT_NE(crc32c(bytes), good);
    std::size_t c = random() % bits;
    while (c == a || c == b) c = random() % bits;
    flip(c);
    ASSERT_NE(crc32c(bytes), good);
    flip(a);
    flip(b);
    flip(c);
  }
}

}  // namespace
}  // namespace umov::protocol
