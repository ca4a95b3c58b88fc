#include "host/chamber/map_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace umov::chamber {
namespace {

using formats::Picture;

constexpr Picture::Colour paper{255, 255, 255};
constexpr Picture::Colour ink{30, 34, 43};
constexpr std::size_t letter = 2;         // pixels a dot of a letter
constexpr std::size_t line = 9 * letter;  // height of a line of text
constexpr std::size_t left = 60, right = 150, top = 16, bottom = 60;

/// A step of 1, 2 or 5 times a power of ten that divides `range` in about five.
double round_step(double range) {
  const double raw = range / 5.0;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double m : {1.0, 2.0, 5.0}) {
    if (raw <= m * power * 1.0001) return m * power;
  }
  return 10.0 * power;
}

Picture::Colour grey(double share) {
  // The eye's scale: the exponent of sRGB.
  const double v = std::pow(std::clamp(share, 0.0, 1.0), 1.0 / 2.2);
  const auto g = static_cast<std::uint8_t>(std::lround(255.0 * v));
  return {g, g, g};
}

}  // namespace

std::string map_png(const Map& map, double largest_cd_m2, std::size_t least_width) {
  double largest = largest_cd_m2;
  if (!(largest > 0.0)) {
    largest = *std::max_element(map.luminance_cd_m2.begin(), map.luminance_cd_m2.end());
  }
  if (!(largest > 0.0)) largest = 1.0;
  const std::size_t size = std::max<std::size_t>(1, (least_width + map.width - 1) / map.width);
  const std::size_t wide = size * map.width;
  const std::size_t high = std::max<std::size_t>(size * map.height, 6 * line);
  Picture picture(left + wide + right, top + high + bottom, paper);
  for (std::size_t y = 0; y < map.height; ++y) {
    for (std::size_t x = 0; x < map.width; ++x) {
      picture.fill(left + size * x, top + size * (map.height - 1 - y), size, size,
                   grey(map.at(x, y) / largest));
    }
  }
  // Axes in mm of the map.
  const auto axis = [&](double length_mm, bool along_x) {
    const double step = round_step(length_mm);
    for (int i = 0; i * step <= length_mm * 1.0001; ++i) {
      const std::string label = fmt::format("{:g}", i * step);
      const auto at = static_cast<std::size_t>(
          std::lround(i * step / map.pixel_mm * static_cast<double>(size)));
      const std::size_t width = Picture::text_width(label, letter);
      if (along_x) {
        picture.fill(left + at, top + size * map.height, 1, 6, ink);
        picture.text(left + at - std::min(left, width / 2), top + size * map.height + 9, label,
                     letter, ink);
      } else {
        const std::size_t y = top + size * map.height - std::min(at, size * map.height);
        picture.fill(left - 6, y, 6, 1, ink);
        picture.text(left - 10 - width, y > 7 ? y - 7 : 0, label, letter, ink);
      }
    }
  };
  axis(map.pixel_mm * static_cast<double>(map.width), true);
  axis(map.pixel_mm * static_cast<double>(map.height), false);
  picture.text(left + wide / 2, top + size * map.height + 9 + line, "X / Y in mm", letter, ink);
  // The scale.
  const std::size_t bar = left + wide + 24;
  const std::size_t scale_high = high - 2 * line;
  for (std::size_t y = 0; y < scale_high; ++y) {
    const double share = 1.0 - static_cast<double>(y) / static_cast<double>(scale_high - 1);
    picture.fill(bar, top + 2 * line + y, 24, 1, grey(share));
  }
  picture.text(bar, top, "cd/m2", letter, ink);
  const double step = round_step(largest);
  for (int i = 0; i * step <= largest * 1.0001; ++i) {
    const double share = i * step / largest;
    const auto y =
        static_cast<std::size_t>(std::lround((1.0 - share) * static_cast<double>(scale_high - 1)));
    picture.fill(bar + 24, top + 2 * line + y, 6, 1, ink);
    picture.text(bar + 34, top + 2 * line + y - 7, fmt::format("{:g}", i * step), letter, ink);
  }
  return formats::png_bytes(picture);
}

}  // namespace umov::chamber
