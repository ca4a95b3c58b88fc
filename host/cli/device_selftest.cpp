#include "host/cli/device_selftest.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/cli/device_session.hpp"
#include "host/cli/interrupt.hpp"
#include "host/instrument/program_stream.hpp"
#include "host/instrument/refusals.hpp"

namespace umov::cli {
namespace {

using instrument::Session;
using nlohmann::json;

struct Options {
  DeviceChoice device;
  bool move = false;
};

enum class Outcome : std::uint8_t { good, failed, not_tried };

struct Check {
  std::string name;
  Outcome outcome = Outcome::good;
  std::string told;    ///< what was found
  std::string remedy;  ///< of a failed one, or why it was not tried
};

/// What a photodiode shows of a laser that is on, at least, and what may be left in the dark: volts
/// of amplitude at the ADC. Half of full scale is 1.65 V.
constexpr double least_light_v = 0.05, most_dark_v = 0.02;

constexpr std::uint16_t dwell_ms = 100;
constexpr int lasers = 3, ranges = 4;

class SelfTest {
 public:
  SelfTest(Session& session, const std::function<void(const Check&)>& tell)
      : session_(&session), tell_(&tell) {}

  void run(bool move) {
    link();
    const auto status = session_->request(protocol::GetStatus{});
    const bool clear = state(status);
    interlock(status);
    log();
    if (!clear) return skip("motion and light", "a fault is latched: umov device log --clear");
    if (status.state != 0) {
      return skip("motion and light", "the controller is " + instrument::state_name(status.state));
    }
    if (move) motion();
    light();
  }
  const std::vector<Check>& checks() const { return checks_; }

 private:
  void add(Check check) {
    (*tell_)(check);
    checks_.push_back(std::move(check));
  }
  void add(const std::string& name, bool good, const std::string& told, const std::string& remedy) {
    add({name, good ? Outcome::good : Outcome::failed, told, good ? "" : remedy});
  }
  void skip(const std::string& name, const std::string& why) {
    add({name, Outcome::not_tried, "not tried", why});
  }

  /// Every request must be answered; those that had to be repeated show in the longest time.
  void link() {
    constexpr std::size_t requests = 200;
    std::vector<double> times_ms;
    for (std::size_t i = 0; i < requests; ++i) {
      const auto begin = session_->clock_us();
      session_->request(protocol::GetStatus{});
      times_ms.push_back(1e-3 * static_cast<double>(session_->clock_us() - begin));
    }
    std::sort(times_ms.begin(), times_ms.end());
    add("link", times_ms.back() < 400,
        fmt::format("{} requests, median {:.2f} ms, longest {:.2f} ms", requests,
                    times_ms[requests / 2], times_ms.back()),
        "answers get lost or are late: try another cable or port");
  }

  bool state(const protocol::Status& status) {
    const bool good = status.fault == 0;
    add("state", good,
        good ? instrument::state_name(status.state) : instrument::fault_meaning(status.fault),
        instrument::fault_remedy(status.fault));
    return good;
  }

  void interlock(const protocol::Status& status) {
    const bool closed = status.interlock_closed != 0;
    add("interlock", closed, closed ? "closed" : "open", "close the enclosure, check its cable");
  }

  /// Faults of this start: history, not a failure.
  void log() {
    int faults = 0;
    for (std::uint16_t index = 0;; ++index) {
      const auto entry = session_->request(protocol::ReadLog{index});
      if (entry.fault == 0 || entry.boot_id != session_->device().boot_id) break;
      ++faults;
    }
    add("log", true, fmt::format("{} faults since the start", faults), "");
  }

  /// Homes each axis, moves it a little and back: it must say that it is where it was sent.
  void motion() {
    for (std::uint8_t axis = 0; axis < protocol::axis_count; ++axis) {
      const std::string name = instrument::axis_name(axis);
      const auto info = session_->request(protocol::GetAxis{axis});
      const double begin_s = 1e-6 * static_cast<double>(session_->clock_us());
      const std::int32_t there = std::min(info.max_udeg, 10'000'000);
      std::int32_t reached = 0, home = 0;
      try {
        session_->request(protocol::Home{static_cast<std::uint8_t>(1u << axis)});
        wait_until_arrived(*session_, 1);
        session_->request(protocol::Move{axis, there});
        wait_until_arrived(*session_, 1);
        reached = position(axis);
        session_->request(protocol::Move{axis, 0});
        wait_until_arrived(*session_, 1);
        home = position(axis);
      } catch (const instrument::Faulted& fault) {
        return add(name, false, fault.problem(), fault.remedy());
      }
      const std::int32_t step = 360'000'000 / static_cast<std::int32_t>(info.steps_per_turn) + 1;
      const bool good = std::abs(reached - there) <= step && std::abs(home) <= step;
      add(name, good,
          fmt::format("homed, moved to {:.3f}° and back in {:.1f} s", 1e-6 * reached,
                      1e-6 * static_cast<double>(session_->clock_us()) - begin_s),
          "it does not stop where it was sent: see umov device log");
    }
  }
  std::int32_t position(int axis) {
    return session_->request(protocol::GetStatus{}).position_udeg[static_cast<std::size_t>(axis)];
  }

