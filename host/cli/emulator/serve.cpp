// The emulated instrument behind a TCP port.
#include <array>
#include <chrono>
#include <thread>
#include <vector>

#include "host/cli/emulator/emulated_instrument.hpp"
#include "host/instrument/tcp_server.hpp"

namespace umov::emulator {
namespace {

using Clock = std::chrono::steady_clock;

/// Virtual time given to the board before the network is looked at again.
constexpr std::uint64_t slice_us = 20'000;
constexpr std::uint64_t tick_us = 1'000;

}  // namespace

void serve(const BenchOptions& bench, const ServeOptions& options,
           const std::function<bool()>& keep_going) {
  const auto start = Clock::now();
  const auto wall_us = [start] {
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - start).count());
  };
  EmulatedInstrument instrument(bench, wall_us);
  auto& board = instrument.board();
  instrument::TcpServer server(options.port, options.address);
  if (options.on_listening) options.on_listening(server.port());

  std::array<std::uint8_t, 4096> received{};
  std::vector<std::uint8_t> output;
  std::uint64_t client = 0;
  bool connected = false;
  while (keep_going()) {
    // A resting board waits for the host, or for its heartbeat to run out: look up each tick.
    const bool at_rest = board.resting() && output.empty();
    server.wait(std::chrono::microseconds(at_rest ? tick_us : 0));
    if (server.client_number() != client || server.has_client() != connected) {
      client = server.client_number();
      connected = server.has_client();
      output.clear();
      if (options.on_event) options.on_event(connected ? "host connected" : "host gone");
    }
    while (const std::size_t n = server.read(received)) {
      board.deliver(std::span(received).first(n));
    }
    if (options.real_time) {
      const std::uint64_t due = wall_us();
      if (due > board.now_us()) {
        board.run_for(due - board.now_us());
      } else if (!at_rest) {
        std::this_thread::sleep_for(std::chrono::microseconds(tick_us));
      }
    } else {
      board.run_for(board.resting() ? tick_us : slice_us);
    }
    board.take_output(output);
    if (!output.empty()) {
      const std::size_t sent = server.write(output);
      output.erase(output.begin(), output.begin() + static_cast<std::ptrdiff_t>(sent));
    }
  }
}

}  // namespace umov::emulator
