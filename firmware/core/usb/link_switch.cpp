#include "firmware/core/usb/link_switch.hpp"

#include "protocol/codec.hpp"
#include "protocol/frame.hpp"

namespace umov::firmware::usb {

using protocol::FrameView;

void LinkSwitch::start() {
  release();
  for (LinkPipe& pipe : pipes_) pipe.start();
}

void LinkSwitch::stop() {
  release();
  for (LinkPipe& pipe : pipes_) pipe.stop();
}

void LinkSwitch::forget() {
  release();
  for (LinkPipe& pipe : pipes_) pipe.forget();
}

void LinkSwitch::release() {
  owner_ = nullptr;
  owner_name_ = {};
  ring_.clear();
}

bool LinkSwitch::write(std::span<const std::uint8_t> frame) {
  if (owner_ == nullptr) return true;
  if (!ring_.push(frame)) return false;
  send();
  return true;
}

bool LinkSwitch::on_sent(EndpointAddress address) {
  for (LinkPipe& pipe : pipes_) {
    if (pipe.endpoints().in != address) continue;
    pipe.on_sent();
    if (&pipe == owner_) send();
    return true;
  }
  return false;
}

bool LinkSwitch::on_received(EndpointAddress address, std::size_t size) {
  for (LinkPipe& pipe : pipes_) {
    if (pipe.endpoints().out != address) continue;
    take(pipe, pipe.received(size));
    pipe.receive_next();
    return true;
  }
  return false;
}

void LinkSwitch::on_halt(EndpointAddress address) {
  for (LinkPipe& pipe : pipes_) {
    if (pipe.endpoints().in == address) pipe.halt_in();
  }
}

bool LinkSwitch::on_halt_cleared(EndpointAddress address) {
  for (LinkPipe& pipe : pipes_) {
    if (!pipe.open()) continue;
    if (pipe.endpoints().in == address) {
      pipe.restart_in();
      if (&pipe == owner_) send();
      return true;
    }
    if (pipe.endpoints().out == address) {
      pipe.restart_out();
      return true;
    }
  }
  return false;
}

void LinkSwitch::on_user(PipeKind kind, bool present) {
  if (!present && owner_ == &pipes_[static_cast<std::size_t>(kind)]) release();
}

void LinkSwitch::take(LinkPipe& pipe, std::span<const std::uint8_t> bytes) {
  // The owner's bytes go on as they are, looked at on the way; of another pipe a frame is taken at
  // a time, until one of them makes it the owner.
  bool owned = owner_ == &pipe;
  if (owned) application_->on_link_bytes(bytes);
  FrameView frame;
  while (pipe.reader().next(bytes, frame)) {
    if (!admit(pipe, frame) || owned) continue;
    // From here on it is the owner: what led to it once more, then the rest as it is.
    std::array<std::uint8_t, protocol::max_wire_frame_size + 1> again{};
    const std::size_t size = protocol::FrameWriter::write_raw(
        frame.type, frame.sequence, frame.payload, std::span<std::uint8_t>(again).subspan(1));
    application_->on_link_bytes(std::span<const std::uint8_t>(again).first(size + 1));
    owned = owner_ == &pipe;
    if (owned) application_->on_link_bytes(bytes);
  }
}

bool LinkSwitch::admit(LinkPipe& pipe, const FrameView& frame) {
  protocol::Hello hello;
  const bool greets =
      frame.type == protocol::Hello::info.id && protocol::decode(frame.payload, hello).ok();
  const bool owned = owner_ == &pipe;
  if (!owned) {
    if (!greets) return false;
    if (owner_ != nullptr && now_us_ - heard_us_ < owner_silence_us) {
      std::array<std::uint8_t, protocol::wire_frame_size<protocol::Busy>> answer;
      const std::size_t size =
          protocol::FrameWriter::write(frame.sequence, protocol::Busy{owner_name_}, answer);
      pipe.send_frame(std::span<const std::uint8_t>(answer).first(size));
      return false;
    }
    release();
    owner_ = &pipe;
  }
  if (greets) owner_name_ = hello.host_name;
  heard_us_ = now_us_;
  return true;
}

}  // namespace umov::firmware::usb
