// A flash in memory whose power can be cut and which can be worn out, images for it, and keys.
#pragma once

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "firmware/boot/image_check.hpp"
#include "firmware/boot/port.hpp"

namespace umov::test {

namespace boot = firmware::boot;
using Bytes = std::vector<std::uint8_t>;
using protocol::ImageHeader;

inline const std::string board_name = "umov test board";

/// A key pair from a number.
struct Keys {
  explicit Keys(std::uint8_t number) {
    if (sodium_init() < 0) throw std::runtime_error("libsodium");
    std::array<std::uint8_t, 32> seed{number};
    crypto_sign_seed_keypair(key.data(), secret.data(), seed.data());
  }
  boot::PublicKey key{};
  std::array<std::uint8_t, 64> secret{};
};

inline void sign(Bytes& image, const Keys& keys) {
  Bytes message(image.begin(), image.begin() + ImageHeader::signed_bytes);
  message.insert(message.end(), image.begin() + ImageHeader::bytes, image.end());
  crypto_sign_detached(image.data() + ImageHeader::signature_offset, nullptr, message.data(),
                       message.size(), keys.secret.data());
}

/// An image of `program_bytes` of noise.
inline Bytes make_image(std::uint32_t version, std::uint32_t program_bytes, const Keys& keys,
                        const std::string& board = board_name) {
  Bytes image(ImageHeader::bytes + program_bytes);
  std::mt19937 random(version);
  std::generate(image.begin() + ImageHeader::bytes, image.end(),
                [&] { return static_cast<std::uint8_t>(random()); });
  ImageHeader header;
  header.program_bytes = program_bytes;
  std::copy(board.begin(), board.end(), header.board.begin());
  header.version = version;
  header.source_hash = 77;
  header.program_crc =
      protocol::crc32c(std::span<const std::uint8_t>(image).subspan(ImageHeader::bytes));
  protocol::write_image_header(header, image);
  sign(image, keys);
  return image;
}

struct PowerCut {};

/// Programming clears bits, erasing sets them. The power is cut when `bytes_left` have been
/// written, and leaves the next byte with some of its bits programmed; an erasure counts as
/// `erase_cost` bytes and may be cut half-way, when one half of the place has been erased. Places
/// can be worn out.
class RamFlash final : public boot::Flash {
 public:
  explicit RamFlash(std::size_t size) {
    for (auto& place : places) place.assign(size, 0xFF);
  }

  std::span<const std::uint8_t> contents(boot::Place place) const override {
    return places[static_cast<std::size_t>(place)];
  }
  bool erase(boot::Place place) override {
    Bytes& bytes = at(place);
    ++erasures;
    const Wear& worn = wear[static_cast<std::size_t>(place)];
    if (worn.refuses_erasure) return false;
    if (bytes_left && *bytes_left < erase_cost) {
      const auto half = static_cast<std::ptrdiff_t>(bytes.size() / 2);
      std::fill_n(bytes.begin() + (cut_erases_front ? 0 : half), half, std::uint8_t{0xFF});
      throw PowerCut{};
    }
    if (bytes_left) *bytes_left -= erase_cost;
    written += erase_cost;
    std::fill(bytes.begin(), bytes.end(), std::uint8_t{0xFF});
    if (worn.stuck_byte) bytes.at(*worn.stuck_byte) = 0;
    return true;
  }
  bool program(boot::Place place, std::uint32_t offset,
               std::span<const std::uint8_t> bytes) override {
    if (offset % 4 != 0 || bytes.size() % 4 != 0) throw std::logic_error("unaligned");
    for (const std::uint8_t byte : bytes) {
      std::uint8_t& cell = at(place).at(offset++);
      if (bytes_left && (*bytes_left)-- == 0) {
        cell = static_cast<std::uint8_t>(cell & (byte | 0xA5u));  // some bits were quicker
        throw PowerCut{};
      }
      ++written;
      cell = static_cast<std::uint8_t>(cell & byte);
      if (fails_at && written >= *fails_at) return false;
      if (cell != byte) return false;
    }
    return true;
  }

  Bytes& at(boot::Place place) { return places[static_cast<std::size_t>(place)]; }
  void put(boot::Place place, const Bytes& image) {
    Bytes& all = at(place);
    std::fill(all.begin(), all.end(), std::uint8_t{0xFF});
    std::copy(image.begin(), image.end(), all.begin());
  }
  bool holds(boot::Place place, const Bytes& image) const {
    const auto all = contents(place);
    return std::equal(image.begin(), image.end(), all.begin());
  }

  /// What flash does that has been erased too often.
  struct Wear {
    bool refuses_erasure = false;             ///< reports an error
    std::optional<std::size_t> stuck_byte{};  ///< reads 0 also when it has been erased
  };
  Wear& wear_of(boot::Place place) { return wear[static_cast<std::size_t>(place)]; }

  static constexpr std::size_t erase_cost = 256;
  std::array<Bytes, 3> places;
  std::optional<std::size_t> bytes_left;
  std::optional<std::size_t> fails_at;
  std::size_t written = 0;
  int erasures = 0;
  bool cut_erases_front = false;
  std::array<Wear, 3> wear{};
};

}  // namespace umov::test
