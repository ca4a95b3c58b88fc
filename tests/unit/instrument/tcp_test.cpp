#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "host/errors/error.hpp"
#include "host/instrument/link_lost.hpp"
#include "host/instrument/session.hpp"
#include "host/instrument/tcp_server.hpp"
#include "host/instrument/tcp_transport.hpp"
#include "tests/unit/failure.hpp"
#include "tests/unit/instrument/coming_and_going.hpp"
#include "tests/unit/instrument/simulated_device.hpp"

namespace umov::instrument {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using testing::SimulatedDevice;

/// A simulated device behind a port, in a thread of its own, in real time.
class ServedDevice {
 public:
  ServedDevice() : server_(0), port_(server_.port()), thread_([this] { serve(); }) {}
  ~ServedDevice() {
    stop_ = true;
    thread_.join();
  }
  std::uint16_t port() const { return port_; }

 private:
  void serve() {
    SimulatedDevice device;
    device.measure_us = 20;
    testing::Bytes waiting;
    auto last = std::chrono::steady_clock::now();
    std::array<std::uint8_t, 4096> buffer{};
    while (!stop_) {
      server_.wait(200us);
      while (const std::size_t count = server_.read(buffer)) {
        device.receive(std::span<const std::uint8_t>(buffer).first(count));
      }
      const auto now = std::chrono::steady_clock::now();
      device.step(static_cast<std::uint64_t>(
          std::chrono::duration_cast<std::chrono::microseconds>(now - last).count()));
      last = now;
      for (; !device.sent.empty(); device.sent.pop_front()) {
        waiting.insert(waiting.end(), device.sent.front().begin(), device.sent.front().end());
      }
      const std::size_t taken = server_.write(waiting);
      waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(taken));
    }
  }

  TcpServer server_;
  std::uint16_t port_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

TEST(Tcp, ASessionRunsOverAPort) {
  ServedDevice device;
  Session session(connect_tcp("127.0.0.1", device.port()));
  EXPECT_STREQ(session.device().device_name.data(), "simulated");
  EXPECT_EQ(session.name(), "tcp:127.0.0.1:" + std::to_string(device.port()));
  EXPECT_LT(session.clock().fastest_us(), 50'000);
}

TEST(Tcp, AClientThatCameAndWentUnseenKeepsNobodyOut) {
  TcpServer server(0);
  connect_tcp("127.0.0.1", server.port()).reset();
  const auto second = connect_tcp("127.0.0.1", server.port());
  server.wait(1s);
  ASSERT_TRUE(server.has_client());
  EXPECT_EQ(server.client_number(), 2u);
  const std::array<std::uint8_t, 3> bytes = {1, 2, 3};
  second->write(bytes);
  server.wait(1s);
  std::array<std::uint8_t, 16> buffer{};
  EXPECT_EQ(server.read(buffer), 3u);
}

TEST(Tcp, WhatAClientSaidLastIsReadBeforeTheNextIsLetInAndNobodyIsRefused) {
  TcpServer server(0);
  auto first = connect_tcp("127.0.0.1", server.port());
  server.wait(1s);
  ASSERT_EQ(server.client_number(), 1u);
  const std::array<std::uint8_t, 3> bytes = {1, 2, 3};
  first->write(bytes);
  first.reset();
  const auto second = connect_tcp("127.0.0.1", server.port());
  std::array<std::uint8_t, 16> buffer{};
  server.wait(1s);
  EXPECT_EQ(server.client_number(), 1u);
  EXPECT_EQ(server.read(buffer), 3u);
  for (int i = 0; i < 3 && server.client_number() < 2; ++i) {
    server.wait(1s);
    EXPECT_EQ(server.read(buffer), 0u);
  }
  EXPECT_EQ(server.client_number(), 2u);
  second->write(bytes);
  server.wait(1s);
  EXPECT_EQ(server.read(buffer), 3u);
}

TEST(Tcp, AProgramSurvivesAClientThatComesAndGoes) {
  ServedDevice device;
  EXPECT_GE(testing::run_with_a_host_that_comes_and_goes(
                [&] { return connect_tcp("localhost", device.port()); }, 2000, 500),
            4);
}

TEST(Tcp, NobodyListeningIsOneClearMessage) {
  std::uint16_t port = 0;
  {
    TcpServer server(0);
    port = server.port();
  }
  EXPECT_THAT(
      failure_of([&] { connect_tcp("127.0.0.1", port); }),
      HasSubstr(
          "cannot reach 127.0.0.1:" + std::to_string(port) +
          ": Connection refused (is the emulator running? start it with: umov emulator --port " +
          std::to_string(port) + ")"));
}

TEST(Tcp, AnUnknownHostIsOneClearMessage) {
  EXPECT_THAT(failure_of([] { connect_tcp("no-such-host.invalid", 5025); }),
              HasSubstr("cannot reach no-such-host.invalid:5025: "));
}

TEST(Tcp, APortInUseIsOneClearMessage) {
  TcpServer server(0);
  EXPECT_THAT(failure_of([&] { TcpServer second(server.port()); }),
              HasSubstr("Address already in use (choose another port with --port)"));
}

TEST(Tcp, ASecondClientIsRefusedWithTheNameOfTheFirst) {
  ServedDevice device;
  SessionOptions first;
  first.host_name = "bench one";
  Session session(connect_tcp("127.0.0.1", device.port()), first);
  EXPECT_THAT(failure_of([&] { Session second(connect_tcp("127.0.0.1", device.port())); }),
              HasSubstr("the controller is in use by host 'bench one'"));
  EXPECT_EQ(session.request(protocol::GetStatus{}).fault, 0) << "the first goes on undisturbed";
}

TEST(Tcp, WhenTheFirstClientLeavesTheNextIsServed) {
  ServedDevice device;
  for (int i = 0; i < 20; ++i) {
    Session session(connect_tcp("127.0.0.1", device.port()));
    EXPECT_EQ(session.request(protocol::GetStatus{}).fault, 0);
  }
}

TEST(Tcp, AServerThatGoesAwayIsALostLink) {
  auto device = std::make_unique<ServedDevice>();
  Session session(connect_tcp("127.0.0.1", device->port()));
  device.reset();
  EXPECT_THROW(
      {
        for (int i = 0; i < 100; ++i) session.request(protocol::GetStatus{});
      },
      LinkLost);
}

TEST(Tcp, ReadingWaitsNoLongerThanItsTimeout) {
  TcpServer server(0);
  const auto transport = connect_tcp("127.0.0.1", server.port());
  std::array<std::uint8_t, 16> buffer{};
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(transport->read(buffer, 20ms), 0u);
  const auto waited = std::chrono::steady_clock::now() - start;
  EXPECT_GE(waited, 19ms);
  EXPECT_LT(waited, 2s);
}

TEST(Tcp, BytesForNobodyAreDroppedAndASlowClientKeepsTheRestBack) {
  TcpServer server(0);
  const testing::Bytes block(1 << 20, 0x55);
  EXPECT_EQ(server.write(block), block.size()) << "nobody is connected";
  const auto transport = connect_tcp("127.0.0.1", server.port());
  while (!server.has_client()) server.wait(100ms);
  EXPECT_EQ(server.client_number(), 1u);
  std::size_t taken = 0;
  std::size_t last = 1;
  while (last > 0 && taken < (std::size_t{1} << 28)) {
    last = server.write(block);
    taken += last;
  }
  EXPECT_EQ(last, 0u) << "the client reads nothing: at some point no more is taken";
}

}  // namespace
}  // namespace umov::instrument
