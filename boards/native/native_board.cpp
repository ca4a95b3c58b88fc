#include "boards/native/native_board.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "firmware/core/config/design_parameters.hpp"
#include "firmware/core/controller.hpp"
#include "firmware/source_hash.hpp"

namespace umov::boards::native {
namespace {

using firmware::axis_count;

/// Virtual time is counted in ticks of the step timers; a microsecond and a sample are whole ticks.
using Ticks = std::uint64_t;
constexpr Ticks ticks_per_second = firmware::step_timer_hz;
constexpr Ticks ticks_per_us = ticks_per_second / 1'000'000;
constexpr Ticks ticks_per_ms = ticks_per_second / 1'000;
constexpr Ticks ticks_per_sample = ticks_per_second / firmware::sample_rate_hz;
static_assert(ticks_per_us * 1'000'000 == ticks_per_second);
static_assert(ticks_per_sample * firmware::sample_rate_hz == ticks_per_second);

/// Of the reference clock, in one of the step timers.
constexpr Ticks reference_ticks = firmware::reference_clock_hz / firmware::step_timer_hz;
static_assert(reference_ticks * firmware::step_timer_hz == firmware::reference_clock_hz);

constexpr Ticks watchdog_ticks = 250 * ticks_per_ms;
constexpr Ticks never = std::numeric_limits<Ticks>::max();
/// Like a board's transmit buffer: what does not fit waits in the core.
constexpr std::size_t output_capacity = 16 * 1024;

double seconds(Ticks ticks) {
  return static_cast<double>(ticks) / static_cast<double>(ticks_per_second);
}

std::array<char, 24> padded(std::string_view text) {
  std::array<char, 24> name{};
  std::copy_n(text.begin(), std::min(text.size(), name.size()), name.begin());
  return name;
}

firmware::Identity identity_of(const NativeBoardOptions& options) {
  return {.device_name = padded("umov native"),
          .serial = padded(options.serial),
          .firmware_hash = firmware::source_hash,
          .boot_id = options.boot_id,
          .reset_cause = options.reset_cause};
}

}  // namespace

struct NativeBoard::Impl final : firmware::Board {
  Impl(World& the_world, NativeBoardOptions the_options)
      : world(&the_world),
        options(std::move(the_options)),
        log(options.log ? options.log : std::make_shared<RamLog>()),
        settings(options.settings ? options.settings : std::make_shared<RamSettings>()),
        controller(new_controller()) {
    begin();
    options.samples_per_block = std::max(1u, options.samples_per_block);
    signal.resize(options.samples_per_block);
    monitor.resize(options.samples_per_block);
    controller->start();
  }

  std::unique_ptr<firmware::Controller> new_controller() {
    return std::make_unique<firmware::Controller>(*this, *log, identity_of(options),
                                                  firmware::default_axes, settings.get());
  }

  /// Timers and lines as after a reset.
  void begin() {
    directions.fill(1);
    next_step.fill(never);
    next_block = never;
    next_tick = now + ticks_per_ms;
    output.clear();
    find_edge();
  }

  void reset(firmware::ResetCause cause) {
    // Without a program pins are inputs: the pull-downs of the bench keep it dark.
    set_shutter(false);
    for (int laser = 0; laser < 3; ++laser) set_laser(laser, false);
    set_gain(0);
    begin();
    options.reset_cause = cause;
    ++options.boot_id;
    controller = new_controller();
    controller->start();
  }

  void stand_still(Ticks duration) {
    if (duration > watchdog_ticks) {
      now += watchdog_ticks;
      return reset(firmware::ResetCause::watchdog);
    }
    now += duration;
    // Of the ticks missed the processor finds one.
    if (next_tick < now) next_tick = now;
    // The samples of a buffer of two blocks are there still; older ones were overwritten.
    if (next_block != never && now - next_block >= options.samples_per_block * ticks_per_sample) {
      controller->on_adc_overrun();
      next_block = now + options.samples_per_block * ticks_per_sample;
    }
  }

  // firmware::Board
  std::uint64_t time_us() const override { return now / ticks_per_us; }
  std::uint64_t link_time_us() const override {
    return options.link_time_us ? options.link_time_us() : time_us();
  }
  std::size_t link_room() const override { return output_capacity - output.size(); }
  bool write_link(std::span<const std::uint8_t> frame) override {
    if (output.size() + frame.size() > output_capacity) return false;
    output.insert(output.end(), frame.begin(), frame.end());
    return true;
  }
  void set_direction(int axis, int direction) override { directions[index(axis)] = direction; }
  void start_step_timer(int axis, std::uint32_t ticks) override {
    next_step[index(axis)] = now + std::max(1u, ticks);
  }
  void stop_step_timer(int axis) override { next_step[index(axis)] = never; }
  void step(int axis) override { world->step(axis, directions[index(axis)], seconds(now)); }
  firmware::AxisInputs switches(int axis) const override {
    const AxisSwitches s = world->switches(axis);
    return {s.home, s.lower_limit, s.upper_limit};
  }
  void set_laser(int laser, bool on) override { world->set_laser(laser, on, seconds(now)); }
  void set_shutter(bool open) override { world->set_shutter(open, seconds(now)); }
  void set_gain(int range) override { world->set_gain(range, seconds(now)); }
  bool interlock_closed() const override { return world->interlock_closed(); }
  bool emergency_released() const override { return world->emergency_released(); }
  bool overheated() const override { return world->overheated(); }
  bool supply_low() const override { return world->supply_low(); }
  bool stalled(int axis) const override { return world->stalled(axis); }
  std::uint32_t start_sampling(std::uint32_t phase_step) override {
    world->set_reference(phase_step);
    sampling_since = now;
    first_sample = 0;
    next_block = now + options.samples_per_block * ticks_per_sample;
    return reference_clock();
  }
  std::uint32_t reference_clock() const override {
    return static_cast<std::uint32_t>(now * reference_ticks);
  }
  void stop_sampling() override { next_block = never; }
  void mask_interrupts() override {}
  void unmask_interrupts() override {}

