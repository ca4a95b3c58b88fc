#include <png.h>

#include <cctype>
#include <map>

#include "host/errors/error.hpp"
#include "host/formats/image_file.hpp"

namespace umov::formats {
namespace {

/// Columns from the left, bit 0 at the top.
using Glyph = std::array<std::uint8_t, 5>;

const std::map<char, Glyph>& glyphs() {
  static const std::map<char, Glyph> all{
      {'0', {0x3E, 0x51, 0x49, 0x45, 0x3E}}, {'1', {0x00, 0x42, 0x7F, 0x40, 0x00}},
      {'2', {0x42, 0x61, 0x51, 0x49, 0x46}}, {'3', {0x21, 0x41, 0x45, 0x4B, 0x31}},
      {'4', {0x18, 0x14, 0x12, 0x7F, 0x10}}, {'5', {0x27, 0x45, 0x45, 0x45, 0x39}},
      {'6', {0x3C, 0x4A, 0x49, 0x49, 0x30}}, {'7', {0x01, 0x71, 0x09, 0x05, 0x03}},
      {'8', {0x36, 0x49, 0x49, 0x49, 0x36}}, {'9', {0x06, 0x49, 0x49, 0x29, 0x1E}},
      {'A', {0x7E, 0x11, 0x11, 0x11, 0x7E}}, {'B', {0x7F, 0x49, 0x49, 0x49, 0x36}},
      {'C', {0x3E, 0x41, 0x41, 0x41, 0x22}}, {'D', {0x7F, 0x41, 0x41, 0x22, 0x1C}},
      {'E', {0x7F, 0x49, 0x49, 0x49, 0x41}}, {'F', {0x7F, 0x09, 0x09, 0x09, 0x01}},
      {'G', {0x3E, 0x41, 0x49, 0x49, 0x7A}}, {'H', {0x7F, 0x08, 0x08, 0x08, 0x7F}},
      {'I', {0x00, 0x41, 0x7F, 0x41, 0x00}}, {'J', {0x20, 0x40, 0x41, 0x3F, 0x01}},
      {'K', {0x7F, 0x08, 0x14, 0x22, 0x41}}, {'L', {0x7F, 0x40, 0x40, 0x40, 0x40}},
      {'M', {0x7F, 0x02, 0x0C, 0x02, 0x7F}}, {'N', {0x7F, 0x04, 0x08, 0x10, 0x7F}},
      {'O', {0x3E, 0x41, 0x41, 0x41, 0x3E}}, {'P', {0x7F, 0x09, 0x09, 0x09, 0x06}},
      {'Q', {0x3E, 0x41, 0x51, 0x21, 0x5E}}, {'R', {0x7F, 0x09, 0x19, 0x29, 0x46}},
      {'S', {0x46, 0x49, 0x49, 0x49, 0x31}}, {'T', {0x01, 0x01, 0x7F, 0x01, 0x01}},
      {'U', {0x3F, 0x40, 0x40, 0x40, 0x3F}}, {'V', {0x1F, 0x20, 0x40, 0x20, 0x1F}},
      {'W', {0x3F, 0x40, 0x38, 0x40, 0x3F}}, {'X', {0x63, 0x14, 0x08, 0x14, 0x63}},
      {'Y', {0x07, 0x08, 0x70, 0x08, 0x07}}, {'Z', {0x61, 0x51, 0x49, 0x45, 0x43}},
      {'.', {0x00, 0x60, 0x60, 0x00, 0x00}}, {'-', {0x08, 0x08, 0x08, 0x08, 0x08}},
      {'+', {0x08, 0x08, 0x3E, 0x08, 0x08}}, {'/', {0x20, 0x10, 0x08, 0x04, 0x02}},
      {'%', {0x23, 0x13, 0x08, 0x64, 0x62}}, {'(', {0x00, 0x1C, 0x22, 0x41, 0x00}},
      {')', {0x00, 0x41, 0x22, 0x1C, 0x00}}};
  return all;
}

}  // namespace

Picture::Picture(std::size_t wide, std::size_t high, const Colour& ground)
    : width(wide), height(high) {
  rgb.reserve(3 * wide * high);
  for (std::size_t i = 0; i < wide * high; ++i) rgb.insert(rgb.end(), ground.begin(), ground.end());
}

void Picture::set(std::size_t x, std::size_t y, const Colour& colour) {
  if (x >= width || y >= height) return;
  for (std::size_t k = 0; k < 3; ++k) rgb[3 * (y * width + x) + k] = colour[k];
}

void Picture::fill(std::size_t x, std::size_t y, std::size_t wide, std::size_t high,
                   const Colour& colour) {
  for (std::size_t j = 0; j < high; ++j) {
    for (std::size_t i = 0; i < wide; ++i) set(x + i, y + j, colour);
  }
}

void Picture::text(std::size_t x, std::size_t y, const std::string& line, std::size_t scale,
                   const Colour& colour) {
  for (const char small : line) {
    const char c = static_cast<char>(std::toupper(static_cast<unsigned char>(small)));
    const auto glyph = glyphs().find(c);
    if (glyph != glyphs().end()) {
      for (std::size_t column = 0; column < 5; ++column) {
        for (std::size_t row = 0; row < 7; ++row) {
          if ((glyph->second[column] >> row & 1U) == 0) continue;
          fill(x + column * scale, y + row * scale, scale, scale, colour);
        }
      }
    }
    x += 6 * scale;
  }
}

std::size_t Picture::text_width(const std::string& line, std::size_t scale) {
  return line.empty() ? 0 : (6 * line.size() - 1) * scale;
}

std::string png_bytes(const Picture& picture) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  const auto refuse = [&]() -> Error {
    return Error(std::string("libpng cannot make the picture: ") + image.message,
                 "make it smaller");
  };
  if (png_image_write_to_memory(&image, nullptr, &size, 0, picture.rgb.data(), 0, nullptr) == 0)
    throw refuse();
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.rgb.data(), 0, nullptr) ==
      0)
    throw refuse();
  bytes.resize(size);
  return bytes;
}

}  // namespace umov::formats
