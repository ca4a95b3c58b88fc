#include "host/formats/picture_scale.hpp"

#include <cmath>

namespace umov::formats {

double round_step(double range) {
  const double raw = range / 5.0;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double m : {1.0, 2.0, 5.0}) {
    if (raw <= m * power * 1.0001) return m * power;
  }
  return 10.0 * power;
}

void draw_scale(Picture& picture, std::size_t x, std::size_t y, std::size_t high,
                const std::string& title, const std::vector<ScaleMark>& marks,
                const std::function<Picture::Colour(double)>& colour_of_share,
                const Picture::Colour& ink) {
  const std::size_t top = y + 2 * scale_line;
  const std::size_t length = high - 2 * scale_line;
  for (std::size_t row = 0; row < length; ++row) {
    const double share = 1.0 - static_cast<double>(row) / static_cast<double>(length - 1);
    picture.fill(x, top + row, scale_bar, 1, colour_of_share(share));
  }
  picture.text(x, y, title, scale_letter, ink);
  for (const ScaleMark& mark : marks) {
    const auto row =
        static_cast<std::size_t>(std::lround((1.0 - mark.share) * static_cast<double>(length - 1)));
    picture.fill(x + scale_bar, top + row, 6, 1, ink);
    picture.text(x + scale_bar + 10, top + row - 7, mark.label, scale_letter, ink);
  }
}

}  // namespace umov::formats
