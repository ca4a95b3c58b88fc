// Long runs of the controller: steps lost or doubled, ways beyond a limit switch, records over a
// bad link, the integrator against a wider one, payload over USB. Markdown on stdout; exit 1 where
// a count is wrong or a bound missed.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "boards/native/native_board.hpp"
#include "firmware/core/lockin/integrator.hpp"
#include "firmware/core/lockin/sine.hpp"
#include "firmware/core/motion/stopping_distance.hpp"
#include "hil/mcu/board/mcu_board.hpp"
#include "host/instrument/program_stream.hpp"
#include "tests/bench/damaged_pipe.hpp"
#include "tests/unit/firmware/acceleration_end.hpp"
#include "tests/unit/instrument/simulated_link.hpp"
#include "tests/unit/mcu_board/noisy_stages.hpp"
#include "tests/unit/mcu_board/scan_run.hpp"
#include "tests/unit/mcu_board/usb_cable.hpp"

namespace {

using namespace umov;

bool all_good = true;
void require(bool good, const char* what) {
  if (good) return;
  std::fprintf(stderr, "wrong: %s\n", what);
  all_good = false;
}

struct Native {
  static constexpr const char* name = "native core";
  explicit Native(const std::string&) : board(world) {}
  test::NoisyStages& stages() { return world.stages; }
  auto connect() { return test::connect(board); }
  void run_for(std::uint64_t us) { board.run_for(us); }
  test::NoisyWorld world;
  boards::native::NativeBoard board;
};
struct Flashed {
  static constexpr const char* name = "flashed image";
  explicit Flashed(const std::string& image) : board(bench, {.image = image}) {}
  test::NoisyStages& stages() { return bench.stages; }
  auto connect() { return test::connect(board); }
  void run_for(std::uint64_t us) { board.run_for(us); }
  test::NoisyBench bench;
  mcu::McuBoard board;
};

void wait_until_at_rest(instrument::Session& session) {
  for (;;) {
    session.poll(std::chrono::milliseconds(100));
    while (session.next_event()) {
    }
    const auto state = static_cast<protocol::State>(session.request(protocol::GetStatus{}).state);
    if (state == protocol::State::idle || state == protocol::State::safe) return;
  }
}

void set_axis(instrument::Session& session, std::uint8_t axis, double speed, double acceleration,
              double jerk) {
  const auto now = session.request(protocol::GetAxis{.axis = axis});
  session.request(
      protocol::SetAxis{.axis = axis,
                        .min_udeg = now.min_udeg,
                        .max_udeg = now.max_udeg,
                        .speed_mdeg_s = static_cast<std::uint32_t>(speed * 1e3),
                        .acceleration_mdeg_s2 = static_cast<std::uint32_t>(acceleration * 1e3),
                        .jerk_mdeg_s3 = static_cast<std::uint32_t>(jerk * 1e3),
                        .take_up_udeg = now.take_up_udeg});
}

/// Moves to random places, some of them stopped on the way, until so many steps have been made.
/// The bench counts the edges, the controller its own steps.
template <class Rig>
void count_steps(const std::string& image, double wanted) {
  Rig rig(image);
  instrument::Session session(rig.connect());
  test::home_all(session);
  std::mt19937 random(5);
  double steps = 0;
  int moves = 0, stops = 0;
  for (std::uint8_t axis = 0; axis < 3; ++axis) set_axis(session, axis, 150, 1500, 30'000);
  while (steps < wanted) {
    const auto axis = static_cast<std::uint8_t>(random() % 3);
    const auto& s = firmware::default_axes[axis];
    const std::int32_t target =
        std::uniform_int_distribution<std::int32_t>(s.min_udeg, s.max_udeg)(random);
    const std::int32_t before = rig.stages().position[axis];
    session.request(protocol::Move{.axis = axis, .target_udeg = target});
    if (++moves % 7 == 0) {
      rig.run_for(50'000 + random() % 200'000);
      session.request(protocol::Stop{});
      ++stops;
    }
    wait_until_at_rest(session);
    const auto status = session.request(protocol::GetStatus{});
    const std::int32_t at = rig.stages().position[axis];
    require(status.fault == 0, "a fault while moving");
    require(firmware::steps_from_udeg(status.position_udeg[axis], s.steps_per_turn) == at,
            "the position that the controller tells");
    steps += std::abs(at - before);
  }
  std::printf(
      "| steps, %s | %.2e in %d moves of three axes at up to 150,000 steps/s, %d stopped on "
      "the way | none lost, none doubled |\n",
      Rig::name, steps, moves, stops);
}

/// Ways beyond a limit switch that is met where the acceleration ends, as shares of the stopping
/// distance.
template <class Rig>
void run_into_limits(const std::string& image, int times) {
  Rig rig(image);
  instrument::Session session(rig.connect());
  test::home_all(session);
  std::mt19937 random(6);
  double worst = 0, longest = 0;
  const auto limit = static_cast<std::uint8_t>(protocol::Fault::limit);
  for (int i = 0; i < times; ++i) {
    const auto within = [&](int low, int high) {
      return static_cast<double>(std::uniform_int_distribution<int>(low, high)(random));
    };
    const double speed = within(10, 100), acceleration = within(200, 1200),
                 jerk = within(4'000, 24'000);
    set_axis(session, 1, speed, acceleration, jerk);
    firmware::AxisSettings axis = firmware::default_axes[1];
    axis.speed_mdeg_s = static_cast<std::uint32_t>(1000 * speed);
    axis.acceleration_mdeg_s2 = static_cast<std::uint32_t>(1000 * acceleration);
    axis.jerk_mdeg_s3 = static_cast<std::uint32_t>(1000 * jerk);
    // Up to 2 ms before the acceleration ends.
    const auto early = static_cast<std::int32_t>(within(0, 2) * speed);
    rig.stages().upper = std::max(1, test::acceleration_end(axis, 85'000) - early);
    session.request(protocol::Move{.axis = 1, .target_udeg = 85'000'000});
    wait_until_at_rest(session);
    rig.run_for(2'000'000);
    const auto status = session.request(protocol::GetStatus{});
    require(status.fault == limit, "no limit was met");
    const double way = 1e-3 * (rig.stages().position[1] - rig.stages().upper);
    const double allowed = 1e-6 * static_cast<double>(firmware::stopping_distance_udeg(axis));
    require(way <= allowed, "the way beyond a limit");
    require(status.position_udeg[1] == rig.stages().position[1] * 1000, "position at a limit");
    worst = std::max(worst, way / allowed);
    longest = std::max(longest, way);
    rig.stages().upper = 2'000'000;
    rig.run_for(50'000);
    session.request(protocol::ClearFault{.fault = limit});
    session.request(protocol::Move{.axis = 1, .target_udeg = 0});
    wait_until_at_rest(session);
  }
  std::printf(
      "| limit switches met at the end of the acceleration, %s | %d, 10 to 100 °/s, 200 to 1,200 "
      "°/s², 4,000 to "
      "24,000 °/s³ | way beyond at most %.3f of the stopping distance (longest %.2f°), position "
      "right |\n",
      Rig::name, times, worst, longest);
}

class OrderedOnce final : public instrument::RecordSink {
 public:
  void take(const protocol::Record& record) override {
    require(record.index == next_, "a record twice, missing or out of order");
    require(record.signal_x == std::int64_t{record.index} * 1'000'003, "a record's contents");
    next_ = record.index + 1;
  }
  void secure() override {}
  std::uint32_t next() const { return next_; }

 private:
  std::uint32_t next_ = 0;
};

constexpr instrument::testing::LinkFaults bad_cable = {
    .byte_error = 1e-3, .drop = 1e-3, .duplicate = 1e-3, .reorder = 1e-3, .disconnect = 1e-5};

/// Runs the program over as many sessions as it takes.
template <class Connect>
void run_to_the_end(instrument::ProgramStream& stream, const Connect& connect) {
  while (!stream.complete()) {
    try {
      instrument::Session session(connect());
      stream.run(session);
    } catch (const instrument::LinkLost&) {
    }
  }
}

protocol::ProgramRow short_row(std::uint32_t index) {
  protocol::ProgramRow row{};
  row.index = index;
  row.dwell_ms = 1;
  return row;
}

void print_frames(const char* who, const instrument::testing::LinkCounters& c, std::uint32_t rows) {
  std::printf(
      "| frames, %s | %llu, with %llu bytes damaged, %llu frames dropped, %llu doubled, %llu "
      "swapped, %llu times unplugged | %u records, each once, in order |\n",
      who, static_cast<unsigned long long>(c.frames),
      static_cast<unsigned long long>(c.damaged_bytes), static_cast<unsigned long long>(c.dropped),
      static_cast<unsigned long long>(c.duplicated), static_cast<unsigned long long>(c.reordered),
      static_cast<unsigned long long>(c.disconnects), rows);
}

/// The host against a model of the controller, which measures nothing and is as fast as the pipe.
void frames_of_model(std::uint64_t wanted) {
  instrument::testing::Cable cable;
  cable.random.seed(77);
  cable.faults = bad_cable;
  const auto rows = static_cast<std::uint32_t>(wanted / 5);
  OrderedOnce sink;
  instrument::ProgramStream stream({.program_id = 77, .row_count = rows}, short_row, sink);
  run_to_the_end(stream, [&] { return instrument::testing::plug_into(cable); });
  require(sink.next() == rows, "records at the end");
  require(cable.counters.frames >= wanted, "too few frames");
  print_frames("host against a model of the controller", cable.counters, rows);
}

/// The same cable between the host and the firmware's own core, which measures every record.
void frames_of_core(std::uint64_t wanted) {
  Native rig("");
  {
    instrument::Session session(rig.connect());
    test::home_all(session);
  }
  instrument::testing::BadCable cable;
  cable.random.seed(78);
  cable.faults = bad_cable;
  cable.faults.disconnect = 1e-4;
  const auto rows = static_cast<std::uint32_t>(wanted / 5);
  test::Records records;
  instrument::ProgramStream stream({.program_id = 78, .row_count = rows}, short_row, records);
  run_to_the_end(stream,
                 [&] { return std::make_unique<bench::DamagedPipe>(rig.connect(), cable); });
  require(records.all.size() == rows, "records of the native core at the end");
  for (std::uint32_t i = 0; i < records.all.size(); ++i)
    require(records.all[i].index == i, "a record of the native core twice or out of order");
  require(cable.counters.frames >= wanted, "too few frames to the native core");
  print_frames("host against the native core", cable.counters, rows);
}

/// Every sum in 128 bits, rounded where the integrator says it rounds, and compared to the last
/// bit.
void integrator(int records) {
  using firmware::sine_of;
  std::mt19937_64 random(9);
  std::uint64_t samples = 0;
  for (int i = 0; i < records; ++i) {
    const auto mhz = static_cast<std::uint32_t>(10'000 + random() % 19'990'000);
    const firmware::Detection d{.reference = firmware::choose_reference(mhz)};
    const firmware::RecordPlan plan =
        firmware::plan_record(d.reference, 20 + static_cast<std::uint32_t>(random() % 200), 10);
    std::vector<std::uint16_t> signal(plan.samples()), monitor(plan.samples());
    // Noise, full scale, and the extremes throughout.
    for (std::size_t n = 0; n < signal.size(); ++n) {
      signal[n] = static_cast<std::uint16_t>(i % 3 == 0 ? 4095 * (n / 7 % 2) : random() % 4096);
      monitor[n] = static_cast<std::uint16_t>(i % 3 == 1 ? 0 : random() % 4096);
    }
    firmware::Integrator integrator;
    integrator.begin(d, plan, 0);
    for (std::size_t at = 0; at < signal.size();) {
      const std::size_t count = std::min<std::size_t>(1 + random() % 300, signal.size() - at);
      integrator.take({signal.data() + at, count}, {monitor.data() + at, count});
      at += count;
    }
    const firmware::LockinResult result = integrator.result();
    __int128 x = 0, squares = 0;
    std::uint32_t phase = d.reference.half_spacing();
    for (std::uint32_t block = 0; block < plan.blocks; ++block) {
      __int128 product = 0, level = 0, sine = 0;
      for (std::uint32_t n = 0; n < plan.block_samples; ++n) {
        const __int128 code = signal[block * plan.block_samples + n] - 2048;
        product += code * sine_of(phase);
        level += code;
        sine += sine_of(phase);
        phase += d.reference.phase_step;
      }
      const auto half = static_cast<__int128>(plan.block_samples / 2);
      const __int128 both = level * sine;
      product -= (both + (both >= 0 ? half : -half)) / static_cast<__int128>(plan.block_samples);
      // To codes x sine, to the nearest, halves up.
      const __int128 scaled = product * firmware::sine_amplitude * 2 + firmware::fine_amplitude;
      const __int128 unit = __int128{2} * firmware::fine_amplitude;
      __int128 sum = scaled / unit;
      if (scaled % unit < 0) --sum;
      x += sum;
      squares += sum * sum;
    }
    const auto blocks = static_cast<__int128>(plan.blocks);
    const __int128 scatter = (blocks * squares - x * x) / (blocks - 1);
    const auto error = static_cast<__int128>(result.signal_x_se);
    require(static_cast<__int128>(result.signal_x) == x, "a sum of the integrator");
    require(error * error <= scatter && (error + 1) * (error + 1) > scatter, "a standard error");
    samples += plan.samples();
  }
  std::printf(
      "| integrator against sums in 128 bits, native core | %d records, %.1e samples, noise and "
      "full "
      "scale, 10 Hz to 20 kHz | equal to the last bit, standard errors too |\n",
      records, static_cast<double>(samples));
}

/// Records sent again and again over the bulk pipe.
void usb_payload(const std::string& image) {
  constexpr std::uint64_t packet_us = 50;
  test::NoisyBench bench;
  mcu::McuBoard board(bench, {.image = image});
  board.run_for(40'000);
  test::UsbCable cable(board);
  require(cable.plug_in(), "no USB device");
  instrument::Session session(std::make_unique<test::BulkTransport>(board, cable));
  test::home_all(session);
  constexpr std::uint32_t rows = 180;
  test::Records records;
  session.request(protocol::ProgramBegin{.program_id = 5, .first_row = 0, .row_count = rows + 10});
  for (std::uint32_t next = 0; next < rows;) {
    session.poll(std::chrono::milliseconds(20));
    while (auto event = session.next_event()) {
      const auto* credit = std::get_if<protocol::RowCredit>(&*event);
      for (; credit != nullptr && next < rows && next < credit->next_row + credit->free_slots;
           ++next) {
        session.send(protocol::ProgramRow{.index = next,
                                          .target_udeg = {},
                                          .laser = 0,
                                          .shutter_open = 0,
                                          .gain = 0,
                                          .dwell_ms = 1});
      }
    }
    const auto status = session.request(protocol::GetStatus{});
    if (next > status.next_row) next = status.next_row;
  }
  for (int i = 0; i < 200 && session.request(protocol::GetStatus{}).next_record < rows; ++i) {
    session.poll(std::chrono::milliseconds(50));
    while (session.next_event()) {
    }
  }
  require(session.request(protocol::GetStatus{}).next_record == rows, "records to send");
  // One packet offered at a time, as often as a full-speed bus has room for one.
  protocol::FrameReader reader;
  std::size_t payload = 0, wire = 0, offered = 0, quiet = 0;
  const double begin_s = mcu::seconds(board.chip().now());
  constexpr std::size_t offers = 20'000;
  for (; offered < offers; ++offered) {
    usbip::Packet packet;
    if (board.usb().in(1, packet) == usbip::Handshake::ack) {
      quiet = 0;
      wire += packet.size;
      reader.feed(std::span(packet.bytes).first(packet.size), [&](const protocol::FrameView& view) {
        if (view.type == protocol::Record::info.id) payload += view.payload.size();
      });
    } else if (++quiet == 3) {
      // All sent: the oldest is asked for again, and with it the rest.
      std::array<std::uint8_t, protocol::wire_frame_size<protocol::RecordAck>> frame;
      const std::size_t size = protocol::FrameWriter::write(
          static_cast<std::uint16_t>(offered),
          protocol::RecordAck{.program_id = 5, .next_index = 0}, frame);
      board.usb().out(1, std::span(frame).first(size));
      quiet = 0;
    }
    board.run_for(packet_us);
  }
  const double spent_s = mcu::seconds(board.chip().now()) - begin_s;
  // The bound of the project, MB/s.
  constexpr double least = 1.0;
  const double rate = 1e-6 * static_cast<double>(payload) / spent_s;
  const bool enough = rate >= least;
  std::printf(
      "| USB, bulk pipe, virtual time | %.1f MB of records' payload, a packet offered each 50 "
      "µs (1.28 MB/s) | %.2f MB/s payload%s, %.2f MB/s on the wire |\n",
      1e-6 * static_cast<double>(payload), rate, enough ? "" : " (**missed**: at least 1.0)",
      1e-6 * static_cast<double>(wire) / spent_s);
  if (enough) return;
  std::fprintf(stderr, "missed: USB carries %.2f MB/s of payload, less than %.1f\n", rate, least);
  all_good = false;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) {
    std::fprintf(stderr, "usage: bench_controller_limits umov-stm32f407.elf STEPS\n");
    return 2;
  }
  const std::string image = arguments[1];
  const double steps = std::atof(arguments[2]);
  const auto start = std::chrono::steady_clock::now();
  std::printf("| long run | how much | outcome |\n|---|---|---|\n");
  count_steps<Native>(image, 1e7);
  count_steps<Flashed>(image, steps);
  run_into_limits<Native>(image, 200);
  run_into_limits<Flashed>(image, 12);
  frames_of_model(1'000'000);
  frames_of_core(50'000);
  integrator(300);
  usb_payload(image);
  std::printf("\nAll of it in %.0f s.\n",
              std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  return all_good ? 0 : 1;
}
