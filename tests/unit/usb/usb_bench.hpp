// The firmware's USB stack on a desk: a bus and a host below it, an application above it.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/core/usb/device.hpp"
#include "hil/usbip/bus.hpp"
#include "hil/usbip/stack_port.hpp"
#include "protocol/frame.hpp"
#include "protocol/messages.hpp"
#include "protocol/schema.hpp"
#include "tests/unit/control_urb.hpp"

namespace umov::test {

namespace fu = umov::firmware::usb;
using Bytes = std::vector<std::uint8_t>;

/// Remembers what the stack tells it.
class Recorder final : public fu::Application {
 public:
  void on_link_bytes(std::span<const std::uint8_t> bytes) override {
    received.insert(received.end(), bytes.begin(), bytes.end());
  }
  void on_hand_report(const fu::HandReport& report) override { hand_reports.push_back(report); }
  fu::HandState hand_state(std::uint8_t axis) const override {
    fu::HandState now = state;
    now.axis = axis;
    return now;
  }
  bool detach_allowed() const override { return may_detach; }
  void on_detach() override { ++detaches; }

  Bytes received;
  std::vector<fu::HandReport> hand_reports;
  fu::HandState state{};
  int detaches = 0;
  bool may_detach = true;
};

struct Outcome {
  std::int32_t status = -1;
  Bytes bytes;
  std::size_t transferred = 0;
  bool stalled() const { return status == usbip::urb_status::stalled; }
  bool ok() const { return status == usbip::urb_status::ok; }
};

inline std::array<char, 24> serial_text(const std::string& text) {
  std::array<char, 24> out{};
  for (std::size_t i = 0; i < text.size() && i < out.size(); ++i) out[i] = text[i];
  return out;
}

class UsbBench {
 public:
  explicit UsbBench(const std::string& serial = "TEST-1", fu::SerialLine* line = nullptr)
      : device(port, application, serial_text(serial), line) {
    port.bind(device);
    device.start();
    port.bus_reset();
  }

  /// One control transfer from beginning to end.
  Outcome control(const SetupFields& setup, const Bytes& data = {}) {
    return finish(control_urb(setup, data));
  }
  /// Reads up to `length` bytes; nothing when the endpoint has nothing to say.
  std::optional<Outcome> read(std::uint8_t endpoint, std::size_t length) {
    usbip::Urb urb;
    urb.endpoint = endpoint;
    urb.to_host = true;
    urb.length = length;
    const Outcome outcome = finish(std::move(urb));
    if (outcome.status == pending) return std::nullopt;
    return outcome;
  }
  Outcome write(std::uint8_t endpoint, Bytes bytes) {
    usbip::Urb urb;
    urb.endpoint = endpoint;
    urb.length = bytes.size();
    urb.bytes = std::move(bytes);
    return finish(std::move(urb));
  }
  Outcome configure(std::uint16_t value = 1) { return control({0x00, 9, value, 0, 0}); }

  static constexpr std::int32_t pending = 1;  ///< every endpoint answered NAK

  Recorder application;
  usbip::StackPort port;
  fu::Device device;

 private:
  Outcome finish(usbip::Urb urb) {
    Outcome outcome;
    outcome.status = pending;
    usbip::Bus bus(port, [&](const usbip::Urb& done, std::int32_t status, std::size_t count) {
      outcome = {status, done.to_host ? done.bytes : Bytes{}, count};
    });
    bus.submit(std::move(urb));
    bus.run();
    return outcome;
  }
};

/// A frame with the delimiter before it that a host sends first.
inline Bytes hello_frame(const std::string& host, std::uint16_t sequence = 1) {
  protocol::Hello hello{protocol::protocol_version, protocol::schema_hash, {}};
  for (std::size_t i = 0; i < host.size() && i < hello.host_name.size(); ++i) {
    hello.host_name[i] = host[i];
  }
  Bytes frame(1 + protocol::max_wire_frame_size);
  const std::size_t size =
      protocol::FrameWriter::write(sequence, hello, std::span(frame).subspan(1));
  frame.resize(1 + size);
  return frame;
}

/// Types of the good frames in `bytes`.
inline std::vector<std::uint8_t> frame_types(const Bytes& bytes) {
  protocol::FrameReader reader;
  std::vector<std::uint8_t> types;
  reader.feed(bytes, [&](const protocol::FrameView& frame) { types.push_back(frame.type); });
  return types;
}

/// Bytes that are not 0, so that they are told apart from padding.
inline Bytes counting_bytes(std::size_t size, std::uint8_t first = 1) {
  Bytes bytes(size);
  std::uint8_t next = first;
  for (auto& byte : bytes) {
    byte = next;
    next = next == 255 ? 1 : static_cast<std::uint8_t>(next + 1);
  }
  return bytes;
}

}  // namespace umov::test
