// Bytes of the journal: little-endian numbers and frames with length and CRC-32C.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace umov::formats {

using Bytes = std::vector<std::byte>;

inline constexpr std::size_t frame_overhead = 8;           ///< length and CRC, 4 bytes each
inline constexpr std::uint32_t longest_payload = 1 << 28;  ///< a header with a very long plan

void put_integer(Bytes& out, std::uint64_t value, int bytes);
void put_number(Bytes& out, double value);
void put_text(Bytes& out, const std::string& text);

/// Appends a frame around `payload`.
void put_frame(Bytes& out, std::span<const std::byte> payload);

/// The payload of a whole and undamaged frame at the start of `bytes`; nullopt otherwise.
std::optional<std::span<const std::byte>> frame_at(std::span<const std::byte> bytes);

/// Takes values off the front of a payload. After an attempt to read behind its end, `ok()` is
/// false and everything read is zero or empty.
class PayloadReader {
 public:
  explicit PayloadReader(std::span<const std::byte> payload) : rest_(payload) {}
  std::uint64_t integer(int bytes);
  double number();
  std::string text();
  bool ok() const { return ok_; }
  bool at_end() const { return ok_ && rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
  bool ok_ = true;
};

}  // namespace umov::formats
