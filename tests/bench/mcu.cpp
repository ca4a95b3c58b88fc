// What the controller's program costs on the emulated board: instructions per step and per lock-in
// sample, and what share of 168 million a second that is. Markdown tables on stdout; exit 1 where a
// bound is missed.
#include <chrono>
#include <cstdio>
#include <map>
#include <string>

#include "firmware/core/config/axis_settings.hpp"
#include "hil/mcu/board/mcu_board.hpp"
#include "tests/unit/mcu_board/noisy_stages.hpp"
#include "tests/unit/mcu_board/scan_run.hpp"

namespace {

using namespace umov;

constexpr int tim2 = 16 + 28, tim5 = 16 + 50, samples_done = 16 + 56;
constexpr double core_hz = 168e6;
/// Cycles of an exception's entry and return that are no instructions.
constexpr double entry_and_return = 24;
/// The bound of the project: the lock-in's share of the processor, two channels at 100 kS/s.
constexpr double most_lockin_percent = 30;

struct Count {
  double seconds = 0, all = 0, steps = 0, step_entries = 0, samples = 0, sample_entries = 0;
};

class Controller {
 public:
  explicit Controller(const std::string& image)
      : board_(bench_, {.image = image}), session_(test::connect(board_)) {
    test::home_all(session_);
  }

  Count now() const {
    const auto& chip = board_.chip();
    const auto of = [&](int e) { return static_cast<double>(chip.instructions_in(e)); };
    const auto entries = [&](int e) { return static_cast<double>(chip.entries_of(e)); };
    return {mcu::seconds(chip.now()), static_cast<double>(chip.instructions()),
            of(tim2) + of(tim5),      entries(tim2) + entries(tim5),
            of(samples_done),         entries(samples_done)};
  }
  void rest(double seconds) {
    const double until = now().seconds + seconds;
    while (now().seconds < until) session_.poll(std::chrono::milliseconds(100));
  }
  void set_speed(int axis, double steps_per_second) {
    const auto& s = firmware::default_axes[static_cast<std::size_t>(axis)];
    const auto speed =
        static_cast<std::uint32_t>(steps_per_second / s.steps_per_turn * 360e3 + 0.5);
    session_.request(protocol::SetAxis{.axis = static_cast<std::uint8_t>(axis),
                                       .min_udeg = s.min_udeg,
                                       .max_udeg = s.max_udeg,
                                       .speed_mdeg_s = speed,
                                       .acceleration_mdeg_s2 = 10 * speed,
                                       .jerk_mdeg_s3 = 200 * speed,
                                       .take_up_udeg = 0});
  }
  /// Measures one row; `degrees` are the targets of some axes, the others go to 0.
  Count row(const std::map<int, double>& degrees, std::uint16_t dwell_ms) {
    protocol::ProgramRow row{.index = 0,
                             .target_udeg = {},
                             .laser = 1,
                             .shutter_open = 1,
                             .gain = 0,
                             .dwell_ms = dwell_ms};
    for (const auto& [axis, angle] : degrees)
      row.target_udeg[static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(angle * 1e6);
    const Count before = now();
    test::Records records;
    instrument::ProgramStream stream(
        {.program_id = ++program_, .row_count = 1}, [&](std::uint32_t) { return row; }, records);
    stream.run(session_);
    const Count after = now();
    return {after.seconds - before.seconds, after.all - before.all,
            after.steps - before.steps,     after.step_entries - before.step_entries,
            after.samples - before.samples, after.sample_entries - before.sample_entries};
  }

 private:
  test::NoisyBench bench_;
  mcu::McuBoard board_;
  instrument::Session session_;
  std::uint32_t program_ = 0;
};

void print_steps(const char* what, const Count& count, double steps, double rate) {
  const double each = count.steps / steps;
  const double share = rate * (each + entry_and_return * count.step_entries / steps) / core_hz;
  std::printf("| %s | %.0f | %.0f | %.1f %% |\n", what, steps, each, 100 * share);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: bench_mcu umov-stm32f407.elf\n");
    return 2;
  }
  const auto start = std::chrono::steady_clock::now();
  Controller controller(arguments[1]);

  std::printf(
      "| motion | steps | instructions a step | of 168 MHz at that rate |\n|---|---|---|---|\n");
  controller.set_speed(1, 200'000);
  print_steps("one axis, 200,000 steps/s", controller.row({{1, 80}}, 1), 80'000, 200'000);
  for (const int axis : {0, 1, 2}) controller.set_speed(axis, 100'000);
  controller.row({}, 1);
  print_steps("three axes, 100,000 steps/s each", controller.row({{0, 80}, {1, 80}, {2, 80}}, 1),
              240'000, 300'000);
  for (const int axis : {0, 1, 2}) controller.set_speed(axis, 40'000);
  controller.row({}, 1);
  print_steps("six axes at their full speed, 300,000 steps/s together",
              controller.row({{0, 40}, {1, 40}, {2, 40}, {3, 180}, {4, 180}, {5, 300}}, 1), 222'000,
              300'000);
  controller.row({}, 1);

  const Count lockin = controller.row({}, 2000);
  const double pairs = lockin.sample_entries * 250;
  const double rest_before = controller.now().all, rest_from = controller.now().seconds;
  controller.rest(2);
  const double resting =
      (controller.now().all - rest_before) / (controller.now().seconds - rest_from);
  const double lockin_percent = 100 * lockin.samples / pairs * 1e5 / core_hz;
  const bool missed = !(lockin_percent <= most_lockin_percent);
  std::printf(
      "\n| work | instructions | of 168 MHz |\n|---|---|---|\n"
      "| lock-in, a pair of samples (2 channels at 100 kS/s) | %.1f | %.1f %%%s |\n"
      "| all of it while a record is measured, a second | %.0f | %.1f %% |\n"
      "| at rest with a host that listens, a second | %.0f | %.2f %% |\n",
      lockin.samples / pairs, lockin_percent, missed ? " (**missed**: at most 30 %)" : "",
      lockin.all / lockin.seconds, 100 * lockin.all / lockin.seconds / core_hz, resting,
      100 * resting / core_hz);

  const double wall =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("\nEmulation: %.1f s of virtual time and %.0f million instructions in %.1f s.\n",
              controller.now().seconds, controller.now().all * 1e-6, wall);
  if (missed) {
    std::fprintf(stderr, "missed: the lock-in takes %.1f %% of the processor, more than %.0f %%\n",
                 lockin_percent, most_lockin_percent);
  }
  return missed ? 1 : 0;
}
