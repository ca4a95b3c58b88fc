// A host and a small world for testing the controller through the native board.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "boards/native/native_board.hpp"
#include "boards/native/world.hpp"
#include "firmware/core/config/axis_settings.hpp"
#include "firmware/core/config/design_parameters.hpp"
#include "protocol/frame.hpp"
#include "protocol/messages.hpp"
#include "protocol/requests.hpp"
#include "protocol/schema.hpp"
#include "tests/unit/outside_reference.hpp"

namespace umov::test {

namespace fw = umov::firmware;
namespace pr = umov::protocol;

/// Stages that count steps, switches at fixed places, and a signal that depends on the detector.
class SmallWorld : public boards::native::World {
 public:
  SmallWorld() {
    for (std::size_t a = 0; a < fw::axis_count; ++a) {
      const auto& s = fw::default_axes[a];
      const std::int32_t top = std::max(s.max_udeg, s.open_udeg) + fw::overtravel_udeg + 2'000'000;
      lower[a] =
          fw::steps_from_udeg(s.min_udeg - fw::overtravel_udeg - 2'000'000, s.steps_per_turn);
      upper[a] = fw::steps_from_udeg(top, s.steps_per_turn);
    }
  }
  void step(int axis, int direction, double time_s) override {
    const auto a = static_cast<std::size_t>(axis);
    position[a] += direction;
    ++steps[a];
    if (log_axis == axis) step_times.push_back(time_s);
  }
  boards::native::AxisSwitches switches(int axis) const override {
    const auto a = static_cast<std::size_t>(axis);
    const bool home = position[a] < home_edge[a] && position[a] >= home_edge[a] - home_width[a];
    return {home, position[a] <= lower[a], position[a] >= upper[a]};
  }
  void set_laser(int laser, bool on, double) override {
    lasers[static_cast<std::size_t>(laser)] = on;
  }
  void set_shutter(bool open, double) override { shutter = open; }
  void set_gain(int new_range, double) override { range = new_range; }
  bool interlock_closed() const override { return interlock; }
  bool supply_low() const override { return low_supply; }
  void set_reference(std::uint32_t phase_step) override { step_per_sample = phase_step; }
  double next_reference_edge(double after_s) const override {
    return chopper ? chopper->next_edge_s(after_s) : World::next_reference_edge(after_s);
  }
  void sample(double start_time_s, double sample_rate_hz, std::uint64_t first,
              std::span<std::uint16_t> signal, std::span<std::uint16_t> monitor) override {
    if (chopper && step_per_sample == 0) {
      for (std::size_t i = 0; i < signal.size(); ++i) {
        const auto n = static_cast<double>(first + i);
        const double light = chopper->light(start_time_s + n / sample_rate_hz);
        const double dither = std::fmod(0.618033988749895 * n, 1.0) - 0.5;
        signal[i] = static_cast<std::uint16_t>(std::lround(2048 + 1500 * light + dither));
        monitor[i] = static_cast<std::uint16_t>(std::lround(2048 + 900 * light + dither));
      }
      samples_made += signal.size();
      return;
    }
    const double gain = std::pow(10.0, range);
    const double high = 2048 + dark_codes * gain + (shutter ? signal_codes * gain : 0.0);
    const auto code = [](double v) {
      return static_cast<std::uint16_t>(std::clamp(std::lround(v), 0L, 4095L));
    };
    const std::uint16_t s_high = code(high);
    const std::uint16_t s_low =
        code(2048 + dark_codes * gain - (shutter ? signal_codes * gain : 0));
    for (std::size_t i = 0; i < signal.size(); ++i) {
      const bool on = static_cast<std::uint32_t>((first + i) * step_per_sample) < 0x80000000u;
      signal[i] = on ? s_high : s_low;
      monitor[i] = on ? 3000 : 1096;
    }
    samples_made += signal.size();
  }
  bool dark() const { return !shutter && !lasers[0] && !lasers[1] && !lasers[2]; }

