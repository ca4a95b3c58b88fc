// A host gone mad: the input decides which transactions come in which order on the firmware's USB
// stack: SETUP packets whole or nearly right, data stages cut short or too long, resets and halts
// in mid transfer. The stack keeps the rules of its port (which throws where they are broken),
// never gives more than was asked for, and answers the next proper request.
//
// Now and then it meets the boot loader instead (mad_update.hpp).
//
// fuzz-link: umov_boot umov_usbip
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/core/usb/device.hpp"
#include "hil/usbip/stack_port.hpp"
#include "protocol/frame.hpp"
#include "protocol/messages.hpp"
#include "protocol/schema.hpp"
#include "tests/fuzz/foreign_bytes.hpp"
#include "tests/fuzz/mad_update.hpp"

namespace {

using namespace umov;
using usbip::Handshake;
using usbip::Packet;

class Quiet final : public firmware::usb::Application {
 public:
  void on_link_bytes(std::span<const std::uint8_t> bytes) override { heard += bytes.size(); }
  void on_hand_report(const firmware::usb::HandReport& report) override {
    fuzz::require(report.axis < protocol::axis_count);
  }
  firmware::usb::HandState hand_state(std::uint8_t axis) const override {
    fuzz::require(axis < protocol::axis_count);
    return {.axis = axis, .position_udeg = position};
  }
  bool detach_allowed() const override { return true; }
  void on_detach() override {}
  std::size_t heard = 0;
  std::int32_t position = 0;
};

class Input {
 public:
  explicit Input(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  bool empty() const { return bytes_.empty(); }
  std::uint8_t take() {
    if (bytes_.empty()) return 0;
    const std::uint8_t byte = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return byte;
  }
  std::vector<std::uint8_t> take(std::size_t size) {
    std::vector<std::uint8_t> out(size);
    for (auto& byte : out) byte = take();
    return out;
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

using Setup = std::array<std::uint8_t, 8>;
constexpr std::array<Setup, 16> proper = {{
    {0x80, 6, 0, 1, 0, 0, 18, 0},
    {0x80, 6, 0, 2, 0, 0, 255, 0},
    {0x80, 6, 3, 3, 9, 4, 255, 0},
    {0x80, 6, 0, 15, 0, 0, 255, 0},
    {0x81, 6, 0, 0x22, 1, 0, 255, 0},
    {0xc0, 1, 0, 0, 7, 0, 0, 2},
    {0x00, 9, 1, 0, 0, 0, 0, 0},
    {0x00, 5, 9, 0, 0, 0, 0, 0},
    {0x02, 3, 0, 0, 0x81, 0, 0, 0},
    {0x02, 1, 0, 0, 0x81, 0, 0, 0},
    {0x02, 3, 0, 0, 0x02, 0, 0, 0},
    {0x02, 1, 0, 0, 0x02, 0, 0, 0},
    {0x21, 9, 0, 2, 1, 0, 64, 0},
    {0x21, 9, 0, 2, 2, 0, 8, 0},
    {0x21, 0, 0, 0, 3, 0, 0, 0},
    {0x01, 11, 0, 0, 1, 0, 0, 0},
}};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input input({data, size});
  const std::uint8_t first = input.take();
  if ((first & 6) == 6) {
    fuzz::update_madly(input);
    return 0;
  }
  Quiet application;
  usbip::StackPort port;
  firmware::usb::Device device(port, application, {'F', 'U', 'Z', 'Z'});
  port.bind(device);
  device.start();
  port.bus_reset();
  std::size_t asked = 0;
  std::size_t given = 0;
  std::uint64_t now_us = 0;
  const auto setup = [&](const Setup& packet) {
    fuzz::require(port.setup(packet) == Handshake::ack);
    asked = (packet[0] & 0x80) != 0 ? static_cast<std::size_t>(packet[6] | (packet[7] << 8)) : 0;
    given = 0;
  };
  if ((first & 1) != 0) {
    setup(proper[6]);
    Packet status;
    fuzz::require(port.in(0, status) == Handshake::ack && status.size == 0);
  }
  while (!input.empty()) {
    const std::uint8_t what = input.take();
    const auto endpoint = static_cast<std::uint8_t>((what >> 4) & 3);
    Packet packet;
    switch (what & 15) {
      case 0: {
        Setup raw{};
        for (auto& byte : raw) byte = input.take();
        setup(raw);
        break;
      }
      case 1:
      case 2: {  // nearly right
        Setup packet_bytes = proper[input.take() % proper.size()];
        const std::uint8_t where = input.take();
        if ((what & 15) == 2) packet_bytes[where % 8] = input.take();
        setup(packet_bytes);
        break;
      }
      case 3:
        port.bus_reset();
        break;
      case 4:
        now_us += std::uint64_t{input.take()} << 14;
        application.position = input.take();
        device.tick(now_us);
        break;
      case 5: {
        const auto bytes = input.take(input.take());
        const bool fits = device.has_host() && bytes.size() <= device.link_room();
        fuzz::require(device.write_link(bytes) == fits);
        break;
      }
      case 6: {  // a host greets on one of the pipes
        protocol::Hello hello{protocol::protocol_version, protocol::schema_hash, {'h'}};
        std::array<std::uint8_t, 64> frame{};
        const auto length =
            protocol::FrameWriter::write(input.take(), hello, std::span(frame).subspan(1)) + 1;
        port.out(static_cast<std::uint8_t>(1 + (endpoint & 1)), std::span(frame).first(length));
        break;
      }
      case 7:
      case 8:
      case 9: {
        const auto bytes = input.take(input.take() % 65);
        port.out(endpoint, bytes);
        break;
      }
      default:
        if (port.in(endpoint, packet) == Handshake::ack && endpoint == 0) {
          given += packet.size;
          fuzz::require(given <= asked);
        }
    }
  }
  // Whatever it was: the next request is answered as if nothing had been.
  Packet packet;
  setup(proper[0]);
  fuzz::require(port.in(0, packet) == Handshake::ack && packet.size == 18);
  fuzz::require(port.out(0, {}) == Handshake::ack);
  return 0;
}
