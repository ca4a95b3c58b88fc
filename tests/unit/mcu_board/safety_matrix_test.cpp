// Every trouble in every state: dark within a stated time, a controlled stop, one name for it, the
// position known or marked unknown, an entry in the log that outlives a reset, and nothing moves or
// shines until it is cleared. The table of docs/safety.md is written from here.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "host/errors/error.hpp"
#include "host/instrument/refusals.hpp"
#include "tests/unit/mcu_board/trouble_rigs.hpp"

namespace umov {
namespace {

using protocol::Fault;
using protocol::State;

constexpr std::uint8_t detector = 1;
constexpr double core_hz = 168e6;
/// From an edge on a pin until the light is off: entry to the interrupt and what it does, and a
/// step interrupt of six axes that was under way.
constexpr double by_interrupt = 500;
/// What is looked at in each tick: a millisecond and the work of the tick before.
constexpr double by_tick = 1.1e-3 * core_hz;

/// Updating: the settings are being written to flash. Firmware is written by the boot loader, which
/// drives none of the bench's pins.
enum class Doing { idle, homing, moving, sampling, updating };
constexpr std::array all_states = {Doing::idle, Doing::homing, Doing::moving, Doing::sampling,
                                   Doing::updating};
const char* text_of(Doing doing) {
  constexpr std::array<const char*, 5> texts = {"idle", "homing", "moving", "sampling", "updating"};
  return texts[static_cast<std::size_t>(doing)];
}

template <class Rig>
struct Trouble {
  std::string name;
  Fault fault;
  /// Instructions of 168 MHz after which it is dark.
  double dark_within;
  std::function<void(Rig&)> cause;
  /// Empty: it goes away by itself and can be cleared at once.
  std::function<void(Rig&)> remedy{};
  /// Positions are unknown afterwards: of the axis that moves or stalls, or of all.
  bool loses_axis = false, loses_moving_axis = false, restarts = false;
  /// Not a fault when nothing moves and nothing shines.
  bool needs_activity = false;
};

/// Sets something of the bench and shows it to the controller at once.
template <class Rig, class Set>
std::function<void(Rig&)> with_stages(Set set) {
  return [set](Rig& rig) {
    set(rig.stages());
    rig.look_at_inputs();
  };
}

template <class Rig>
std::vector<Trouble<Rig>> troubles() {
  using test::NoisyStages;
  const double by_pin = Rig::has_interrupts ? by_interrupt : by_tick;
  constexpr std::uint64_t hang_us = 30'000, dead_us = 400'000, silence_us = 3'100'000;
  return {
      {.name = "interlock opens",
       .fault = Fault::interlock,
       .dark_within = by_pin,
       .cause = with_stages<Rig>([](NoisyStages& s) { s.interlock = false; }),
       .remedy = with_stages<Rig>([](NoisyStages& s) { s.interlock = true; })},
      {.name = "emergency button",
       .fault = Fault::emergency_stop,
       .dark_within = by_pin,
       .cause = with_stages<Rig>([](NoisyStages& s) { s.button_out = false; }),
       .remedy = with_stages<Rig>([](NoisyStages& s) { s.button_out = true; })},
      {.name = "limit switch closes",
       .fault = Fault::limit,
       .dark_within = by_tick,
       .cause = with_stages<Rig>([](NoisyStages& s) { s.upper_closed = detector; }),
       .remedy = with_stages<Rig>([](NoisyStages& s) { s.upper_closed = -1; })},
      {.name = "stall",
       .fault = Fault::stall,
       .dark_within = by_pin,
       .cause = with_stages<Rig>([](NoisyStages& s) { s.stalled = detector; }),
       .remedy = with_stages<Rig>([](NoisyStages& s) { s.stalled = -1; }),
       .loses_axis = true},
      {.name = "host silent for 3 s",
       .fault = Fault::link_lost,
       .dark_within = 3.1 * core_hz,
       .cause = [](Rig& rig) { rig.run_for(silence_us); },
       .needs_activity = true},
      {.name = "program hangs (watchdog)",
       .fault = Fault::watchdog,
       .dark_within = 0.255 * core_hz,
       .cause = [](Rig& rig) { rig.stand_still(dead_us); },
       .restarts = true},
      {.name = "supply sags below 2.84 V",
       .fault = Fault::brown_out,
       .dark_within = by_pin,
       .cause = [](Rig& rig) { rig.supply(true); },
       .remedy = [](Rig& rig) { rig.supply(false); }},
      {.name = "supply fails (brown-out reset)",
       .fault = Fault::brown_out,
       .dark_within = 1,
       .cause = [](Rig& rig) { rig.brown_out(); },
       .restarts = true},
      {.name = "ADC overrun",
       .fault = Fault::adc_overrun,
       .dark_within = by_interrupt,
       .cause = [](Rig& rig) { rig.overrun_adc(); }},
      {.name = "steps, samples and ticks 30 ms late (underrun)",
       .fault = Fault::missed_deadline,
       .dark_within = 1e-6 * hang_us * core_hz + by_tick,
       .cause = [](Rig& rig) { rig.stand_still(hang_us); },
       .loses_moving_axis = true},
      {.name = "settings damaged, found at a start",
       .fault = Fault::settings_corrupt,
       .dark_within = 1,
       .cause =
           [](Rig& rig) {
             rig.spoil_settings();
             rig.power_cycle();
           },
       .restarts = true},
      {.name = "too hot",
       .fault = Fault::over_temperature,
       .dark_within = by_pin,
       .cause = with_stages<Rig>([](NoisyStages& s) { s.hot = true; }),
       .remedy = with_stages<Rig>([](NoisyStages& s) { s.hot = false; })},
  };
}

template <class Rig>
class SafetyMatrix : public testing::Test {
 protected:
  void open_session() {
    session_.reset();
    session_ = std::make_unique<instrument::Session>(rig_.connect());
  }
  protocol::Status status() { return session_->request(protocol::GetStatus{}); }
  State state() { return static_cast<State>(status().state); }
  void listen(int ms) {
    session_->poll(std::chrono::milliseconds(ms));
    while (auto event = session_->next_event()) {
      if (const auto* told = std::get_if<protocol::FaultEvent>(&*event)) ++told_[told->fault];
    }
  }
  void wait_for(State wanted) {
    for (int i = 0; i < 2000 && state() != wanted; ++i) listen(20);
    ASSERT_EQ(state(), wanted);
  }
  void set_detector_speed(std::uint32_t mdeg_s) {
    const auto now = session_->request(protocol::GetAxis{.axis = detector});
    session_->request(protocol::SetAxis{.axis = detector,
                                        .min_udeg = now.min_udeg,
                                        .max_udeg = now.max_udeg,
                                        .speed_mdeg_s = mdeg_s,
                                        .acceleration_mdeg_s2 = now.acceleration_mdeg_s2,
                                        .jerk_mdeg_s3 = now.jerk_mdeg_s3,
                                        .take_up_udeg = now.take_up_udeg});
  }
  void move_detector(double degrees) {
    session_->request(protocol::Move{
        .axis = detector, .target_udeg = static_cast<std::int32_t>(std::lround(degrees * 1e6))});
  }

