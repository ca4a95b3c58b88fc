#include "firmware/core/usb/link_switch.hpp"

#include "protocol/codec.hpp"
#include "protocol/frame.hpp"

namespace umov::firmware::usb {

using protocol::FrameView;

void LinkSwitch::start() {
  release_usb();
  for (LinkPipe& pipe : pipes_) pipe.start();
}

void LinkSwitch::stop() {
  release_usb();
  for (LinkPipe& pipe : pipes_) pipe.stop();
}

void LinkSwitch::forget() {
  release_usb();
  for (LinkPipe& pipe : pipes_) pipe.forget();
}

void LinkSwitch::release() {
  owner_ = Owner::nobody;
  owner_name_ = {};
  ring_.clear();
}

/// What happens to the cable does not concern a host on the serial line.
void LinkSwitch::release_usb() {
  if (owner_ != Owner::serial) release();
}

std::size_t LinkSwitch::room() const {
  switch (owner_) {
    case Owner::nobody:
      return 0;
    case Owner::serial:
      return serial_->room();
    default:
      return ring_.room();
  }
}

bool LinkSwitch::write(std::span<const std::uint8_t> frame) {
  if (owner_ == Owner::nobody) return false;
  if (owner_ == Owner::serial) return serial_->write(frame);
  if (!ring_.push(frame)) return false;
  send();
  return true;
}

void LinkSwitch::take_serial(std::span<const std::uint8_t> bytes) {
  take(Owner::serial, serial_reader_, bytes);
}

bool LinkSwitch::on_sent(EndpointAddress address) {
  for (LinkPipe& pipe : pipes_) {
    if (pipe.endpoints().in != address) continue;
    pipe.on_sent();
    if (&pipe == owning_pipe()) send();
    return true;
  }
  return false;
}

bool LinkSwitch::on_received(EndpointAddress address, std::size_t size) {
  for (LinkPipe& pipe : pipes_) {
    if (pipe.endpoints().out != address) continue;
    take(&pipe == &pipes_[0] ? PipeKind::bulk : PipeKind::reports, pipe.received(size));
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
      if (&pipe == owning_pipe()) send();
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
  if (!present && owner_ == owner_of(kind)) release();
}

void LinkSwitch::take(PipeKind kind, std::span<const std::uint8_t> bytes) {
  take(owner_of(kind), pipes_[static_cast<std::size_t>(kind)].reader(), bytes);
}

void LinkSwitch::take(Owner from, protocol::FrameReader& reader,
                      std::span<const std::uint8_t> bytes) {
  // The owner's bytes go on as they are, looked at on the way; of another pipe a frame is taken at
  // a time, until one of them makes it the owner.
  bool owned = owner_ == from;
  if (owned) application_->on_link_bytes(bytes);
  FrameView frame;
  while (reader.next(bytes, frame)) {
    if (!admit(from, frame) || owned) continue;
    // From here on it is the owner: what led to it once more, then the rest as it is.
    std::array<std::uint8_t, protocol::max_wire_frame_size + 1> again{};
    const std::size_t size = protocol::FrameWriter::write_raw(
        frame.type, frame.sequence, frame.payload, std::span<std::uint8_t>(again).subspan(1));
    application_->on_link_bytes(std::span<const std::uint8_t>(again).first(size + 1));
    owned = owner_ == from;
    if (owned) application_->on_link_bytes(bytes);
  }
}

template <class M>
void LinkSwitch::answer(Owner from, std::uint16_t sequence, const M& message) {
  std::array<std::uint8_t, protocol::wire_frame_size<M>> bytes;
  const std::size_t size = protocol::FrameWriter::write(sequence, message, bytes);
  const auto frame = std::span<const std::uint8_t>(bytes).first(size);
  // A pipe that has no room now drops it: the host asks again.
  if (from == Owner::serial) {
    (void)serial_->write(frame);
  } else {
    (void)pipes_[static_cast<std::size_t>(from)].send_frame(frame);
  }
}

bool LinkSwitch::admit(Owner from, const FrameView& frame) {
  protocol::Hello hello;
  const bool greets =
      frame.type == protocol::Hello::info.id && protocol::decode(frame.payload, hello).ok();
  if (owner_ != from) {
    if (!greets) {
      // A host that was connected before the controller restarted: it must greet again.
      if (owner_ == Owner::nobody) {
        answer(from, frame.sequence,
               protocol::ErrorReply{
                   frame.type, static_cast<std::uint8_t>(protocol::Refusal::schema_mismatch), -1});
      }
      return false;
    }
    if (owner_ != Owner::nobody && now_us_ - heard_us_ < owner_silence_us) {
      answer(from, frame.sequence, protocol::Busy{owner_name_});
      return false;
    }
    release();
    owner_ = from;
  }
  if (greets) owner_name_ = hello.host_name;
  heard_us_ = now_us_;
  return true;
}

}  // namespace umov::firmware::usb
