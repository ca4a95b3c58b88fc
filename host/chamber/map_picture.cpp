#include "host/chamber/map_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/formats/picture_scale.hpp"

namespace umov::chamber {
namespace {

using formats::Picture;

constexpr Picture::Colour paper{255, 255, 255};
constexpr Picture::Colour ink{30, 34, 43};
constexpr std::size_t letter = formats::scale_letter;
constexpr std::size_t line = formats::scale_line;
constexpr std::size_t left = 60, right = 150, top = 16, bottom = 60;

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
    const double step = formats::round_step(length_mm);
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
  std::vector<formats::ScaleMark> marks;
  const double step = formats::round_step(largest);
  for (int i = 0; i * step <= largest * 1.0001; ++i) {
    marks.push_back({i * step / largest, fmt::format("{:g}", i * step)});
  }
  formats::draw_scale(picture, left + wide + 24, top, high, "cd/m2", marks, grey, ink);
  return formats::png_bytes(picture);
}

}  // namespace umov::chamber
