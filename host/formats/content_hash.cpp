#include "host/formats/content_hash.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace umov::formats {
namespace {

/// Fills a small buffer so that the hash is not called for eight bytes at a time.
class Packer {
 public:
  explicit Packer(Sha256& hash) : hash_(hash) {}
  ~Packer() { flush(); }
  Packer(const Packer&) = delete;
  Packer& operator=(const Packer&) = delete;
  void add(std::uint64_t value) {
    if (used_ + 8 > buffer_.size()) flush();
    for (int byte = 0; byte < 8; ++byte)
      buffer_[used_++] = static_cast<std::byte>(value >> (8 * byte) & 0xff);
  }

 private:
  void flush() {
    hash_.update(std::span<const std::byte>(buffer_).first(used_));
    used_ = 0;
  }
  Sha256& hash_;
  std::array<std::byte, 4096> buffer_;
  std::size_t used_ = 0;
};

std::uint64_t bits_of(double value) {
  // Any NaN means `open`.
  if (std::isnan(value)) value = std::numeric_limits<double>::quiet_NaN();
  return std::bit_cast<std::uint64_t>(value);
}

}  // namespace

void ContentHash::integer(std::int64_t value) {
  Packer(hash_).add(static_cast<std::uint64_t>(value));
}

void ContentHash::text(std::string_view text) {
  integer(static_cast<std::int64_t>(text.size()));
  hash_.update(text);
}

void ContentHash::column(std::string_view name, std::span<const double> values) {
  text(name);
  integer(static_cast<std::int64_t>(values.size()));
  Packer packer(hash_);
  for (const double value : values) packer.add(bits_of(value));
}

void ContentHash::column(std::string_view name, std::span<const int> values) {
  text(name);
  integer(static_cast<std::int64_t>(values.size()));
  Packer packer(hash_);
  for (const int value : values)
    packer.add(static_cast<std::uint64_t>(static_cast<std::int64_t>(value)));
}

void ContentHash::column(std::string_view name, std::span<const std::int64_t> values) {
  text(name);
  integer(static_cast<std::int64_t>(values.size()));
  Packer packer(hash_);
  for (const std::int64_t value : values) packer.add(static_cast<std::uint64_t>(value));
}

void ContentHash::pairs(std::string_view name,
                        const std::vector<std::pair<std::string, std::string>>& pairs) {
  text(name);
  integer(static_cast<std::int64_t>(pairs.size()));
  for (const auto& [key, value] : pairs) {
    text(key);
    text(value);
  }
}

std::string provenance_sha256(const Provenance& p) {
  ContentHash hash;
  for (const std::string* member : {&p.program, &p.command, &p.created, &p.device, &p.firmware_hash,
                                    &p.role, &p.settings, &p.plan})
    hash.text(*member);
  return hash.hex_digest();
}

}  // namespace umov::formats
