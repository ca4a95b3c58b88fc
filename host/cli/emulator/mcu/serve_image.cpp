#include "host/cli/emulator/mcu/serve_image.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <vector>

#include "host/cli/emulator/mcu/debugger_port.hpp"
#include "host/cli/emulator/mcu/mcu_instrument.hpp"
#include "host/instrument/tcp_server.hpp"

namespace umov::emulator {
namespace {

using Clock = std::chrono::steady_clock;

/// Virtual time given to the board before the network is looked at again.
constexpr std::uint64_t slice_us = 5'000;
/// A board that fell further behind than this does not catch up: time lost is lost.
constexpr std::uint64_t backlog_us = 100'000;

}  // namespace

void serve_image(const BenchOptions& bench, const BoardFiles& files, const ServeOptions& options,
                 const std::function<bool()>& keep_going) {
  McuInstrument instrument(bench, {.image = files.image, .boot_loader = files.boot_loader});
  auto& board = instrument.board();
  instrument::TcpServer server(options.port, options.address);
  DebuggerPort debugger(board.chip(), options.gdb_port, options.on_gdb);
  if (options.on_listening) options.on_listening(server.port());

  const auto start = Clock::now();
  std::uint64_t lost_us = 0;
  std::array<std::uint8_t, 4096> received{};
  std::vector<std::uint8_t> output;
  std::uint64_t client = 0;
  bool connected = false;
  while (keep_going()) {
    const auto wall_us = static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - start).count());
    const std::uint64_t due = wall_us - lost_us;
    const bool behind = due > board.now_us();
    if (behind && due - board.now_us() > backlog_us) lost_us += due - board.now_us() - backlog_us;
    server.wait(std::chrono::microseconds(behind || !output.empty() ? 0 : 1'000));
    if (server.client_number() != client || server.has_client() != connected) {
      client = server.client_number();
      connected = server.has_client();
      output.clear();
      if (options.on_event) options.on_event(connected ? "host connected" : "host gone");
    }
    debugger.service();
    while (const std::size_t n = server.read(received)) {
      board.deliver(std::span(received).first(n));
    }
    if (behind) board.run_for(std::min(slice_us, due - board.now_us()));
    board.take_output(output);
    if (!output.empty()) {
      const std::size_t sent = server.write(output);
      output.erase(output.begin(), output.begin() + static_cast<std::ptrdiff_t>(sent));
    }
  }
}

}  // namespace umov::emulator
