// The scale beside a picture.
#include "host/formats/picture_scale.hpp"

#include <gtest/gtest.h>

namespace umov::formats {
namespace {

TEST(PictureScale, HasStepsThatPeopleCountIn) {
  EXPECT_DOUBLE_EQ(round_step(10.0), 2.0);
  EXPECT_DOUBLE_EQ(round_step(25.0), 5.0);
  EXPECT_DOUBLE_EQ(round_step(26.0), 10.0);
  EXPECT_DOUBLE_EQ(round_step(0.005), 0.001);
}

TEST(PictureScale, RunsFromBottomToTopWithAMarkBesideItsColour) {
  constexpr Picture::Colour paper{255, 255, 255}, ink{0, 0, 0};
  Picture picture(120, 240, paper);
  draw_scale(
      picture, 10, 4, 200, "1", {{0.0, "0"}, {1.0, "1"}},
      [](double share) {
        return Picture::Colour{static_cast<std::uint8_t>(100.0 * share + 0.5), 50, 0};
      },
      ink);
  const auto at = [&](std::size_t x, std::size_t y) {
    const std::size_t i = 3 * (y * picture.width + x);
    return Picture::Colour{picture.rgb[i], picture.rgb[i + 1], picture.rgb[i + 2]};
  };
  const std::size_t top = 4 + 2 * scale_line;
  const std::size_t bottom = 4 + 200 - 1;
  EXPECT_EQ(at(12, top), (Picture::Colour{100, 50, 0}));
  EXPECT_EQ(at(12, bottom), (Picture::Colour{0, 50, 0}));
  EXPECT_EQ(at(12, (top + bottom) / 2), (Picture::Colour{50, 50, 0}));
  EXPECT_EQ(at(10 + scale_bar + 2, top), ink);
  EXPECT_EQ(at(10 + scale_bar + 2, bottom), ink);
  EXPECT_EQ(at(10 + scale_bar + 2, (top + bottom) / 2), paper);
  EXPECT_EQ(at(12, bottom + 1), paper);
}

}  // namespace
}  // namespace umov::formats
