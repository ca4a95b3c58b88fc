// A host at the emulated board's USB connector: transfers while virtual time passes, and the
// protocol over the bulk pipes.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hil/mcu/board/mcu_board.hpp"
#include "hil/usbip/bus.hpp"
#include "host/instrument/transport.hpp"
#include "protocol/usb.hpp"
#include "tests/unit/control_urb.hpp"

namespace umov::test {

using Bytes = std::vector<std::uint8_t>;

class UsbCable {
 public:
  explicit UsbCable(mcu::McuBoard& board)
      : board_(&board),
        bus_(board.usb(), [this](const usbip::Urb& urb, std::int32_t status, std::size_t moved) {
          ended_ = {urb.number, status, urb.to_host ? urb.bytes : Bytes{}, moved};
        }) {}

  struct Outcome {
    std::uint32_t number = 0;
    std::int32_t status = 1;  ///< 1: nothing but NAK
    Bytes bytes;
    std::size_t transferred = 0;
    bool ok() const { return status == usbip::urb_status::ok; }
  };

  /// The device is plugged in: reset on the bus, address, configuration.
  bool plug_in() {
    board_->usb().bus_reset();
    return control(0x00, 5, 7, 0, 0).ok() && control(0x00, 9, 1, 0, 0).ok();
  }
  Outcome control(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                  std::uint16_t length, Bytes data = {}) {
    return finish(control_urb({type, request, value, index, length}, std::move(data)), 100'000);
  }
  Outcome write(std::uint8_t endpoint, Bytes bytes) {
    usbip::Urb urb;
    urb.endpoint = endpoint & 0x0F;
    urb.length = bytes.size();
    urb.bytes = std::move(bytes);
    return finish(std::move(urb), 100'000);
  }
  Outcome read(std::uint8_t endpoint, std::size_t length, std::uint64_t max_us) {
    usbip::Urb urb;
    urb.endpoint = endpoint & 0x0F;
    urb.to_host = true;
    urb.length = length;
    return finish(std::move(urb), max_us);
  }

 private:
  /// About the time of a full packet on a full-speed bus.
  static constexpr std::uint64_t packet_us = 50;

  Outcome finish(usbip::Urb urb, std::uint64_t max_us) {
    urb.number = ++number_;
    ended_.reset();
    bus_.submit(std::move(urb));
    for (std::uint64_t gone = 0;; gone += packet_us) {
      bus_.run();
      if (ended_) return *ended_;
      if (gone >= max_us) break;
      board_->run_for(packet_us);
    }
    bus_.unlink(number_);
    return {};
  }

  mcu::McuBoard* board_;
  usbip::Bus bus_;
  std::optional<Outcome> ended_;
  std::uint32_t number_ = 0;
};

/// The protocol over the bulk pipes.
class BulkTransport final : public instrument::Transport {
 public:
  BulkTransport(mcu::McuBoard& board, UsbCable& cable) : board_(&board), cable_(&cable) {}
  void write(std::span<const std::uint8_t> bytes) override {
    cable_->write(protocol::usb::bulk_out, {bytes.begin(), bytes.end()});
  }
  std::size_t read(std::span<std::uint8_t> buffer, std::chrono::microseconds timeout) override {
    if (bytes_.empty()) {
      bytes_ = cable_
                   ->read(protocol::usb::bulk_in, 512,
                          static_cast<std::uint64_t>(std::max<std::int64_t>(timeout.count(), 1)))
                   .bytes;
    }
    const std::size_t n = std::min(buffer.size(), bytes_.size());
    std::copy_n(bytes_.begin(), n, buffer.begin());
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(n));
    return n;
  }
  std::uint64_t clock_us() override { return board_->now_us(); }
  std::string name() const override { return "emulated board on USB"; }

 private:
  mcu::McuBoard* board_;
  UsbCable* cable_;
  Bytes bytes_;
};

}  // namespace umov::test
