// Images: OpenEXR for numbers, PNG for eyes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace umov::formats {

/// A named plane of numbers, row by row from the top.
struct ImagePlane {
  std::string name;
  std::span<const double> values;
};

/// 32-bit float channels, ZIP; `attributes` are strings of the header. Replaces `path` as a whole.
/// Throws umov::Error.
void write_exr(const std::filesystem::path& path, std::size_t width, std::size_t height,
               std::span<const ImagePlane> planes,
               const std::vector<std::pair<std::string, std::string>>& attributes);
/// What an OpenEXR file says of itself.
struct ExrHeader {
  std::size_t width = 0, height = 0;
  std::vector<std::string> channels;
  std::vector<std::pair<std::string, std::string>> attributes;  ///< those that are strings
};
/// Throws umov::Error.
ExrHeader read_exr_header(const std::filesystem::path& path);
bool looks_like_exr(std::string_view bytes);
/// One channel of an OpenEXR file, row by row from the top. Throws umov::Error.
std::vector<double> read_exr(const std::filesystem::path& path, const std::string& channel,
                             std::size_t& width, std::size_t& height);

/// 8-bit RGB, row by row from the top.
struct Picture {
  using Colour = std::array<std::uint8_t, 3>;
  std::size_t width, height;
  std::vector<std::uint8_t> rgb;

  Picture(std::size_t wide, std::size_t high, const Colour& ground);
  /// Outside of the picture: nothing.
  void set(std::size_t x, std::size_t y, const Colour& colour);
  void fill(std::size_t x, std::size_t y, std::size_t wide, std::size_t high, const Colour& colour);
  /// Digits, Latin capitals, `. - + / % ( )` and blanks in a 5 × 7 face, `scale` pixels a dot;
  /// small letters are drawn as capitals, what is not known as a blank. The top left is (x, y).
  void text(std::size_t x, std::size_t y, const std::string& line, std::size_t scale,
            const Colour& colour);
  static std::size_t text_width(const std::string& line, std::size_t scale);
};

/// The bytes of a PNG file. Throws umov::Error.
std::string png_bytes(const Picture& picture);

}  // namespace umov::formats
