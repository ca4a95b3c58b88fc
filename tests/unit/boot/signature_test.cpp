// The signature check of the boot loader against RFC 8032 and against libsodium.
#include <gtest/gtest.h>
#include <sodium.h>

#include <random>
#include <string>
#include <vector>

#include "firmware/boot/ed25519.hpp"
#include "firmware/boot/sha512.hpp"

namespace umov {
namespace {

namespace boot = firmware::boot;
using Bytes = std::vector<std::uint8_t>;

Bytes from_hex(const std::string& text) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(text.substr(i, 2), nullptr, 16)));
  return bytes;
}
template <std::size_t n>
std::array<std::uint8_t, n> array_of(const Bytes& bytes) {
  std::array<std::uint8_t, n> array{};
  std::copy_n(bytes.begin(), n, array.begin());
  return array;
}

bool good(const boot::PublicKey& key, const boot::Signature& signature, const Bytes& message,
          std::size_t piece = 1000) {
  boot::SignatureCheck check(key, signature);
  for (std::size_t at = 0; at < message.size(); at += piece)
    check.update(std::span(message).subspan(at, std::min(piece, message.size() - at)));
  return check.good();
}

struct Vector {
  const char* key;
  const char* message;
  const char* signature;
};

TEST(Ed25519, TakesTheSignaturesOfRfc8032AndNoneOfTheirNeighbours) {
  const std::array<Vector, 4> vectors = {
      {{"d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a", "",
        "e5564300c360ac729086e2cc806e828a84877f1eb8e5d974d873e065224901555fb8821590a33bacc61e39701c"
        "f"
        "9b46bd25bf5f0595bbe24655141438e7a100b"},
       {"3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c", "72",
        "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da085ac1e43e15996e458f3613d0"
        "f"
        "11d8c387b2eaeb4302aeeb00d291612bb0c00"},
       {"fc51cd8e6218a1a38da47ed00230f0580816ed13ba3303ac5deb911548908025", "af82",
        "6291d657deec24024827e69c3abe01a30ce548a284743a445e3680d7db5ac3ac18ff9b538d16f290ae67f76098"
        "4"
        "dc6594a7c15e9716ed28dc027beceea1ec40a"},
       {"ec172b93ad5e563bf4932c70e1245034c35467ef2efd4d64ebf819683467e2bf",
        "ddaf35a193617abacc417349ae20413112e6fa4e89a97ea20a9eeee64b55d39a2192992a274fc1a836ba3c23a3"
        "f"
        "eebbd454d4423643ce80e2a9ac94fa54ca49f",
        "dc2a4459e7369633a52b1bf277839a00201009a3efbf3ecb69bea2186c26b58909351fc9ac90b3ecfdfbc7c664"
        "3"
        "1e0303dca179c138ac17ad9bef1177331a704"}}};
  ASSERT_GE(sodium_init(), 0);
  for (const Vector& v : vectors) {
    Bytes key_bytes = from_hex(v.key);
    const auto key = array_of<32>(key_bytes);
    const auto signature = array_of<64>(from_hex(v.signature));
    const Bytes message = from_hex(v.message);
    ASSERT_EQ(
        crypto_sign_verify_detached(signature.data(), message.data(), message.size(), key.data()),
        0)
        << "the vector itself";
    EXPECT_TRUE(good(key, signature, message));
    for (std::size_t bit = 0; bit < 512; bit += 7) {
      auto other = signature;
      other[bit / 8] = static_cast<std::uint8_t>(other[bit / 8] ^ 1u << bit % 8);
      EXPECT_FALSE(good(key, other, message)) << bit;
    }
    Bytes longer = message;
    longer.push_back(0);
    EXPECT_FALSE(good(key, signature, longer));
  }
}

TEST(Ed25519, AgreesWithLibsodiumOnKeysAndMessagesOfAllKinds) {
  ASSERT_GE(sodium_init(), 0);
  std::mt19937_64 random(5);
  int refused = 0;
  for (int i = 0; i < 150; ++i) {
    std::array<std::uint8_t, 32> seed;
    for (auto& byte : seed) byte = static_cast<std::uint8_t>(random());
    boot::PublicKey key;
    std::array<std::uint8_t, 64> secret;
    crypto_sign_seed_keypair(key.data(), secret.data(), seed.data());
    Bytes message(random() % 700);
    for (auto& byte : message) byte = static_cast<std::uint8_t>(random());
    boot::Signature signature;
    crypto_sign_detached(signature.data(), nullptr, message.data(), message.size(), secret.data());
    ASSERT_TRUE(good(key, signature, message, 1 + random() % 200)) << i;
    // Damage anywhere; now and then to the key, which then is no point half of the time.
    const std::size_t where = random() % (message.size() + 96);
    const auto flip = static_cast<std::uint8_t>(1u << random() % 8);
    if (where < 64) {
      signature[where] ^= flip;
    } else if (where < 96) {
      key[where - 64] ^= flip;
    } else {
      message[where - 96] ^= flip;
    }
    const bool expected = crypto_sign_verify_detached(signature.data(), message.data(),
                                                      message.size(), key.data()) == 0;
    EXPECT_EQ(good(key, signature, message), expected) << i;
    refused += expected ? 0 : 1;
  }
  EXPECT_EQ(refused, 150);
}

TEST(Ed25519, RefusesANumberSThatIsTooLargeByTheOrder) {
  ASSERT_GE(sodium_init(), 0);
  const auto key =
      array_of<32>(from_hex("d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a"));
  auto signature = array_of<64>(from_hex(
      "e5564300c360ac729086e2cc806e828a84877f1eb8e5d974d873e065224901555fb8821590a33bacc61e"
      "39701cf9b46bd25bf5f0595bbe24655141438e7a100b"));
  // S + L means the same point: another signature of the same message, which nobody made.
  const Bytes order = from_hex("edd3f55c1a631258d69cf7a2def9de1400000000000000000000000000000010");
  unsigned carry = 0;
  for (std::size_t i = 0; i < 32; ++i) {
    carry += signature[32 + i] + order[i];
    signature[32 + i] = static_cast<std::uint8_t>(carry);
    carry >>= 8;
  }
  EXPECT_FALSE(good(key, signature, {}));
}

TEST(Sha512, AgreesWithLibsodiumForEveryLengthAndCut) {
  Bytes message(600);
  for (std::size_t i = 0; i < message.size(); ++i) message[i] = static_cast<std::uint8_t>(i * 7);
  for (std::size_t size = 0; size <= 300; ++size) {
    boot::Sha512::Digest expected;
    crypto_hash_sha512(expected.data(), message.data(), size);
    boot::Sha512 hash;
    const auto all = std::span<const std::uint8_t>(message).first(size);
    const std::size_t cut = size * 2 / 3;
    hash.update(all.first(cut));
    hash.update(all.subspan(cut));
    ASSERT_EQ(hash.finish(), expected) << size;
  }
}

}  // namespace
}  // namespace umov
