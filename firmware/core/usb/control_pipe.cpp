#include "firmware/core/usb/control_pipe.hpp"

#include <algorithm>

namespace umov::firmware::usb {

void ControlPipe::on_setup(const SetupPacket& packet) {
  // A SETUP packet ends whatever was under way, without a word to anybody.
  request_ = parse_setup(packet);
  received_ = 0;
  to_send_ = {};
  room_ = {};
  stage_ = Stage::idle;
  const ControlAnswer answer = handler_->on_request(request_);
  const bool host_sends = !request_.to_host && request_.length > 0;
  switch (answer.kind) {
    case ControlAnswer::Kind::reply:
      if (host_sends || !request_.to_host) return refuse();
      to_send_ = answer.data.first(std::min<std::size_t>(answer.data.size(), request_.length));
      short_end_ = to_send_.size() < request_.length;
      break;
    case ControlAnswer::Kind::take:
      if (!host_sends || request_.length > answer.room.size()) return refuse();
      room_ = answer.room.first(request_.length);
      stage_ = Stage::data_out;
      return receive_next();
    case ControlAnswer::Kind::accept:
      if (request_.length > 0) return refuse();
      break;
    case ControlAnswer::Kind::refuse:
      return refuse();
  }
  if (request_.length == 0) {  // no data stage: the status goes to the host, whatever was asked
    stage_ = Stage::status_in;
    port_->send(control_in, {});
    return;
  }
  // The host may end the data stage when it likes, so the status stage is waited for from the
  // first packet on.
  stage_ = Stage::data_in;
  ended_ = false;
  port_->receive(control_out, {});
  send_next();
}

void ControlPipe::send_next() {
  const auto packet = to_send_.first(std::min(to_send_.size(), max_packet_bytes));
  to_send_ = to_send_.subspan(packet.size());
  // A reply that ends early ends with a short packet: after a full one that is an empty one.
  ended_ = to_send_.empty() && !(short_end_ && packet.size() == max_packet_bytes);
  port_->send(control_in, packet);
}

void ControlPipe::receive_next() {
  port_->receive(control_out, packet_);
}

void ControlPipe::on_sent() {
  switch (stage_) {
    case Stage::data_in:
      if (ended_) {
        stage_ = Stage::status_out;
      } else {
        send_next();
      }
      break;
    case Stage::status_in:
      end();
      break;
    default:
      break;  // of a transfer that is over
  }
}

void ControlPipe::on_received(std::size_t size) {
  switch (stage_) {
    case Stage::data_in:
    case Stage::status_out:
      // The status stage is an empty packet; data here is against the rules.
      if (size == 0) return end();
      refuse();
      break;
    case Stage::data_out: {
      const std::size_t left = room_.size() - received_;
      if (size > left) return refuse();
      std::copy_n(packet_.begin(), size, room_.begin() + static_cast<std::ptrdiff_t>(received_));
      received_ += size;
      if (received_ == room_.size()) {
        if (!handler_->on_data(request_, room_)) return refuse();
        stage_ = Stage::status_in;
        port_->send(control_in, {});
      } else if (size < max_packet_bytes) {
        refuse();  // less than was announced
      } else {
        receive_next();
      }
      break;
    }
    default:
      break;
  }
}

void ControlPipe::refuse() {
  stage_ = Stage::idle;
  port_->stall(control_in);
}

void ControlPipe::end() {
  stage_ = Stage::idle;
  handler_->on_complete(request_);
}

}  // namespace umov::firmware::usb
