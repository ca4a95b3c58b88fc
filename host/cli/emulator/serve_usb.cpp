// The emulated instrument on a virtual USB cable.
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "hil/usbip/exported_device.hpp"
#include "hil/usbip/mcp2221.hpp"
#include "hil/usbip/server.hpp"
#include "host/cli/emulator/bench_lines.hpp"
#include "host/cli/emulator/emulated_instrument.hpp"
#include "host/cli/emulator/usb_instrument.hpp"

namespace umov::emulator {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;

/// Virtual time given to the board before the cable is looked at again.
constexpr std::uint64_t slice_us = 20'000;
constexpr std::uint64_t tick_us = 1'000;
constexpr std::chrono::seconds plug_in_again_after{1};
const std::string controller_bus_id = "1-1";
const std::string adapter_bus_id = "1-2";

/// The native board is a process: it has neither a ROM loader nor a reset.
class NativePins final : public BoardPins {
 public:
  explicit NativePins(std::function<void(const std::string&)> tell) : tell_(std::move(tell)) {}
  void set_boot0(bool high) override { boot0_ = high; }
  void set_nrst(bool high) override {
    if (!high && nrst_) {
      tell_(std::string("NRST is low, BOOT0 ") + (boot0_ ? "high" : "low") +
            "; this board can't be reset");
    }
    nrst_ = high;
  }

 private:
  std::function<void(const std::string&)> tell_;
  bool boot0_ = false;
  bool nrst_ = true;
};

}  // namespace

void serve_usb(const BenchOptions& bench, const UsbOptions& options,
               const std::function<bool()>& keep_going) {
  const auto start = Clock::now();
  const auto wall_us = [start] {
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<microseconds>(Clock::now() - start).count());
  };
  const auto tell = [&](const std::string& event) {
    if (options.on_event) options.on_event(event);
  };
  UsbInstrument usb(bench, wall_us, tell);
  NativePins pins(tell);
  BenchLines lines(usb.instrument().plant(), pins);
  usbip::Mcp2221 adapter(lines);
  std::vector<usbip::ExportedDevice> devices;
  devices.push_back(usbip::export_device(controller_bus_id, 2, usb.function()));
  if (options.gpio_adapter) {
    devices.push_back(usbip::export_device(adapter_bus_id, 3, adapter));
  }
  auto unplugged_since = start;
  usbip::Server server(devices, [&](const std::string& bus_id, bool plugged) {
    tell(bus_id + (plugged ? " plugged in" : " unplugged"));
    unplugged_since = Clock::now();
  });
  std::uint16_t port = 0;
  if (options.into_kernel) {
    for (const auto& device : devices) server.plug_into_kernel(device.bus_id);
  } else {
    port = server.listen(options.port, options.address);
  }
  if (options.on_ready) options.on_ready(port);

  auto& board = usb.instrument().board();
  while (keep_going()) {
    const bool at_rest = usb.at_rest();
    server.wait(microseconds(at_rest ? tick_us : 0));
    const bool served = server.service();
    if (options.real_time) {
      const std::uint64_t due = wall_us();
      if (due > board.now_us()) usb.run_for(due - board.now_us());
      if (!served && !at_rest) server.wait(microseconds(tick_us));
    } else {
      usb.run_for(board.resting() ? tick_us : slice_us);
    }
    server.service();
    if (options.into_kernel && Clock::now() - unplugged_since >= plug_in_again_after) {
      for (const auto& device : devices) {
        if (!server.plugged(device.bus_id)) server.plug_into_kernel(device.bus_id);
      }
    }
  }
}

}  // namespace umov::emulator
