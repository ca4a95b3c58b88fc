#include "hil/usbip/stack_port.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace umov::usbip {
namespace {

using firmware::usb::EndpointAddress;
using firmware::usb::is_in;

void require(bool good, const char* rule, EndpointAddress address) {
  if (good) return;
  throw std::logic_error("USB stack, endpoint " + std::to_string(address) + ": " + rule);
}

}  // namespace

StackPort::Endpoint& StackPort::endpoint(EndpointAddress address) {
  const std::size_t number = firmware::usb::endpoint_number(address);
  return is_in(address) ? in_[number] : out_[number];
}

void StackPort::open_endpoint(EndpointAddress address, firmware::usb::EndpointType type,
                              std::uint16_t max_packet) {
  require(firmware::usb::endpoint_number(address) != 0, "endpoint 0 is always open", address);
  require(
      type != firmware::usb::EndpointType::control && max_packet > 0 && max_packet <= packet_bytes,
      "no endpoint of full speed", address);
  Endpoint& e = endpoint(address);
  e.abandon();
  e.open = true;
  e.halted = false;
  e.max_packet = max_packet;
}

void StackPort::close_endpoint(EndpointAddress address) {
  require(endpoint(address).open, "closed, but not open", address);
  endpoint(address).abandon();
  endpoint(address).open = false;
}

void StackPort::send(EndpointAddress address, std::span<const std::uint8_t> bytes) {
  Endpoint& e = endpoint(address);
  require(is_in(address), "sends on an OUT endpoint", address);
  require(e.open, "sends on a closed endpoint", address);
  require(!e.halted, "sends on a halted endpoint", address);
  require(!e.sending, "sends while sending", address);
  require(address != firmware::usb::control_in || bytes.size() <= packet_bytes,
          "more than a packet on endpoint 0", address);
  e.sending = bytes;
}

void StackPort::receive(EndpointAddress address, std::span<std::uint8_t> buffer) {
  Endpoint& e = endpoint(address);
  require(!is_in(address), "receives on an IN endpoint", address);
  require(e.open, "receives on a closed endpoint", address);
  require(!e.halted, "receives on a halted endpoint", address);
  require(!e.receiving, "receives while receiving", address);
  const bool status_stage = address == firmware::usb::control_out && buffer.empty();
  require(status_stage || (!buffer.empty() && buffer.size() % e.max_packet == 0),
          "the buffer is no multiple of the packet size", address);
  e.receiving = buffer;
  e.received = 0;
}

void StackPort::stall(EndpointAddress address) {
  require(endpoint(address).open, "stalls a closed endpoint", address);
  const bool control = firmware::usb::endpoint_number(address) == 0;
  for (Endpoint* e :
       {control ? &in_[0] : &endpoint(address), control ? &out_[0] : &endpoint(address)}) {
    e->abandon();
    e->halted = true;
  }
}

void StackPort::clear_stall(EndpointAddress address) {
  require(firmware::usb::endpoint_number(address) != 0, "endpoint 0 ends its stall by itself",
          address);
  require(endpoint(address).open, "clears the halt of a closed endpoint", address);
  endpoint(address).abandon();
  endpoint(address).halted = false;
}

void StackPort::bus_reset() {
  in_ = {};
  out_ = {};
  in_[0].open = true;
  out_[0].open = true;
  address_ = 0;
  events_->on_reset();
}

Handshake StackPort::setup(const std::array<std::uint8_t, 8>& packet) {
  if (!connected_ || !in_[0].open) return Handshake::none;
  for (Endpoint* e : {&in_[0], &out_[0]}) {
    e->abandon();
    e->halted = false;
  }
  events_->on_setup(packet);
  return Handshake::ack;
}

Handshake StackPort::out(std::uint8_t number, std::span<const std::uint8_t> bytes) {
  if (!connected_ || number >= endpoint_count || !out_[number].open) return Handshake::none;
  Endpoint& e = out_[number];
  if (bytes.size() > e.max_packet) return Handshake::none;
  if (e.halted) return Handshake::stall;
  if (!e.receiving) return Handshake::nak;
  const std::size_t room = e.receiving->size() - e.received;
  // A controller that has been given no room for data answers a status stage with data by STALL.
  if (bytes.size() > room) return Handshake::stall;
  std::copy(bytes.begin(), bytes.end(),
            e.receiving->begin() + static_cast<std::ptrdiff_t>(e.received));
  e.received += bytes.size();
  if (bytes.size() < e.max_packet || e.received == e.receiving->size()) {
    const std::size_t received = e.received;
    e.abandon();
    events_->on_received(number, received);
  }
  return Handshake::ack;
}

Handshake StackPort::in(std::uint8_t number, Packet& packet) {
  if (!connected_ || number >= endpoint_count || !in_[number].open) return Handshake::none;
  Endpoint& e = in_[number];
  if (e.halted) return Handshake::stall;
  if (!e.sending) return Handshake::nak;
  packet.size = std::min(e.sending->size(), e.max_packet);
  std::copy_n(e.sending->begin(), packet.size, packet.bytes.begin());
  *e.sending = e.sending->subspan(packet.size);
  if (e.sending->empty()) {
    e.sending.reset();
    events_->on_sent(static_cast<EndpointAddress>(number | firmware::usb::direction_in));
  }
  return Handshake::ack;
}

}  // namespace umov::usbip