  /// Homed, at rest at 0, nothing latched.
  void make_ready() {
    if (status().homed_mask != 63) test::home_all(*session_);
    if (static_cast<State>(status().state) != State::idle) {
      session_->request(protocol::ProgramControl{.action = 2});
      wait_for(State::idle);
    }
    set_detector_speed(20'000);
    move_detector(0);
    wait_for(State::idle);
    told_.clear();
  }
  void start(Doing doing, bool slowly) {
    // Slowly: under way for longer than a host may be silent.
    const std::uint32_t speed = slowly ? 1'000 : 20'000;
    switch (doing) {
      case Doing::idle:
        return;
      case Doing::homing:
        move_detector(4);
        wait_for(State::idle);
        set_detector_speed(speed);
        session_->request(protocol::Home{.axis_mask = 1 << detector});
        break;
      case Doing::moving:
        set_detector_speed(speed);
        move_detector(60);
        break;
      case Doing::sampling: {
        session_->request(protocol::ProgramBegin{.program_id = 9, .first_row = 0, .row_count = 1});
        session_->send(protocol::ProgramRow{.index = 0,
                                            .target_udeg = {},
                                            .laser = 2,
                                            .shutter_open = 1,
                                            .gain = 0,
                                            .dwell_ms = 20'000});
        const std::uint64_t streams = rig_.stages().streams;
        for (int i = 0; i < 100 && rig_.stages().streams == streams; ++i) listen(20);
        ASSERT_FALSE(rig_.stages().dark());
        ASSERT_EQ(state(), State::scanning);
        return;
      }
      case Doing::updating:
        rig_.begin_saving();
        return;
    }
    rig_.run_for(200'000);
    ASSERT_EQ(state(), doing == Doing::homing ? State::homing : State::moving);
  }

  /// Instructions of 168 MHz from the cause to darkness; negative: it was dark before.
  double cause(const Trouble<Rig>& trouble) {
    const bool lit = !rig_.stages().dark();
    const double begin_s = rig_.now_s();
    trouble.cause(rig_);
    for (int i = 0; i < 1000 && !rig_.stages().dark(); ++i) rig_.run_for(1'000);
    EXPECT_TRUE(rig_.stages().dark());
    if (!lit) return -1;
    const double took = (rig_.went_dark_s() - begin_s) * core_hz;
    EXPECT_LE(took, trouble.dark_within);
    return std::max(0.0, took);
  }

  void expect_nothing(const Trouble<Rig>& trouble) {
    listen(10);
    EXPECT_EQ(status().fault, 0) << trouble.name;
    EXPECT_TRUE(told_.empty());
  }

  void expect_safe(const Trouble<Rig>& trouble, Doing doing, std::int32_t steps_before) {
    if (trouble.restarts) {
      rig_.run_for(400'000);
      open_session();
    }
    for (int i = 0; i < 40; ++i) listen(10);
    const auto at_rest = rig_.stages().position;
    const int steps = std::abs(at_rest[detector] - steps_before);
    if (doing == Doing::moving && !trouble.restarts && !trouble.needs_activity) {
      // From 20 deg/s down with 400 deg/s2 and 8,000 deg/s3: v^2/2a + va/2j = 1 degree, a
      // millisecond or two until it begins, and what was late and is caught up.
      const double late_s = trouble.loses_moving_axis ? trouble.dark_within / core_hz : 0;
      EXPECT_GT(steps, 950) << "stopped under control";
      EXPECT_LT(steps, 1'060 + 22'000 * late_s);
    }
    const protocol::Status now = status();
    EXPECT_EQ(static_cast<State>(now.state), State::safe);
    EXPECT_EQ(static_cast<Fault>(now.fault), trouble.fault);
    EXPECT_EQ(told_.size(), 1u) << "one name";
    EXPECT_EQ(told_[static_cast<std::uint8_t>(trouble.fault)], 1) << "told once";
    const bool unknown = trouble.restarts || trouble.loses_axis || doing == Doing::homing ||
                         (trouble.loses_moving_axis && doing == Doing::moving);
    EXPECT_EQ((now.homed_mask >> detector & 1) == 0, unknown);
    if (trouble.restarts) {
      EXPECT_EQ(now.homed_mask, 0);
    }
    if (!unknown) {
      EXPECT_EQ(now.position_udeg[detector], at_rest[detector] * 1'000);
    }
    EXPECT_THROW(move_detector(1), Error);
    EXPECT_THROW(session_->request(protocol::Home{.axis_mask = 63}), Error);
    listen(100);
    EXPECT_EQ(rig_.stages().position, at_rest);
    EXPECT_TRUE(rig_.stages().dark());
    const auto entry = session_->request(protocol::ReadLog{.index = 0});
    EXPECT_EQ(static_cast<Fault>(entry.fault), trouble.fault);
  }

  void clear(const Trouble<Rig>& trouble) {
    const protocol::ClearFault clear{.fault = static_cast<std::uint8_t>(trouble.fault)};
    if (trouble.remedy && trouble.fault != Fault::limit) {
      EXPECT_THROW(session_->request(clear), Error) << "its cause is still there";
    }
    if (trouble.remedy) trouble.remedy(rig_);
    listen(40);  // longer than a limit switch may bounce
    session_->request(clear);
    EXPECT_EQ(status().fault, 0);
    if (trouble.fault == Fault::settings_corrupt) session_->request(protocol::SaveSettings{});
    EXPECT_TRUE(rig_.stages().dark()) << "clearing switches nothing on";
  }

  Rig rig_;
  std::unique_ptr<instrument::Session> session_;
  std::map<std::uint8_t, int> told_;
};

using Rigs = testing::Types<test::NativeRig, test::McuRig>;
TYPED_TEST_SUITE(SafetyMatrix, Rigs);

/// A row of the page: the trouble, its name, and for each state what was measured.
void write_row(const std::string& row) {
  std::printf("%s\n", row.c_str());
  if (const char* path = std::getenv("UMOV_SAFETY_TABLE")) {
    std::ofstream(path, std::ios::app) << row << "\n";
  }
}

std::string measured(double instructions) {
  if (instructions < 0) return "dark already";
  if (instructions <= 1) return "at once";
  if (instructions < 1e5) return std::to_string(std::lround(instructions)) + " instructions";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f ms", instructions / core_hz * 1e3);
  return text.data();
}

TYPED_TEST(SafetyMatrix, EveryTroubleInEveryStateEndsDarkStoppedNamedAndLogged) {
  this->open_session();
  this->session_->request(protocol::SaveSettings{});
  std::vector<Fault> logged;
  for (const auto& trouble : troubles<TypeParam>()) {
    double dark_after = -1;
    for (const Doing doing : all_states) {
      SCOPED_TRACE(trouble.name + " while " + text_of(doing) + " on " + TypeParam::name);
      this->make_ready();
      this->start(doing, trouble.needs_activity);
      if (this->HasFatalFailure()) return;
      const std::int32_t steps_before = this->rig_.stages().position[detector];
      const double took = this->cause(trouble);
      if (doing == Doing::sampling) dark_after = took;
      if (trouble.needs_activity && (doing == Doing::idle || doing == Doing::updating)) {
        this->expect_nothing(trouble);
        continue;
      }
      this->expect_safe(trouble, doing, steps_before);
      this->clear(trouble);
      logged.push_back(trouble.fault);
      if (this->HasFailure()) return;
    }
    write_row(std::string("| ") + TypeParam::name + " | " + trouble.name + " | " +
              instrument::fault_name(static_cast<std::uint8_t>(trouble.fault)) + " | " +
              measured(trouble.dark_within) + " | " + measured(dark_after) + " |");
  }
  this->rig_.power_cycle();
  this->rig_.run_for(100'000);
  this->open_session();
  for (std::size_t i = 0; i < logged.size(); ++i) {
    const auto entry = this->session_->request(
        protocol::ReadLog{.index = static_cast<std::uint8_t>(logged.size() - 1 - i)});
    EXPECT_EQ(static_cast<Fault>(entry.fault), logged[i]) << "after a power cycle, entry " << i;
  }
}

}  // namespace
}  // namespace umov
