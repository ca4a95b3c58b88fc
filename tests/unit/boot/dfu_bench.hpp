// A boot loader on a desk: the device's half on a bus of software, the host's half above it.
#pragma once

#include <functional>
#include <memory>

#include "firmware/boot/boot_device.hpp"
#include "hil/usbip/bus.hpp"
#include "hil/usbip/stack_port.hpp"
#include "host/instrument/dfu_client.hpp"
#include "tests/unit/boot/boot_bench.hpp"
#include "tests/unit/control_urb.hpp"

namespace umov::test {

/// One session of DFU mode. The device works while the host waits, one piece in 5 ms.
class DfuBench final : public instrument::DfuPipe {
 public:
  DfuBench(RamFlash& flash, const boot::Trust& trust, boot::Reason why = boot::Reason::none)
      : device(port, flash, trust, {'T', '1'}, true, why) {
    port.bind(device);
    device.start();
    port.bus_reset();
    control(0x00, 9, 1, 0, {});  // SET_CONFIGURATION
  }

  struct Outcome {
    std::int32_t status = 1;  ///< 1: nothing but NAK
    Bytes bytes;
  };
  Outcome control(std::uint8_t type, std::uint8_t request, std::uint16_t value,
                  std::uint16_t length, Bytes data, std::uint16_t index = 0) {
    Outcome outcome;
    usbip::Bus bus(port, [&](const usbip::Urb& done, std::int32_t status, std::size_t) {
      outcome = {status, done.to_host ? done.bytes : Bytes{}};
    });
    bus.submit(control_urb({type, request, value, index, length}, std::move(data)));
    bus.run();
    return outcome;
  }

  // instrument::DfuPipe
  Answer read(std::uint8_t request, std::uint16_t value, std::size_t length) override {
    const auto got = control(0xA1, request, value, static_cast<std::uint16_t>(length), {});
    return {got.status == 0, got.bytes};
  }
  bool write(std::uint8_t request, std::uint16_t value,
             std::span<const std::uint8_t> bytes) override {
    return control(0x21, request, value, static_cast<std::uint16_t>(bytes.size()),
                   {bytes.begin(), bytes.end()})
               .status == 0;
  }
  void wait(std::chrono::milliseconds duration) override {
    waited += duration;
    for (int i = 0; i < duration.count(); i += 5) {
      if (between_pieces && device.working()) between_pieces();
      device.work();
    }
  }
  std::string text(std::uint8_t index) override {
    const auto got = control(0x80, 6, static_cast<std::uint16_t>(0x0300 | index), 255, {}, 0x409);
    std::string ascii;
    for (std::size_t i = 2; i < got.bytes.size(); i += 2)
      ascii.push_back(static_cast<char>(got.bytes[i]));
    return ascii;
  }
  std::string name() const override { return "boot loader on a desk"; }

  usbip::StackPort port;
  boot::BootDevice device;
  std::chrono::milliseconds waited{0};
  std::function<void()> between_pieces;  ///< before each piece of work
};

}  // namespace umov::test