  /// Dark at each range, then each laser behind the closed shutter, where only the monitor sees it.
  void light() {
    const auto status = session_->request(protocol::GetStatus{});
    if (status.fault != 0 || status.homed_mask != 63) {
      return skip("light", "the axes are not homed: add --move, or umov device home");
    }
    if (status.interlock_closed == 0) return skip("light", "the interlock is open");
    std::vector<protocol::ProgramRow> rows;
    for (int i = 0; i < ranges + lasers; ++i) rows.push_back(row_here(status, i));
    std::vector<protocol::Record> records;
    class Sink final : public instrument::RecordSink {
     public:
      explicit Sink(std::vector<protocol::Record>& kept) : kept_(&kept) {}
      void take(const protocol::Record& record) override { kept_->push_back(record); }
      void secure() override {}

     private:
      std::vector<protocol::Record>* kept_;
    } sink(records);
    constexpr std::uint32_t program = 0x5E1F'7E57;
    instrument::ProgramOptions options;
    options.program_id = program;
    options.row_count = static_cast<std::uint32_t>(rows.size());
    instrument::ProgramStream stream(
        options, [&](std::uint32_t index) { return rows[index]; }, sink);
    if (!stream.run(*session_, [](const auto&) { return !interrupt_flag().load(); })) {
      session_->request(protocol::ProgramControl{2});
      throw Interrupted("stopped; the lasers are off");
    }
    for (int range = 0; range < ranges; ++range) {
      const auto& record = records[static_cast<std::size_t>(range)];
      const double dark_v = amplitude_v(record.signal_x, record.signal_y, record);
      add(fmt::format("dark, gain {}", session_->device().gains[record.gain]),
          record.saturated == 0 && dark_v < most_dark_v,
          fmt::format("{:.2f} mV, {} samples clipped", 1e3 * dark_v, record.saturated),
          "light or pick-up reaches the photodiode, or its amplifier is off: check both");
    }
    const auto& dark = records[0];
    for (int laser = 0; laser < lasers; ++laser) {
      const auto& record = records[static_cast<std::size_t>(ranges + laser)];
      const double monitor_v = amplitude_v(record.monitor_x, record.monitor_y, record);
      const double leak_v =
          amplitude_v(record.signal_x - dark.signal_x, record.signal_y - dark.signal_y, record);
      const std::string name = fmt::format(
          "laser {} nm", session_->device().wavelengths_nm[static_cast<std::size_t>(laser)]);
      add(name, monitor_v > least_light_v, fmt::format("{:.1f} mV on the monitor", 1e3 * monitor_v),
          "the monitor sees no light of it: check laser, its enable line and the monitor");
      add(name + ", shutter", leak_v < most_dark_v,
          fmt::format("{:.2f} mV pass when it is closed", 1e3 * leak_v),
          "the shutter does not close: check it and its line");
    }
  }

  protocol::ProgramRow row_here(const protocol::Status& status, int number) {
    protocol::ProgramRow row;
    row.index = static_cast<std::uint32_t>(number);
    for (std::size_t axis = 0; axis < row.target_udeg.size(); ++axis) {
      const auto info = session_->request(protocol::GetAxis{static_cast<std::uint8_t>(axis)});
      const std::int32_t now = status.position_udeg[axis];
      row.target_udeg[axis] = now > info.max_udeg ? protocol::open_position : now;
    }
    row.gain = static_cast<std::uint8_t>(number < ranges ? number : 0);
    row.laser = static_cast<std::uint8_t>(number < ranges ? 0 : number - ranges + 1);
    row.dwell_ms = dwell_ms;
    return row;
  }

  /// Amplitude at the ADC of a lock-in sum, 2 · |sum| / (samples · sine amplitude) · step.
  double amplitude_v(std::int64_t x, std::int64_t y, const protocol::Record& record) const {
    const auto& device = session_->device();
    return 2 * std::hypot(static_cast<double>(x), static_cast<double>(y)) /
           (static_cast<double>(record.samples) * device.sine_amplitude) * 1e-9 *
           device.adc_step_nv;
  }

  Session* session_;
  const std::function<void(const Check&)>* tell_;
  std::vector<Check> checks_;
};

const char* word(Outcome outcome) {
  return outcome == Outcome::good ? "good" : outcome == Outcome::failed ? "FAILED" : "skipped";
}

void selftest(const Options& options, const Common& common) {
  catch_interrupts();
  auto session = open_session(options.device, common);
  const std::function<void(const Check&)> tell = [&](const Check& check) {
    if (common.json) return;
    fmt::print("{:<8} {:<24} {}{}{}\n", word(check.outcome), check.name, check.told,
               check.remedy.empty() ? "" : ": ", check.remedy);
    std::fflush(stdout);
  };
  SelfTest test(session, tell);
  test.run(options.move);
  if (common.json) {
    json out = json::array();
    for (const auto& check : test.checks()) {
      out.push_back({{"check", check.name},
                     {"outcome", word(check.outcome)},
                     {"told", check.told},
                     {"remedy", check.remedy}});
    }
    fmt::print("{}\n", out.dump());
  }
  std::string failed;
  for (const auto& check : test.checks()) {
    if (check.outcome == Outcome::failed) failed += (failed.empty() ? "" : ", ") + check.name;
  }
  if (!failed.empty()) {
    throw Error({session.name()}, "the self-test fails: " + failed,
                "the lines above say what to look at");
  }
}

}  // namespace

void add_device_selftest_command(CLI::App& device, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command = device.add_subcommand(
      "selftest", "try link, inputs, amplifier, lasers and shutter; nothing moves without --move");
  add_device_options(*command, options->device);
  command->add_flag("--move", options->move, "home every axis and move it by 10° and back first");
  command->callback([options, &common] { selftest(*options, common); });
}

}  // namespace umov::cli
