#include "hil/usbip/bus.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace umov::usbip {

bool Bus::unlink(std::uint32_t number) {
  const auto found = std::find_if(waiting_.begin(), waiting_.end(),
                                  [&](const Urb& urb) { return urb.number == number; });
  if (found == waiting_.end()) return false;
  waiting_.erase(found);
  return true;
}

bool Bus::run() {
  bool any = false;
  for (bool moved = true; moved;) {
    moved = false;
    // Of each endpoint the oldest transfer only: they must end in order.
    std::set<std::pair<std::uint8_t, bool>> taken;
    for (auto urb = waiting_.begin(); urb != waiting_.end();) {
      const bool direction = urb->endpoint != 0 && urb->to_host;
      if (!taken.insert({urb->endpoint, direction}).second) {
        ++urb;
        continue;
      }
      const Step step = advance(*urb);
      moved = moved || step != Step::waits;
      urb = step == Step::ended ? waiting_.erase(urb) : std::next(urb);
    }
    any = any || moved;
  }
  return any;
}

Bus::Step Bus::end(const Urb& urb, std::int32_t status, std::size_t transferred) {
  done_(urb, status, transferred);
  return Step::ended;
}

Bus::Step Bus::fail(const Urb& urb, Handshake answer, std::size_t transferred) {
  return end(urb, answer == Handshake::stall ? urb_status::stalled : urb_status::protocol_error,
             transferred);
}

Bus::Step Bus::advance(Urb& urb) {
  if (urb.endpoint == 0) return advance_control(urb);
  return urb.to_host ? read(urb) : write(urb);
}

Bus::Step Bus::read(Urb& urb) {
  bool moved = false;
  for (;;) {
    Packet packet;
    const Handshake answer = function_->in(urb.endpoint, packet);
    if (answer == Handshake::nak) return moved ? Step::moved : Step::waits;
    if (answer != Handshake::ack) return fail(urb, answer, urb.bytes.size());
    if (urb.bytes.size() + packet.size > urb.length) {
      return end(urb, urb_status::overflow, urb.bytes.size());
    }
    urb.bytes.insert(urb.bytes.end(), packet.bytes.begin(),
                     packet.bytes.begin() + static_cast<std::ptrdiff_t>(packet.size));
    moved = true;
    if (packet.size < packet_bytes || urb.bytes.size() == urb.length) {
      return end(urb, urb_status::ok, urb.bytes.size());
    }
  }
}

Bus::Step Bus::write(Urb& urb) {
  bool moved = false;
  for (;;) {
    const std::size_t size = std::min(packet_bytes, urb.bytes.size() - urb.sent);
    const Handshake answer = function_->out(
        urb.endpoint, std::span<const std::uint8_t>(urb.bytes).subspan(urb.sent, size));
    if (answer == Handshake::nak) return moved ? Step::moved : Step::waits;
    if (answer != Handshake::ack) return fail(urb, answer, urb.sent);
    urb.sent += size;
    moved = true;
    const bool short_packet = size < packet_bytes;
    if (urb.sent == urb.bytes.size() && (short_packet || !urb.add_empty_packet)) {
      return end(urb, urb_status::ok, urb.sent);
    }
  }
}

Bus::Step Bus::advance_control(Urb& urb) {
  const bool reads = urb.to_host && urb.length > 0;
  if (urb.stage == Urb::Stage::setup) {
    if (function_->setup(urb.setup) != Handshake::ack) {
      return end(urb, urb_status::protocol_error, 0);
    }
    urb.stage = urb.length > 0 ? Urb::Stage::data : Urb::Stage::status;
  }
  bool moved = false;
  while (urb.stage == Urb::Stage::data) {
    Packet packet;
    Handshake answer;
    if (reads) {
      answer = function_->in(0, packet);
    } else {
      packet.size = std::min(packet_bytes, urb.bytes.size() - urb.sent);
      answer = function_->out(
          0, std::span<const std::uint8_t>(urb.bytes).subspan(urb.sent, packet.size));
    }
    const std::size_t so_far = reads ? urb.bytes.size() : urb.sent;
    if (answer == Handshake::nak) return moved ? Step::moved : Step::waits;
    if (answer != Handshake::ack) return fail(urb, answer, so_far);
    moved = true;
    if (reads) {
      if (so_far + packet.size > urb.length) return end(urb, urb_status::overflow, so_far);
      urb.bytes.insert(urb.bytes.end(), packet.bytes.begin(),
                       packet.bytes.begin() + static_cast<std::ptrdiff_t>(packet.size));
      if (packet.size < packet_bytes || urb.bytes.size() == urb.length) {
        urb.stage = Urb::Stage::status;
      }
    } else {
      urb.sent += packet.size;
      if (urb.sent == urb.bytes.size()) urb.stage = Urb::Stage::status;
    }
  }
  Packet packet;
  const Handshake answer = reads ? function_->out(0, {}) : function_->in(0, packet);
  const std::size_t transferred = urb.to_host ? urb.bytes.size() : urb.sent;
  if (answer == Handshake::nak) return moved ? Step::moved : Step::waits;
  if (answer != Handshake::ack) return fail(urb, answer, transferred);
  return end(urb, urb_status::ok, transferred);
}

}  // namespace umov::usbip
