// One pair of endpoints that carries the protocol's bytes: two bulk pipes, or HID reports.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/usb/descriptors.hpp"
#include "firmware/core/usb/port.hpp"
#include "firmware/core/usb/transmit_ring.hpp"
#include "protocol/frame.hpp"

namespace umov::firmware::usb {

struct LinkEndpoints {
  EndpointAddress in;
  EndpointAddress out;
  EndpointType type;
  /// Bytes of one transfer to the host; a report is always that long, padded with zeros (empty
  /// frames).
  std::size_t transfer_bytes;
  bool fixed_size;
};

inline constexpr LinkEndpoints bulk_endpoints = {bulk_in, bulk_out, EndpointType::bulk, 512, false};
inline constexpr LinkEndpoints report_endpoints = {reports_in, reports_out, EndpointType::interrupt,
                                                   report_bytes, true};

class LinkPipe {
 public:
  LinkPipe(Port& port, const LinkEndpoints& endpoints) : port_(&port), endpoints_(endpoints) {}

  const LinkEndpoints& endpoints() const { return endpoints_; }
  bool open() const { return open_; }

  /// The host has chosen the configuration (or the interface): both ends afresh.
  void start() {
    port_->open_endpoint(endpoints_.in, endpoints_.type, max_packet_bytes);
    port_->open_endpoint(endpoints_.out, endpoints_.type, max_packet_bytes);
    open_ = true;
    restart_in();
    restart_out();
  }
  void stop() {
    if (open_) {
      port_->close_endpoint(endpoints_.in);
      port_->close_endpoint(endpoints_.out);
    }
    forget();
  }
  /// Reset on the bus: the port has closed the endpoints.
  void forget() {
    open_ = false;
    sending_ = false;
    end_due_ = false;
    reader_.reset();
  }
  /// The host has halted the IN endpoint: what was under way is gone.
  void halt_in() { halted_in_ = true; }
  /// After the halt of an endpoint.
  void restart_in() {
    halted_in_ = false;
    sending_ = false;
    end_due_ = false;
  }
  void restart_out() {
    reader_.reset();
    port_->receive(endpoints_.out, received_);
  }

  bool can_send() const { return open_ && !sending_ && !halted_in_; }

  /// Starts a transfer with what `ring` holds, if the pipe is free.
  void send_from(TransmitRing& ring) {
    if (!can_send()) return;
    const std::size_t count =
        ring.pop(std::span<std::uint8_t>(staged_).first(endpoints_.transfer_bytes));
    send_staged(count);
  }
  /// Sends one frame past the ring; false when the pipe is busy. For hosts that don't own the link.
  bool send_frame(std::span<const std::uint8_t> frame) {
    if (!can_send() || endpoints_.transfer_bytes < frame.size()) return false;
    std::copy(frame.begin(), frame.end(), staged_.begin());
    send_staged(frame.size());
    return true;
  }
  void on_sent() { sending_ = false; }

  std::span<const std::uint8_t> received(std::size_t size) const {
    return std::span<const std::uint8_t>(received_).first(std::min(size, received_.size()));
  }
  /// Takes the next packet; what was received before is overwritten.
  void receive_next() {
    if (open_) port_->receive(endpoints_.out, received_);
  }

  protocol::FrameReader& reader() { return reader_; }

 private:
  void send_staged(std::size_t count) {
    if (count == 0) {
      // The host reads in large transfers: one that ended with a full packet is ended by an empty
      // one when nothing follows.
      if (!end_due_) return;
      end_due_ = false;
      sending_ = true;
      port_->send(endpoints_.in, {});
      return;
    }
    if (endpoints_.fixed_size) {
      std::fill(staged_.begin() + static_cast<std::ptrdiff_t>(count),
                staged_.begin() + static_cast<std::ptrdiff_t>(endpoints_.transfer_bytes),
                std::uint8_t{0});
      count = endpoints_.transfer_bytes;
    } else {
      end_due_ = count % max_packet_bytes == 0;
    }
    sending_ = true;
    port_->send(endpoints_.in, std::span<const std::uint8_t>(staged_).first(count));
  }

  Port* port_;
  LinkEndpoints endpoints_;
  bool open_ = false;
  bool sending_ = false;
  bool halted_in_ = false;
  bool end_due_ = false;
  protocol::FrameReader reader_{};
  // One packet at a time: a host may stop after any packet and wait for the answer.
  std::array<std::uint8_t, max_packet_bytes> received_{};
  std::array<std::uint8_t, bulk_endpoints.transfer_bytes> staged_{};
};

}  // namespace umov::firmware::usb
