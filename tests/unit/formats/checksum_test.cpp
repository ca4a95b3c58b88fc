#include <gtest/gtest.h>

#include <string>

#include "host/formats/crc32c.hpp"
#include "host/formats/sha256.hpp"

namespace umov::formats {
namespace {

std::string sha256(std::string_view text) {
  Sha256 hash;
  hash.update(text);
  return hash.hex_digest();
}

TEST(Sha256, MatchesThePublishedExamples) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, DoesNotDependOnHowTheBytesArePortioned) {
  std::string text;
  for (int i = 0; i < 300; ++i) text += static_cast<char>(i);
  for (std::size_t portion = 1; portion < 140; ++portion) {
    Sha256 hash;
    for (std::size_t at = 0; at < text.size(); at += portion)
      hash.update(std::string_view(text).substr(at, portion));
    EXPECT_EQ(hash.hex_digest(), sha256(text)) << portion;
  }
}

TEST(Crc32c, MatchesTheCheckValue) {
  const std::string text = "123456789";
  EXPECT_EQ(crc32c(std::as_bytes(std::span(text))), 0xe3069283u);
}

TEST(Crc32c, SeesEverySingleBitError) {
  std::string text = "a lock-in record";
  const std::uint32_t whole = crc32c(std::as_bytes(std::span(text)));
  for (std::size_t bit = 0; bit < 8 * text.size(); ++bit) {
    text[bit / 8] = static_cast<char>(text[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_NE(crc32c(std::as_bytes(std::span(text))), whole);
    text[bit / 8] = static_cast<char>(text[bit / 8] ^ (1 << (bit % 8)));
  }
}

}  // namespace
}  // namespace umov::formats
