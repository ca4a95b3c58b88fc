// SHA-512 (FIPS 180-4), piece by piece.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace umov::firmware::boot {

/// 216 bytes of state; any number of update() calls, then finish() once.
class Sha512 {
 public:
  using Digest = std::array<std::uint8_t, 64>;

  void update(std::span<const std::uint8_t> bytes);
  Digest finish();

 private:
  static constexpr std::size_t block_bytes = 128;
  void take_block(const std::uint8_t* block);

  std::array<std::uint64_t, 8> state_ = {0x6A09E667F3BCC908, 0xBB67AE8584CAA73B, 0x3C6EF372FE94F82B,
                                         0xA54FF53A5F1D36F1, 0x510E527FADE682D1, 0x9B05688C2B3E6C1F,
                                         0x1F83D9ABFB41BD6B, 0x5BE0CD19137E2179};
  std::array<std::uint8_t, block_bytes> waiting_{};
  std::size_t waiting_bytes_ = 0;
  std::uint64_t total_bytes_ = 0;
};

}  // namespace umov::firmware::boot
