// What the targets that read files have in common: random bytes alone would hardly get past a
// header, so that most inputs are lists of edits to a small valid file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>

namespace umov::fuzz {

/// Lets libFuzzer stop and keep the input.
inline void require(bool good) {
  if (!good) std::abort();
}

/// Four bytes an edit: where (two), what, and a byte to do it with. The file replaces that byte,
/// inserts it, loses it, repeats the rest of its line there, or ends there.
inline std::string edited(std::string_view original, const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t longest = 65536;
  std::string text(original);
  for (std::size_t n = 0; n + 3 < size && !text.empty() && text.size() < longest; n += 4) {
    const std::size_t at = (std::size_t{data[n]} << 8 | data[n + 1]) % text.size();
    const char byte = static_cast<char>(data[n + 3]);
    switch (data[n + 2] % 8) {
      case 0:
        text.erase(at, 1);
        break;
      case 1:
        text.insert(at, text.substr(at, text.find('\n', at) - at + 1));
        break;
      case 2:
        text.resize(at);
        break;
      case 3:
      case 4:
        text.insert(at, 1, byte);
        break;
      default:
        text[at] = byte;
    }
  }
  return text;
}

struct ForeignBytes {
  std::size_t format = 0;  ///< index of the original
  std::string bytes;
};

/// The first byte chooses the format, the second whether the rest is the file itself or a list of
/// edits to that format's original. Without two bytes an empty file of the first format.
inline ForeignBytes foreign_bytes(std::span<const std::string_view> originals,
                                  const std::uint8_t* data, std::size_t size) {
  if (size < 2) return {};
  const std::size_t format = data[0] % originals.size();
  return {format, data[1] % 4 == 0 ? std::string(reinterpret_cast<const char*>(data + 2), size - 2)
                                   : edited(originals[format], data + 2, size - 2)};
}

}  // namespace umov::fuzz
