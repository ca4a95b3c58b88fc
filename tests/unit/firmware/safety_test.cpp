#include <gtest/gtest.h>

#include <functional>

#include "firmware/core/controller.hpp"
#include "tests/unit/firmware/bench.hpp"

namespace umov::test {
namespace {

constexpr int detector = 1;

struct Trouble {
  std::string name;
  pr::Fault fault;
  std::function<void(Bench&)> cause;
  std::function<void(Bench&)> remedy;
  std::int32_t detail;
};

std::vector<Trouble> troubles() {
  const auto nothing = [](Bench&) {};
  return {
      {"interlock", pr::Fault::interlock, [](Bench& b) { b.world.interlock = false; },
       [](Bench& b) { b.world.interlock = true; }, -1},
      {"emergency stop", pr::Fault::emergency_stop, [](Bench& b) { b.send(pr::Stop{1}); }, nothing,
       -1},
      {"stall", pr::Fault::stall, [](Bench& b) { b.board.signal_stall(detector); }, nothing,
       detector},
      {"adc overrun", pr::Fault::adc_overrun, [](Bench& b) { b.board.signal_adc_overrun(); },
       nothing, -1},
  };
}

enum class Doing { nothing, homing, moving, sampling };

void set_going(Bench& bench, Doing doing) {
  ASSERT_TRUE(bench.hello());
  ASSERT_TRUE(bench.home_all());
  switch (doing) {
    case Doing::nothing:
      break;
    case Doing::homing:
      ASSERT_TRUE(bench.ask(pr::Home{1u << detector}));
      bench.board.run_for(300'000);
      ASSERT_EQ(bench.state(), pr::State::homing);
      break;
    case Doing::moving:
      ASSERT_TRUE(bench.ask(pr::Move{detector, 80'000'000}));
      bench.board.run_for(500'000);
      ASSERT_EQ(bench.state(), pr::State::moving);
      break;
    case Doing::sampling: {
      ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 5}));
      for (std::uint32_t i = 0; i < 5; ++i) {
        pr::ProgramRow r = Bench::row(i);
        r.dwell_ms = 2000;
        bench.send(r);
      }
      bench.board.run_for(500'000);
      ASSERT_EQ(bench.state(), pr::State::scanning);
      ASSERT_TRUE(bench.world.shutter);
      break;
    }
  }
  bench.heard.faults.clear();
}

TEST(Safety, EveryFaultInEveryStateEndsInTheSameSafeState) {
  for (const Trouble& trouble : troubles()) {
    for (const Doing doing : {Doing::nothing, Doing::homing, Doing::moving, Doing::sampling}) {
      SCOPED_TRACE(trouble.name + " while " + std::to_string(static_cast<int>(doing)));
      SmallWorld world;
      Bench bench(world);
      set_going(bench, doing);
      const std::uint64_t samples = world.samples_made;
      trouble.cause(bench);
      bench.board.run_for(2'000);
      EXPECT_TRUE(world.dark());
      EXPECT_LE(world.samples_made, samples + 500);
      bench.board.run_for(400'000);
      const auto at_rest = world.position;
      bench.board.run_for(2'000'000);
      EXPECT_EQ(world.position, at_rest);
      EXPECT_EQ(bench.state(), pr::State::safe);
      EXPECT_EQ(bench.fault(), trouble.fault);
      ASSERT_EQ(bench.heard.faults.size(), 1u);
      EXPECT_EQ(bench.heard.faults[0].fault, static_cast<std::uint8_t>(trouble.fault));
      EXPECT_EQ(bench.heard.faults[0].detail, trouble.detail);
      // Nothing moves or shines until it is cleared.
      EXPECT_EQ(bench.refusal_of(pr::Move{detector, 0}), pr::Refusal::fault_active);
      EXPECT_EQ(bench.refusal_of(pr::Home{63}), pr::Refusal::fault_active);
      if (doing == Doing::sampling) {
        EXPECT_EQ(bench.refusal_of(pr::ProgramControl{1}), pr::Refusal::fault_active);
      } else {
        EXPECT_EQ(bench.refusal_of(pr::ProgramBegin{9, 0, 1}), pr::Refusal::fault_active);
      }
      const auto entry = bench.ask(pr::ReadLog{0});
      ASSERT_TRUE(entry);
      EXPECT_EQ(entry->fault, static_cast<std::uint8_t>(trouble.fault));
      EXPECT_EQ(entry->count, 1);
      // Cleared by name, once its cause is gone.
      const pr::ClearFault clear{static_cast<std::uint8_t>(trouble.fault)};
      if (trouble.fault == pr::Fault::interlock) {
        EXPECT_EQ(bench.refusal_of(clear), pr::Refusal::fault_active);
      }
      trouble.remedy(bench);
      EXPECT_EQ(bench.refusal_of(pr::ClearFault{static_cast<std::uint8_t>(pr::Fault::watchdog)}),
                pr::Refusal::wrong_state);
      EXPECT_EQ(bench.refusal_of(clear), pr::Refusal::none);
      EXPECT_EQ(bench.fault(), pr::Fault::none);
      EXPECT_EQ(bench.state(), doing == Doing::sampling ? pr::State::paused : pr::State::idle);
      EXPECT_TRUE(world.dark());
      // The position of the axis is known, or known to be lost.
      const bool lost = trouble.fault == pr::Fault::stall || doing == Doing::homing;
      EXPECT_EQ((bench.status().homed_mask & (1u << detector)) == 0, lost);
      if (!lost) {
        EXPECT_EQ(bench.board.position_steps(detector), world.position[detector]);
      }
    }
  }
}

TEST(Safety, AScanInterruptedByAFaultMeasuresItsRowAgainAndLosesNone) {
  SmallWorld world;
  Bench bench(world);
  set_going(bench, Doing::sampling);
  for (int i = 0; i < 30; ++i) {
    bench.board.run_for(100'000);
    bench.status();
  }
  world.interlock = false;
  bench.board.run_for(500'000);
  bench.status();
  world.interlock = true;
  ASSERT_TRUE(bench.ask(pr::ClearFault{1}));
  ASSERT_TRUE(bench.ask(pr::ProgramControl{1}));
  for (int i = 0; i < 40 && bench.state() != pr::State::idle; ++i) bench.board.run_for(500'000);
  bench.listen();
  std::set<std::uint32_t> rows;
  std::map<std::uint32_t, std::uint64_t> times;
  for (const pr::Record& r : bench.heard.records) {
    rows.insert(r.index);
    if (times.count(r.index) != 0) {
      EXPECT_EQ(times[r.index], r.time_us);  // sent again, not measured again
    }
    times[r.index] = r.time_us;
  }
  EXPECT_EQ(rows, (std::set<std::uint32_t>{0, 1, 2, 3, 4}));
}

TEST(Safety, AStalledAxisMustBeHomedBeforeTheScanGoesOn) {
  SmallWorld world;
  Bench bench(world);
  set_going(bench, Doing::sampling);
  bench.board.signal_stall(detector);
  bench.board.run_for(500'000);
  ASSERT_TRUE(bench.ask(pr::ClearFault{static_cast<std::uint8_t>(pr::Fault::stall)}));
  EXPECT_EQ(bench.refusal_of(pr::ProgramControl{1}), pr::Refusal::not_homed);
  EXPECT_EQ(bench.refusal.detail, detector);
  ASSERT_TRUE(bench.ask(pr::Home{1u << detector}));
  ASSERT_TRUE(bench.wait_for(pr::State::paused, 60));
  EXPECT_EQ(bench.refusal_of(pr::ProgramControl{1}), pr::Refusal::none);
}

TEST(Safety, LatchesLinkLostWhileItMovesOrHomesByHand) {
  for (const Doing doing : {Doing::homing, Doing::moving}) {
    SCOPED_TRACE(static_cast<int>(doing));
    SmallWorld world;
    Bench bench(world);
    ASSERT_TRUE(bench.hello());
    ASSERT_TRUE(bench.home_all());
    // Slow enough to be under way still when the host has been silent for 3 s.
    const auto axis = bench.ask(pr::GetAxis{detector});
    ASSERT_TRUE(axis);
    ASSERT_TRUE(bench.ask(pr::Move{detector, 80'000'000}));
    ASSERT_TRUE(bench.wait_for(pr::State::idle, 60));
    ASSERT_TRUE(
        bench.ask(pr::SetAxis{detector, axis->min_udeg, axis->max_udeg, 2'000,
                              axis->acceleration_mdeg_s2, axis->jerk_mdeg_s3, axis->take_up_udeg}));
    if (doing == Doing::homing) {
      ASSERT_TRUE(bench.ask(pr::Home{1u << detector}));
    } else {
      ASSERT_TRUE(bench.ask(pr::Move{detector, 0}));
    }
    const auto start = world.position;
    bench.board.run_for(2'900'000);
    EXPECT_NE(world.position, start);
    bench.board.run_for(2'000'000);
    const auto at_rest = world.position;
    bench.board.run_for(2'000'000);
    EXPECT_EQ(world.position, at_rest);
    EXPECT_EQ(bench.fault(), pr::Fault::link_lost);
  }
}

TEST(Safety, DoesNotAddLinkLostToAFaultThatBrakesTheAxes) {
  SmallWorld world;
  Bench bench(world);
  set_going(bench, Doing::moving);
  bench.board.signal_stall(detector);
  bench.board.run_for(20'000'000);
  EXPECT_EQ(bench.fault(), pr::Fault::stall);
  ASSERT_TRUE(bench.ask(pr::ClearFault{static_cast<std::uint8_t>(pr::Fault::stall)}));
  EXPECT_EQ(bench.fault(), pr::Fault::none);
}

TEST(Safety, LatchesLinkLostInAProgramButNotAtRest) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  ASSERT_TRUE(bench.home_all());
  bench.board.run_for(20'000'000);
  EXPECT_EQ(bench.fault(), pr::Fault::none);
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 5}));
  bench.board.run_for(2'900'000);
  EXPECT_EQ(bench.fault(), pr::Fault::none);
  bench.board.run_for(3'100'000);
  EXPECT_EQ(bench.fault(), pr::Fault::link_lost);
}

TEST(Safety, JudgesTheLinkByTheClockTheBoardGivesForIt) {
  SmallWorld world;
  std::uint64_t wall_us = 0;
  Bench bench(world, {.link_time_us = [&] { return wall_us; }, .log = nullptr});
  ASSERT_TRUE(bench.hello());
  ASSERT_TRUE(bench.home_all());
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 5}));
  bench.board.run_for(100'000'000);  // virtual time alone means nothing
  EXPECT_EQ(bench.fault(), pr::Fault::none);
  wall_us += 3'000'000;
  bench.board.run_for(1'000);
  EXPECT_EQ(bench.fault(), pr::Fault::link_lost);
}

TEST(Safety, KeepsTheLogOverARestart) {
  auto log = std::make_shared<boards::native::RamLog>();
  SmallWorld world;
  {
    Bench bench(world, {.boot_id = 5, .link_time_us = {}, .log = log});
    ASSERT_TRUE(bench.hello());
    ASSERT_TRUE(bench.ask(pr::Stop{1}));
  }
  Bench bench(world, {.boot_id = 6, .link_time_us = {}, .log = log});
  ASSERT_TRUE(bench.hello());
  EXPECT_EQ(bench.fault(), pr::Fault::none);
  const auto entry = bench.ask(pr::ReadLog{0});
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->boot_id, 5u);
  EXPECT_EQ(entry->fault, static_cast<std::uint8_t>(pr::Fault::emergency_stop));
  const auto none = bench.ask(pr::ReadLog{1});
  ASSERT_TRUE(none);
  EXPECT_EQ(none->fault, 0);
}

TEST(Safety, LatchesASecondFaultBesideTheFirstAndReportsEachOnce) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(bench.ask(pr::Stop{1}));
  world.interlock = false;
  bench.board.run_for(100'000);
  bench.listen();
  ASSERT_EQ(bench.heard.faults.size(), 2u);
  ASSERT_TRUE(bench.ask(pr::ClearFault{static_cast<std::uint8_t>(pr::Fault::emergency_stop)}));
  EXPECT_EQ(bench.state(), pr::State::safe);
  EXPECT_EQ(bench.fault(), pr::Fault::interlock);
}

/// A board whose clock the test turns, for what the native board never does.
class IdleBoard final : public fw::Board {
 public:
  std::uint64_t now = 0;
  std::uint64_t time_us() const override { return now; }
  std::uint64_t link_time_us() const override { return now; }
  std::size_t link_room() const override { return 4096; }
  bool write_link(std::span<const std::uint8_t>) override { return true; }
  void set_direction(int, int) override {}
  void start_step_timer(int, std::uint32_t) override {}
  void stop_step_timer(int) override {}
  void step(int) override {}
  fw::AxisInputs switches(int) const override { return {}; }
  void set_laser(int, bool) override {}
  void set_shutter(bool) override {}
  void set_gain(int) override {}
  bool interlock_closed() const override { return true; }
  bool emergency_released() const override { return true; }
  bool overheated() const override { return false; }
  bool supply_low() const override { return false; }
  bool stalled(int) const override { return false; }
  std::uint32_t start_sampling(std::uint32_t) override { return 0; }
  std::uint32_t reference_clock() const override { return 0; }
  void stop_sampling() override {}
  void mask_interrupts() override {}
  void unmask_interrupts() override {}
};

TEST(Safety, TellsEveryFaultWhenAllAreLatchedAndOneWasClearedBefore) {
  IdleBoard board;
  boards::native::RamLog log;
  fw::Safety safety(board, log, 1);
  std::vector<int> raised{static_cast<int>(pr::Fault::stall)}, told;
  ASSERT_TRUE(safety.raise(pr::Fault::stall, 2));
  safety.clear(pr::Fault::stall);
  for (int fault = 1; fault < fw::fault_count; ++fault) {
    ASSERT_TRUE(safety.raise(static_cast<pr::Fault>(fault), -1));
    raised.push_back(fault);
  }
  for (pr::FaultEvent event; safety.next_report(event); safety.mark_reported()) {
    told.push_back(event.fault);
  }
  EXPECT_EQ(told, raised);
}

TEST(Safety, LatchesAMissedTickAndTheFaultsOfTheLastReset) {
  for (const auto cause :
       {fw::ResetCause::power_on, fw::ResetCause::watchdog, fw::ResetCause::brown_out}) {
    IdleBoard board;
    boards::native::RamLog log;
    auto controller = std::make_unique<fw::Controller>(
        board, log, fw::Identity{.device_name = {}, .serial = {}, .reset_cause = cause});
    controller->start();
    EXPECT_EQ(log.count(), cause == fw::ResetCause::power_on ? 0 : 1);
    const auto before = log.count();
    for (int i = 0; i < 100; ++i) {
      board.now += 1000;
      controller->tick();
    }
    EXPECT_EQ(log.count(), before);
    board.now += 30'000;
    controller->tick();
    ASSERT_EQ(log.count(), before + 1);
    fw::LoggedFault entry;
    ASSERT_TRUE(log.read(0, entry));
    EXPECT_EQ(entry.fault, static_cast<std::uint8_t>(pr::Fault::missed_deadline));
  }
}

}  // namespace
}  // namespace umov::test
