// The emulated board at a virtual USB cable.
#include <algorithm>
#include <chrono>
#include <vector>

#include "hil/usbip/exported_device.hpp"
#include "hil/usbip/mcp2221.hpp"
#include "hil/usbip/server.hpp"
#include "host/cli/emulator/bench_lines.hpp"
#include "host/cli/emulator/mcu/debugger_port.hpp"
#include "host/cli/emulator/mcu/mcu_instrument.hpp"
#include "host/cli/emulator/mcu/mcu_pins.hpp"
#include "host/cli/emulator/mcu/serve_image.hpp"

namespace umov::emulator {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;

constexpr std::uint64_t slice_us = 500;
constexpr std::uint64_t backlog_us = 100'000;
constexpr std::uint64_t start_up_us = 50'000;
/// A boot loader may have to end an update first.
constexpr std::uint64_t longest_start_us = 20'000'000;
/// From the pull-up to the host's first reset.
constexpr std::uint64_t settle_us = 5'000;
constexpr std::chrono::seconds plug_in_again_after{1};
const std::string controller_bus_id = "1-1";
const std::string adapter_bus_id = "1-2";

/// The board's connector for a host that does not come back after a NAK: while `patient`, the board
/// is given time until it has an answer.
class PatientConnector final : public usbip::UsbFunction {
 public:
  explicit PatientConnector(mcu::McuBoard& board) : board_(&board) {}
  bool patient = true;

  void bus_reset() override { board_->usb().bus_reset(); }
  usbip::Handshake setup(const std::array<std::uint8_t, 8>& packet) override {
    return board_->usb().setup(packet);
  }
  usbip::Handshake out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override {
    return answered([&] { return board_->usb().out(endpoint, bytes); });
  }
  usbip::Handshake in(std::uint8_t endpoint, usbip::Packet& packet) override {
    return answered([&] { return board_->usb().in(endpoint, packet); });
  }

 private:
  template <class Transaction>
  usbip::Handshake answered(Transaction&& transaction) {
    constexpr int tries = 200;
    usbip::Handshake answer = transaction();
    for (int i = 0; patient && answer == usbip::Handshake::nak && i < tries; ++i) {
      board_->run_for(50);
      answer = transaction();
    }
    return answer;
  }

  mcu::McuBoard* board_;
};

}  // namespace

void serve_image_usb(const BenchOptions& bench, const BoardFiles& files, const UsbOptions& options,
                     const std::function<bool()>& keep_going) {
  McuInstrument instrument(bench, {.image = files.image, .boot_loader = files.boot_loader});
  auto& board = instrument.board();
  const auto tell = [&](const std::string& event) {
    if (options.on_event) options.on_event(event);
  };
  for (std::uint64_t gone = 0; gone < longest_start_us && !board.usb_connected();
       gone += start_up_us) {
    board.run_for(start_up_us);
  }
  PatientConnector connector(board);
  auto unplugged_since = Clock::now();
  McuPins pins(board.chip());
  BenchLines lines(instrument.plant(), pins);
  usbip::Mcp2221 adapter(lines);
  std::vector<usbip::ExportedDevice> devices;
  devices.push_back(usbip::export_device(controller_bus_id, 2, connector));
  if (options.gpio_adapter) devices.push_back(usbip::export_device(adapter_bus_id, 3, adapter));
  usbip::Server server(devices, [&](const std::string& bus_id, bool plugged) {
    tell(bus_id + (plugged ? " plugged in" : " unplugged"));
    unplugged_since = Clock::now();
  });
  connector.patient = false;
  bool shown = true;
  std::uint16_t port = 0;
  if (options.into_kernel) {
    for (const auto& device : devices) server.plug_into_kernel(device.bus_id);
  } else {
    port = server.listen(options.port, options.address);
  }
  DebuggerPort debugger(board.chip(), options.gdb_port, options.on_gdb);
  if (options.on_ready) options.on_ready(port);

  const auto start = Clock::now();
  const std::uint64_t begin_us = board.now_us();
  std::uint64_t lost_us = 0;
  while (keep_going()) {
    const auto wall_us = static_cast<std::uint64_t>(
        std::chrono::duration_cast<microseconds>(Clock::now() - start).count());
    const std::uint64_t due = begin_us + wall_us - lost_us;
    const bool behind = due > board.now_us();
    if (behind && due - board.now_us() > backlog_us) lost_us += due - board.now_us() - backlog_us;
    server.wait(microseconds(behind ? 0 : slice_us));
    server.service();
    debugger.service();
    if (behind) board.run_for(std::min(slice_us, due - board.now_us()));
    server.service();
    // Reset by its pin, the board takes itself off the bus.
    if (pins.take_reset()) server.unplug(controller_bus_id);
    if (shown != board.usb_connected()) {
      shown = !shown;
      if (!shown) {
        server.unplug(controller_bus_id);
      } else {
        board.run_for(settle_us);
        connector.patient = true;
        server.replace(usbip::export_device(controller_bus_id, 2, connector));
        connector.patient = false;
        if (options.into_kernel) server.plug_into_kernel(controller_bus_id);
      }
    }
    if (options.into_kernel && shown && !server.plugged(controller_bus_id) &&
        Clock::now() - unplugged_since >= plug_in_again_after) {
      server.plug_into_kernel(controller_bus_id);
    }
  }
}

}  // namespace umov::emulator
