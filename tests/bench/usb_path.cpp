// How fast the controller's frames come through a real kernel: the firmware's USB stack floods, the
// host's transport takes and checks every frame. And how soon a controller that was plugged in
// again is heard; exit 1 where a bound is missed. Runs where it may plug a device into the kernel:
// ./dev lab -- …/bench_usb_path
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "firmware/core/usb/device.hpp"
#include "hil/usbip/server.hpp"
#include "hil/usbip/stack_port.hpp"
#include "host/errors/error.hpp"
#include "host/instrument/hid_transport.hpp"
#include "host/instrument/link_lost.hpp"
#include "host/instrument/usb_transport.hpp"
#include "protocol/frame.hpp"
#include "protocol/messages.hpp"
#include "protocol/schema.hpp"

namespace {

using namespace umov;
using Clock = std::chrono::steady_clock;
using Bytes = std::vector<std::uint8_t>;

constexpr const char* bus_id = "1-1";
constexpr std::uint32_t pattern_frames = 4096;
/// The bounds of the project; the rate is that of payload over the bulk pipes.
constexpr double least_mb_s = 5, most_recovery_s = 2;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

template <class M>
Bytes frame_of(const M& message, std::uint16_t sequence) {
  Bytes frame(protocol::wire_frame_size<M>);
  frame.resize(protocol::FrameWriter::write(sequence, message, frame));
  return frame;
}

/// Records as a scan sends them, over and over.
Bytes record_frames(std::uint32_t count) {
  Bytes all;
  for (std::uint32_t i = 0; i < count; ++i) {
    protocol::Record record;
    record.program_id = 0x1234567;
    record.index = i;
    record.time_us = 50'000 * i;
    record.signal_x = 123'456'789'012 + i;
    record.monitor_x = 987'654'321'098 - i;
    record.samples = 5000;
    const Bytes frame = frame_of(record, static_cast<std::uint16_t>(i));
    all.insert(all.end(), frame.begin(), frame.end());
  }
  return all;
}

/// A controller that says as much as it can, plugged into this kernel; lives in a thread of its
/// own.
class Flood final : private firmware::usb::Application {
 public:
  explicit Flood(Bytes pattern) : pattern_(std::move(pattern)), thread_([this] { run(); }) {}
  ~Flood() {
    ended_ = true;
    thread_.join();
  }
  /// Pulls the plug for so long; returns when it is in again.
  void replug(std::chrono::milliseconds pause) {
    unplug_for_ms_ = pause.count();
    while (unplug_for_ms_ != 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

 private:
  void on_link_bytes(std::span<const std::uint8_t>) override {
    greeted_ = true;
    at_ = 0;
  }
  void on_hand_report(const firmware::usb::HandReport&) override {}
  firmware::usb::HandState hand_state(std::uint8_t) const override { return {}; }
  bool detach_allowed() const override { return true; }
  void on_detach() override {}

  void run() {
    port_.bind(device_);
    device_.start();
    usbip::Server server({usbip::export_device(bus_id, 2, port_)});
    server.plug_into_kernel(bus_id);
    const auto start = Clock::now();
    while (!ended_) {
      server.wait(std::chrono::milliseconds(1));
      do {
        device_.tick(static_cast<std::uint64_t>(1e6 * seconds_since(start)));
        fill();
      } while (server.service() && !ended_);
      if (const auto pause = unplug_for_ms_.load(); pause != 0) {
        server.unplug(bus_id);
        greeted_ = false;
        std::this_thread::sleep_for(std::chrono::milliseconds(pause));
        server.plug_into_kernel(bus_id);
        unplug_for_ms_ = 0;
      }
    }
  }
  /// One ring full at most: while nobody owns the link, all that is written is dropped.
  void fill() {
    for (std::size_t left = device_.link_room(); greeted_ && left > 0;) {
      const std::size_t size = std::min(left, pattern_.size() - at_);
      device_.write_link(std::span<const std::uint8_t>(pattern_).subspan(at_, size));
      at_ = (at_ + size) % pattern_.size();
      left -= size;
    }
  }

  Bytes pattern_;
  std::size_t at_ = 0;
  bool greeted_ = false;
  std::atomic<bool> ended_ = false;
  std::atomic<std::int64_t> unplug_for_ms_ = 0;
  usbip::StackPort port_;
  firmware::usb::Device device_{port_, *this, {'F', 'L', 'O', 'O', 'D'}};
  std::thread thread_;
};

using Connect = std::function<std::unique_ptr<instrument::Transport>()>;

std::unique_ptr<instrument::Transport> connect_soon(const Connect& connect) {
  for (const auto deadline = Clock::now() + std::chrono::seconds(20);;) {
    try {
      return connect();
    } catch (const Error&) {
      if (Clock::now() > deadline) throw;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
}

void greet(instrument::Transport& transport) {
  Bytes hello = frame_of(protocol::Hello{protocol::protocol_version, protocol::schema_hash, {}}, 1);
  hello.insert(hello.begin(), 0);
  transport.write(hello);
}

struct Rate {
  double mb_s = 0;
  std::uint64_t frames = 0;  ///< that came whole
  std::uint64_t lost = 0;    ///< by their numbers
};

/// Takes so many bytes and looks at every frame in them.
Rate take(instrument::Transport& transport, std::size_t total) {
  Bytes buffer(65536);
  protocol::FrameReader reader;
  Rate rate;
  std::uint16_t expected = 0;
  std::size_t taken = 0;
  const auto start = Clock::now();
  while (taken < total) {
    const std::size_t count = transport.read(buffer, std::chrono::seconds(2));
    if (count == 0) {
      throw Error("the flood has dried up after " + std::to_string(taken) + " bytes",
                  "look at the messages of the kernel");
    }
    taken += count;
    reader.feed(std::span<const std::uint8_t>(buffer).first(count),
                [&](const protocol::FrameView& frame) {
                  rate.lost += (frame.sequence + pattern_frames - expected) % pattern_frames;
                  expected = static_cast<std::uint16_t>((frame.sequence + 1) % pattern_frames);
                  ++rate.frames;
                });
  }
  rate.mb_s = 1e-6 * static_cast<double>(taken) / seconds_since(start);
  return rate;
}

}  // namespace

int main(int argc, char** argv) {
  bool all_met = true;
  const auto met = [&](bool good) {
    all_met = all_met && good;
    return good ? "" : " – missed";
  };
  const double megabytes = argc > 1 ? std::atof(argv[1]) : 10;
  try {
    const Bytes pattern = record_frames(pattern_frames);
    const double payload = static_cast<double>(pattern_frames) *
                           protocol::wire_size<protocol::Record> /
                           static_cast<double>(pattern.size());
    Flood flood(pattern);
    const std::vector<std::pair<std::string, Connect>> pipes = {
        {"usb", [] { return instrument::connect_usb("FLOOD"); }},
        {"hid", [] { return instrument::connect_hid("FLOOD"); }}};
    for (const auto& [name, connect] : pipes) {
      auto transport = connect_soon(connect);
      greet(*transport);
      const double share = name == "usb" ? 1.0 : 0.01;
      const Rate rate = take(*transport, static_cast<std::size_t>(share * 1e6 * megabytes));
      std::printf("%s: %.2f MB/s of frames, %.2f MB/s of payload, %llu frames, %llu lost%s\n",
                  name.c_str(), rate.mb_s, payload * rate.mb_s,
                  static_cast<unsigned long long>(rate.frames),
                  static_cast<unsigned long long>(rate.lost),
                  met(name != "usb" || payload * rate.mb_s >= least_mb_s));
      std::fflush(stdout);
      transport.reset();
    }
    for (const auto& [name, connect] : pipes) {
      double worst = 0;
      for (int i = 0; i < 3; ++i) {
        flood.replug(std::chrono::milliseconds(500));
        const auto plugged_in = Clock::now();
        auto transport = connect_soon(connect);
        greet(*transport);
        Bytes first(64);
        if (transport->read(first, std::chrono::seconds(5)) == 0) throw Error("no byte came", "");
        worst = std::max(worst, seconds_since(plugged_in));
      }
      std::printf("%s: heard %.2f s after it was plugged in again (worst of 3)%s\n", name.c_str(),
                  worst, met(worst <= most_recovery_s));
      std::fflush(stdout);
    }
  } catch (const Error& error) {
    std::fprintf(stderr, "bench_usb_path: %s\n", error.what());
    return 1;
  }
  if (all_met) return 0;
  std::fprintf(
      stderr,
      "bench_usb_path: a bound is missed (%.0f MB/s of payload over usb, heard within %.0f s)\n",
      least_mb_s, most_recovery_s);
  return 1;
}
