// A controller on a serial line, which here is a pseudo-terminal.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "host/instrument/link_lost.hpp"
#include "host/instrument/serial_transport.hpp"
#include "host/instrument/session.hpp"
#include "tests/unit/failure.hpp"
#include "tests/unit/instrument/coming_and_going.hpp"
#include "tests/unit/instrument/simulated_device.hpp"

namespace umov::instrument {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using testing::SimulatedDevice;

/// A simulated device at the far end of a line, in a thread of its own, in real time.
class DeviceOnALine {
 public:
  DeviceOnALine() : end_(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    std::array<char, 64> name{};
    if (end_ < 0 || grantpt(end_) != 0 || unlockpt(end_) != 0 ||
        ptsname_r(end_, name.data(), name.size()) != 0) {
      throw std::runtime_error("no pseudo-terminal");
    }
    path = name.data();
    // Held open, so that the line does not hang up between two programs.
    near_ = open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    thread_ = std::thread([this] { serve(); });
  }
  ~DeviceOnALine() {
    pull();
    if (near_ >= 0) close(near_);
  }
  /// The adapter is unplugged.
  void pull() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    if (end_ >= 0) close(end_);
    end_ = -1;
  }
  std::string path;

 private:
  void serve() {
    SimulatedDevice device;
    device.measure_us = 20;
    testing::Bytes waiting;
    auto last = std::chrono::steady_clock::now();
    std::array<std::uint8_t, 4096> buffer{};
    while (!stop_) {
      pollfd request{end_, POLLIN, 0};
      poll(&request, 1, 1);
      for (ssize_t n; (n = read(end_, buffer.data(), buffer.size())) > 0;) {
        device.receive(std::span<const std::uint8_t>(buffer).first(static_cast<std::size_t>(n)));
      }
      const auto now = std::chrono::steady_clock::now();
      device.step(static_cast<std::uint64_t>(
          std::chrono::duration_cast<std::chrono::microseconds>(now - last).count()));
      last = now;
      for (; !device.sent.empty(); device.sent.pop_front()) {
        waiting.insert(waiting.end(), device.sent.front().begin(), device.sent.front().end());
      }
      const ssize_t taken = write(end_, waiting.data(), waiting.size());
      if (taken > 0) waiting.erase(waiting.begin(), waiting.begin() + taken);
    }
  }

  int end_;
  int near_ = -1;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

TEST(SerialLine, AProgramSurvivesAHostThatComesAndGoesWithEveryByteThereIs) {
  DeviceOnALine device;
  EXPECT_EQ(connect_serial_line(device.path, 1'000'000)->name(), "serial:" + device.path);
  EXPECT_GE(testing::run_with_a_host_that_comes_and_goes(
                [&] { return connect_serial_line(device.path, 1'000'000); }, 600, 200),
            3);
}

TEST(SerialLine, IsRawAndHasTheSpeedAskedFor) {
  DeviceOnALine device;
  const auto transport = connect_serial_line(device.path, 115'200);
  const int line = open(device.path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios settings{};
  ASSERT_EQ(tcgetattr(line, &settings), 0);
  close(line);
  EXPECT_EQ(cfgetospeed(&settings), static_cast<speed_t>(B115200));
  EXPECT_EQ(settings.c_lflag & static_cast<tcflag_t>(ICANON | ECHO | ISIG), 0u);
  EXPECT_EQ(settings.c_oflag & static_cast<tcflag_t>(OPOST), 0u);
  EXPECT_EQ(settings.c_iflag & static_cast<tcflag_t>(IXON | ICRNL), 0u);
}

TEST(SerialLine, AnAdapterThatIsPulledIsALostLink) {
  DeviceOnALine device;
  Session session(connect_serial_line(device.path, 1'000'000));
  device.pull();
  EXPECT_THROW(
      {
        for (int i = 0; i < 100; ++i) session.request(protocol::GetStatus{});
      },
      LinkLost);
}

TEST(SerialLine, OneProgramAtATime) {
  DeviceOnALine device;
  const auto first = connect_serial_line(device.path, 1'000'000);
  EXPECT_THAT(failure_of([&] { connect_serial_line(device.path, 1'000'000); }),
              HasSubstr("another program has opened the controller"));
}

TEST(SerialLine, WhatIsNoneIsOneClearMessage) {
  EXPECT_THAT(failure_of([] { connect_serial_line("/dev/no-such-line", 1'000'000); }),
              HasSubstr("serial:/dev/no-such-line: can't be opened: No such file"));
  EXPECT_THAT(failure_of([] { connect_serial_line("/dev/null", 1'000'000); }),
              HasSubstr("serial:/dev/null: is no serial line"));
  EXPECT_THAT(failure_of([] { connect_serial_line("/dev/null", 1'234); }),
              HasSubstr("1234 baud is no speed of serial lines"));
}

}  // namespace
}  // namespace umov::instrument