  std::array<std::int32_t, fw::axis_count> position{};
  std::array<std::int64_t, fw::axis_count> steps{};
  std::array<std::int32_t, fw::axis_count> home_edge{};
  std::array<std::int32_t, fw::axis_count> home_width{1'000'000, 1'000'000, 1'000'000,
                                                      1'000'000, 1'000'000, 1'000'000};
  std::array<std::int32_t, fw::axis_count> lower{}, upper{};
  std::array<bool, 3> lasers{};
  bool shutter = false;
  bool interlock = true;
  bool low_supply = false;
  int range = 0;
  double signal_codes = 500;  ///< half the height of the square wave at range 1
  double dark_codes = 0;
  std::optional<OutsideReference> chopper;  ///< chops the light that is on steadily
  std::uint32_t step_per_sample = 0;
  std::uint64_t samples_made = 0;
  int log_axis = -1;
  std::vector<double> step_times;
};

/// What the device said, sorted by kind.
struct Heard {
  std::map<std::uint16_t, std::pair<std::uint8_t, std::vector<std::uint8_t>>> replies;
  std::deque<pr::Record> records;
  std::deque<pr::RowCredit> credits;
  std::vector<pr::FaultEvent> faults;
};

/// A minimal host: one request at a time, and a program fed by credit.
class Bench {
 public:
  explicit Bench(SmallWorld& the_world, boards::native::NativeBoardOptions options = {})
      : world(the_world), board(the_world, std::move(options)) {}

  template <class M>
  std::uint16_t send(const M& message) {
    std::array<std::uint8_t, pr::wire_frame_size<M>> frame;
    const std::size_t size = pr::FrameWriter::write(++sequence_, message, frame);
    board.deliver(std::span<const std::uint8_t>(frame.data(), size));
    return sequence_;
  }
  void listen() {
    std::vector<std::uint8_t> bytes;
    board.take_output(bytes);
    reader_.feed(bytes, [this](const pr::FrameView& f) { hear(f); });
  }
  /// The reply of its own kind, or empty when refused (then `refusal` holds why).
  template <pr::Request M>
  std::optional<pr::ReplyTo<M>> ask(const M& message) {
    const std::uint16_t sequence = send(message);
    listen();
    const auto found = heard.replies.find(sequence);
    if (found == heard.replies.end()) return std::nullopt;
    const auto [type, payload] = found->second;
    heard.replies.erase(found);
    if (type == pr::ErrorReply::info.id) {
      pr::decode(payload, refusal);
      return std::nullopt;
    }
    pr::ReplyTo<M> reply;
    if (type != reply.info.id || !pr::decode(payload, reply).ok()) return std::nullopt;
    return reply;
  }
  template <pr::Request M>
  pr::Refusal refusal_of(const M& message) {
    refusal = {};
    if (ask(message)) return pr::Refusal::none;
    return static_cast<pr::Refusal>(refusal.code);
  }
  bool hello() {
    pr::Hello hello{
        .version = pr::protocol_version, .schema_hash = pr::schema_hash, .host_name = {}};
    return ask(hello).has_value();
  }
  pr::Status status() { return ask(pr::GetStatus{}).value_or(pr::Status{}); }
  pr::State state() { return static_cast<pr::State>(status().state); }
  pr::Fault fault() { return static_cast<pr::Fault>(status().fault); }
  /// Lets time pass, saying something every 200 ms; until the state is `wanted`.
  bool wait_for(pr::State wanted, double seconds) {
    for (double t = 0; t < seconds; t += 0.01) {
      if (state() == wanted) return true;
      board.run_for(10'000);
    }
    return state() == wanted;
  }
  bool home_all() {
    return ask(pr::Home{63}).has_value() && wait_for(pr::State::idle, 300) &&
           status().homed_mask == 63;
  }
  static pr::ProgramRow row(std::uint32_t index) {
    pr::ProgramRow r{
        .index = index, .target_udeg = {}, .laser = 1, .shutter_open = 1, .gain = 0, .dwell_ms = 4};
    r.target_udeg[1] = static_cast<std::int32_t>(index % 40) * 10'000;
    return r;
  }

  SmallWorld& world;
  boards::native::NativeBoard board;
  Heard heard;
  pr::ErrorReply refusal{};

 private:
  void hear(const pr::FrameView& f) {
    const auto take = [&]<class M>(std::deque<M>& into) {
      M m;
      if (pr::decode(f.payload, m).ok()) into.push_back(m);
    };
    if (f.type == pr::Record::info.id) return take(heard.records);
    if (f.type == pr::RowCredit::info.id) return take(heard.credits);
    if (f.type == pr::FaultEvent::info.id) {
      pr::FaultEvent e;
      if (pr::decode(f.payload, e).ok()) heard.faults.push_back(e);
      return;
    }
    heard.replies[f.sequence] = {f.type, {f.payload.begin(), f.payload.end()}};
  }

  pr::FrameReader reader_;
  std::uint16_t sequence_ = 0;
};

}  // namespace umov::test
