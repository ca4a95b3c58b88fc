// board.toml is the one source: what is made of it is up to date, and nonsense is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "boards/stm32f407/board_description.hpp"
#include "firmware/core/config/axis_settings.hpp"
#include "firmware/core/motion/stopping_distance.hpp"

namespace umov {
namespace {

namespace board = boards::stm32f407;
const std::string folder = UMOV_SOURCE_DIR "/boards/stm32f407/";

/// Output of describe.py and its exit status.
std::pair<std::string, int> describe(const std::string& arguments) {
  const std::string command =
      std::string(UMOV_PYTHON) + " " + folder + "tools/describe.py " + arguments + " 2>&1";
  std::FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  for (int c = 0; (c = std::fgetc(pipe)) != EOF;) text.push_back(static_cast<char>(c));
  const int status = pclose(pipe);
  return {text, status};
}

/// board.toml with one piece of text replaced, refused: why.
std::string refusal(const std::string& from, const std::string& to) {
  std::ifstream file(folder + "board.toml");
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto at = text.find(from);
  if (at == std::string::npos) return "no such text: " + from;
  text.replace(at, from.size(), to);
  const auto changed =
      std::filesystem::temp_directory_path() / ("umov-board-" + std::to_string(getpid()) + ".toml");
  std::ofstream(changed) << text;
  const auto [message, status] = describe(changed.string());
  std::filesystem::remove(changed);
  return status == 0 ? "accepted" : message;
}

TEST(BoardToml, TheWiringPageIsUpToDate) {
  const auto [text, status] =
      describe(folder + "board.toml --wiring " + folder + "WIRING.md --check");
  EXPECT_EQ(status, 0) << text;
}

TEST(BoardToml, TheBoardHasTheAxesOfTheReferenceInstrument) {
  for (std::size_t i = 0; i < board::axes.size(); ++i) {
    const auto& a = board::axes[i];
    const auto& b = firmware::default_axes[i];
    EXPECT_EQ(a.steps_per_turn, b.steps_per_turn) << i;
    EXPECT_EQ(a.min_udeg, b.min_udeg) << i;
    EXPECT_EQ(a.max_udeg, b.max_udeg) << i;
    EXPECT_EQ(a.speed_mdeg_s, b.speed_mdeg_s) << i;
    EXPECT_EQ(a.acceleration_mdeg_s2, b.acceleration_mdeg_s2) << i;
    EXPECT_EQ(a.jerk_mdeg_s3, b.jerk_mdeg_s3) << i;
    EXPECT_EQ(a.take_up_udeg, b.take_up_udeg) << i;
    EXPECT_EQ(a.open_udeg, b.open_udeg) << i;
    EXPECT_EQ(a.homing_mdeg_s, b.homing_mdeg_s) << i;
    EXPECT_EQ(a.approach_mdeg_s, b.approach_mdeg_s) << i;
  }
}

TEST(BoardToml, APinTakenTwiceIsRefused) {
  EXPECT_THAT(refusal("shutter = \"PC11\"", "shutter = \"PE8\""),
              testing::HasSubstr("PE8 is already optics.shutter"));
}

TEST(BoardToml, PinsThatCannotDoWhatTheyAreNamedForAreRefused) {
  EXPECT_THAT(refusal("shutter = \"PC11\"", "shutter = \"PF1\""),
              testing::HasSubstr("no pin of the package"));
  EXPECT_THAT(refusal("step = \"PA5\"", "step = \"PC14\""),
              testing::HasSubstr("no output of TIM2 or TIM5"));
  EXPECT_THAT(refusal("reference = \"PA8\"", "reference = \"PC14\""),
              testing::HasSubstr("no input of TIM1"));
  EXPECT_THAT(refusal("signal = \"PC1\"", "signal = \"PC14\""),
              testing::HasSubstr("no input of ADC1 and ADC2"));
  EXPECT_THAT(refusal("stall = \"PC5\"", "stall = \"PB5\""), testing::HasSubstr("already"));
  EXPECT_THAT(refusal("stall = \"PC5\"", "stall = \"PC15\""), testing::HasSubstr("EXTI line"));
}

TEST(BoardToml, AnAxisHasRoomToStopBeyondItsLimitSwitch) {
  EXPECT_THAT(refusal("overrun_deg = 5", "overrun_deg = 4"),
              testing::HasSubstr("needs 4.91 to stop from 40"));
  EXPECT_THAT(refusal("acceleration_deg_s2 = 400", "acceleration_deg_s2 = 150"),
              testing::HasSubstr("incidence.overrun_deg"));
  // The page's figures are those of the firmware.
  std::ifstream file(folder + "WIRING.md");
  const std::string page((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  for (const auto& axis : board::axes) {
    const double needed = 1e-6 * static_cast<double>(firmware::stopping_distance_udeg(axis));
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "| %.2f° |", needed);
    EXPECT_THAT(page, testing::HasSubstr(text.data()));
  }
}

TEST(BoardToml, ARatioMustGiveWholeSteps) {
  EXPECT_THAT(refusal("gear = 112.5", "gear = 112.51234"), testing::HasSubstr("not whole"));
  EXPECT_THAT(refusal("approach_deg_s = 1", "approach_deg_s = 0.0001"),
              testing::HasSubstr("finer than the controller's unit"));
}

}  // namespace
}  // namespace umov
