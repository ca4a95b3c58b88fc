// Feeding tables to a checksum in a fixed form: names, lengths, little-endian values.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/formats/provenance.hpp"
#include "host/formats/sha256.hpp"

namespace umov::formats {

class ContentHash {
 public:
  void text(std::string_view text);
  void integer(std::int64_t value);
  void column(std::string_view name, std::span<const double> values);
  void column(std::string_view name, std::span<const int> values);
  void column(std::string_view name, std::span<const std::int64_t> values);
  void pairs(std::string_view name, const std::vector<std::pair<std::string, std::string>>& pairs);
  std::string hex_digest() { return hash_.hex_digest(); }

 private:
  Sha256 hash_;
};

std::string provenance_sha256(const Provenance& provenance);

}  // namespace umov::formats
