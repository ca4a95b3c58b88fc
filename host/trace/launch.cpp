#include "host/trace/launch.hpp"

#include <cstddef>

namespace umov::trace {
namespace {

// A curve through a square of 2×2 cells goes (0,0), (0,1), (1,1), (1,0); in each cell runs the same
// curve, turned. Two turns are enough, and they commute: x and y exchanged, and both mirrored.
struct Turn {
  bool exchanged, mirrored;
};

constexpr Turn operator+(Turn a, Turn b) {
  return {a.exchanged != b.exchanged, a.mirrored != b.mirrored};
}

// Four levels of the curve at once: 256 cells, by their number along it.
constexpr unsigned levels = 4;
constexpr unsigned strides = 3;  // 12 levels in all
constexpr double cells = 1U << (2 * levels * strides);

struct Step {
  std::uint8_t x, y, next;
};

constexpr std::size_t index(Turn turn) {
  return (turn.exchanged ? 2U : 0U) + (turn.mirrored ? 1U : 0U);
}

constexpr Step step_of(Turn turn, unsigned number) {
  Step step{0, 0, 0};
  for (unsigned level = levels; level-- > 0;) {
    const unsigned quarter = (number >> (2 * level)) & 3U;
    unsigned x = quarter >> 1U;
    unsigned y = (quarter ^ x) & 1U;
    if (turn.mirrored) x ^= 1U, y ^= 1U;
    step.x = static_cast<std::uint8_t>(2U * step.x + (turn.exchanged ? y : x));
    step.y = static_cast<std::uint8_t>(2U * step.y + (turn.exchanged ? x : y));
    turn = turn + Turn{quarter == 0 || quarter == 3, quarter == 3};
  }
  step.next = static_cast<std::uint8_t>(index(turn));
  return step;
}

using Steps = std::array<std::array<Step, 1U << (2 * levels)>, 4>;

constexpr Steps all_steps() {
  Steps steps{};
  for (const Turn turn : {Turn{false, false}, {false, true}, {true, false}, {true, true}}) {
    for (unsigned number = 0; number < steps[0].size(); ++number) {
      steps[index(turn)][number] = step_of(turn, number);
    }
  }
  return steps;
}

constexpr Steps steps = all_steps();

}  // namespace

std::array<double, 2> on_hilbert_curve(double along, double u, double v) {
  const auto number = static_cast<std::uint32_t>(along * cells);
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::size_t turn = 0;
  for (unsigned stride = strides; stride-- > 0;) {
    const Step step = steps[turn][(number >> (2 * levels * stride)) & 255U];
    x = (x << levels) + step.x;
    y = (y << levels) + step.y;
    turn = step.next;
  }
  constexpr double width = 1.0 / (1U << (levels * strides));
  return {(x + u) * width, (y + v) * width};
}

}  // namespace umov::trace