  static std::size_t index(int axis) { return static_cast<std::size_t>(axis); }

  /// The next event at or before `limit`; false when there is none (then time is at `limit`).
  bool run_next(Ticks limit) {
    int axis = 0;
    for (int other = 1; other < axis_count; ++other) {
      if (next_step[index(other)] < next_step[index(axis)]) axis = other;
    }
    const Ticks step_at = next_step[index(axis)];
    const Ticks next = std::min({step_at, edge_seen, next_block, next_tick});
    if (next > limit) {
      now = limit;
      return false;
    }
    now = std::max(now, next);  // late after standing still
    // At the same instant interrupts go before the main loop, steps first.
    if (step_at == next) {
      take_step(axis);
    } else if (edge_seen == next) {
      take_edge();
    } else if (next_block == next) {
      take_samples();
    } else {
      next_tick += ticks_per_ms;
      if (edge_seen == never) find_edge();  // somebody may have switched it on
      controller->tick();
      send_all();
    }
    return true;
  }

  /// The main loop of a process has nothing else to look at.
  void send_all() {
    while (controller->send_more()) {
    }
  }

  void take_step(int axis) {
    // A late step does not move the ones after it.
    const Ticks due = next_step[index(axis)];
    if (now - due > firmware::late_step_ticks) controller->on_late_step(axis);
    const std::uint32_t interval = controller->on_step_timer(axis);
    next_step[index(axis)] = interval == 0 ? never : due + interval;
  }

  /// The next edge of the reference input, and the first tick at which it is seen.
  void find_edge() {
    const double next_s = world->next_reference_edge(std::max(edge_s, seconds(now)));
    edge_seen = never;
    if (!std::isfinite(next_s)) return;
    edge_s = next_s;
    edge_seen = static_cast<Ticks>(edge_s * static_cast<double>(ticks_per_second)) + 1;
  }
  void take_edge() {
    const auto tick = static_cast<std::uint64_t>(edge_s * firmware::reference_clock_hz);
    find_edge();
    controller->on_reference_edge(static_cast<std::uint32_t>(tick));
  }

  void take_samples() {
    world->sample(seconds(sampling_since), firmware::sample_rate_hz, first_sample, signal, monitor);
    first_sample += signal.size();
    next_block += signal.size() * ticks_per_sample;
    controller->on_samples(signal, monitor);
  }

  World* world;
  NativeBoardOptions options;
  std::shared_ptr<RamLog> log;
  std::shared_ptr<RamSettings> settings;
  std::unique_ptr<firmware::Controller> controller;
  std::array<int, axis_count> directions{};
  std::array<Ticks, axis_count> next_step{};
  Ticks now = 0;
  Ticks next_tick = ticks_per_ms;
  Ticks next_block = never;
  Ticks edge_seen = never;
  double edge_s = 0;
  Ticks sampling_since = 0;
  std::uint64_t first_sample = 0;
  std::vector<std::uint16_t> signal;
  std::vector<std::uint16_t> monitor;
  std::vector<std::uint8_t> output;
};

NativeBoard::NativeBoard(World& world, NativeBoardOptions options)
    : impl_(std::make_unique<Impl>(world, std::move(options))) {}
NativeBoard::~NativeBoard() = default;
NativeBoard::NativeBoard(NativeBoard&&) noexcept = default;
NativeBoard& NativeBoard::operator=(NativeBoard&&) noexcept = default;

void NativeBoard::deliver(std::span<const std::uint8_t> bytes) {
  impl_->controller->on_link_bytes(bytes);
  impl_->send_all();
}

std::size_t NativeBoard::take_output(std::vector<std::uint8_t>& buffer) {
  const std::size_t size = impl_->output.size();
  buffer.insert(buffer.end(), impl_->output.begin(), impl_->output.end());
  impl_->output.clear();
  return size;
}

bool NativeBoard::has_output() const {
  return !impl_->output.empty();
}

void NativeBoard::run_for(std::uint64_t duration_us) {
  const Ticks limit = impl_->now + duration_us * ticks_per_us;
  while (impl_->run_next(limit)) {
  }
}

bool NativeBoard::run_until_output(std::uint64_t max_duration_us) {
  const Ticks limit = impl_->now + max_duration_us * ticks_per_us;
  while (impl_->output.empty() && impl_->run_next(limit)) {
  }
  return !impl_->output.empty();
}

std::uint64_t NativeBoard::now_us() const {
  return impl_->time_us();
}

bool NativeBoard::resting() const {
  return impl_->next_block == never && impl_->controller->resting();
}

void NativeBoard::jog(int axis, std::int32_t by_udeg) {
  impl_->controller->jog(axis, by_udeg);
}
void NativeBoard::stop_by_hand(bool emergency) {
  impl_->controller->stop_by_hand(emergency);
}
firmware::HandView NativeBoard::hand_view(int axis) const {
  return impl_->controller->hand_view(axis);
}

void NativeBoard::signal_stall(int axis) {
  impl_->controller->on_stall(axis);
}
void NativeBoard::signal_adc_overrun() {
  impl_->controller->on_adc_overrun();
}

void NativeBoard::stand_still(std::uint64_t duration_us) {
  impl_->stand_still(duration_us * ticks_per_us);
}
void NativeBoard::reset(firmware::ResetCause cause) {
  impl_->reset(cause);
}

std::int32_t NativeBoard::position_steps(int axis) const {
  return impl_->controller->motion().position_steps(axis);
}

}  // namespace umov::boards::native
