// The scale beside a picture: which colour is which value.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/formats/image_file.hpp"

namespace umov::formats {

/// A step of 1, 2 or 5 times a power of ten that divides `range` (> 0) in about five.
double round_step(double range);

/// Where a value stands on a scale, 0 (bottom) to 1 (top), and what is written there.
struct ScaleMark {
  double share;
  std::string label;
};

/// Sizes of scales and of what stands beside them, pixels.
inline constexpr std::size_t scale_letter = 2;               ///< a dot of a letter
inline constexpr std::size_t scale_line = 9 * scale_letter;  ///< a line of text
inline constexpr std::size_t scale_bar = 24;                 ///< width of the bar

/// A bar from (x, y) down over `high` pixels with `title` above it and marks to its right.
void draw_scale(Picture& picture, std::size_t x, std::size_t y, std::size_t high,
                const std::string& title, const std::vector<ScaleMark>& marks,
                const std::function<Picture::Colour(double)>& colour_of_share,
                const Picture::Colour& ink);

}  // namespace umov::formats
