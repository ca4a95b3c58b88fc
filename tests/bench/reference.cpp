// How soon the controller locks on an external reference and how well it holds it, on the native
// core and on the flashed image, and what its edges cost. Markdown tables on stdout.
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "tests/unit/mcu_board/reference_runs.hpp"

namespace {

using namespace umov;
using test::OutsideReference;

constexpr int capture = 16 + 27;

/// Asking takes the flashed image a millisecond or two: not where that is many periods.
template <class Rig>
std::string lock_text(const OutsideReference& reference) {
  if (reference.frequency_hz > 1100) return "–";
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%.1f", test::periods_to_lock<Rig>(reference));
  return text.data();
}

template <class Rig>
void print_row(const OutsideReference& reference) {
  const test::Hold hold = test::hold<Rig>(reference, 300);
  std::printf("| %s | %.1f Hz | %.0e | %g° | %s | %.1e rad | %.1e rad |\n", Rig::name,
              reference.frequency_hz, reference.wander,
              reference.jitter_rad * 180 / std::numbers::pi, lock_text<Rig>(reference).c_str(),
              hold.rms_rad, hold.mean_rad);
}

template <class Rig>
void print_rows() {
  for (const double hz : {37.3, 437.0, 1013.7, 4973.0, 9973.0}) {
    print_row<Rig>({.frequency_hz = hz, .wander = 1e-5});
  }
  print_row<Rig>({.frequency_hz = 437, .wander = 1e-5, .jitter_rad = 0.2 * std::numbers::pi / 180});
}

/// Instructions an edge costs, and the share of 168 million a second at the fastest reference.
void print_cost() {
  test::McuRig rig;
  rig.stages().reference = OutsideReference{.frequency_hz = 19'990};
  rig.run_for(100'000);
  const auto& chip = rig.board.chip();
  const auto instructions = chip.instructions_in(capture), entries = chip.entries_of(capture);
  rig.run_for(500'000);
  const double edges = static_cast<double>(chip.entries_of(capture) - entries);
  const double each = static_cast<double>(chip.instructions_in(capture) - instructions) / edges;
  std::printf("\nAn edge costs %.0f instructions: %.1f %% of 168 MHz at 20 kHz.\n", each,
              100 * 20e3 * (each + 24) / 168e6);
}

}  // namespace

int main() {
  std::printf(
      "| on | reference | wander | jitter of edges | locked after, periods | held, rms | mean |\n"
      "|---|---|---|---|---|---|---|\n");
  print_rows<test::NativeRig>();
  print_rows<test::McuRig>();
  print_cost();
}
