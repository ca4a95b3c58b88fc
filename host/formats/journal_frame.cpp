#include "host/formats/journal_frame.hpp"

#include "host/formats/crc32c.hpp"

namespace umov::formats {

void put_integer(Bytes& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<std::byte>(value >> (8 * i) & 0xff));
}

void put_number(Bytes& out, double value) {
  put_integer(out, std::bit_cast<std::uint64_t>(value), 8);
}

void put_text(Bytes& out, const std::string& text) {
  put_integer(out, text.size(), 4);
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
}

void put_frame(Bytes& out, std::span<const std::byte> payload) {
  put_integer(out, payload.size(), 4);
  put_integer(out, crc32c(payload), 4);
  out.insert(out.end(), payload.begin(), payload.end());
}

std::optional<std::span<const std::byte>> frame_at(std::span<const std::byte> bytes) {
  if (bytes.size() < frame_overhead) return std::nullopt;
  PayloadReader start(bytes.first(frame_overhead));
  const std::uint64_t length = start.integer(4);
  const std::uint64_t check = start.integer(4);
  // Empty payloads do not occur; a stretch of zeros would otherwise be a run of good frames.
  if (length == 0 || length > longest_payload || length > bytes.size() - frame_overhead)
    return std::nullopt;
  const std::span<const std::byte> payload =
      bytes.subspan(frame_overhead, static_cast<std::size_t>(length));
  if (crc32c(payload) != check) return std::nullopt;
  return payload;
}

std::uint64_t PayloadReader::integer(int bytes) {
  if (rest_.size() < static_cast<std::size_t>(bytes)) ok_ = false;
  if (!ok_) return 0;
  std::uint64_t value = 0;
  for (int i = 0; i < bytes; ++i)
    value |= std::to_integer<std::uint64_t>(rest_[static_cast<std::size_t>(i)]) << (8 * i);
  rest_ = rest_.subspan(static_cast<std::size_t>(bytes));
  return value;
}

double PayloadReader::number() {
  return std::bit_cast<double>(integer(8));
}

std::string PayloadReader::text() {
  const std::uint64_t size = integer(4);
  if (size > rest_.size()) ok_ = false;
  if (!ok_) return {};
  const std::span<const std::byte> bytes = rest_.first(static_cast<std::size_t>(size));
  rest_ = rest_.subspan(bytes.size());
  std::string text;
  text.reserve(bytes.size());
  for (const std::byte byte : bytes) text += static_cast<char>(byte);
  return text;
}

}  // namespace umov::formats
