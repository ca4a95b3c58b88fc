// Which of the two pipes the protocol runs on. One host at a time owns the link: the first whose
// `hello` arrives, until it has been silent for a while or says that it leaves. A `hello` on the
// other pipe is meanwhile answered with `busy` and the owner's name.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/core/usb/application.hpp"
#include "firmware/core/usb/link_pipe.hpp"
#include "firmware/core/usb/transmit_ring.hpp"
#include "protocol/messages.hpp"

namespace umov::firmware::usb {

/// An owner that sends no good frame for this long has gone: three times the interval at which a
/// host must say something (PROTOCOL.md, Session 7).
inline constexpr std::uint64_t owner_silence_us = 1'500'000;

enum class PipeKind : std::uint8_t { bulk, reports };

class LinkSwitch {
 public:
  LinkSwitch(Port& port, Application& application)
      : application_(&application),
        pipes_{LinkPipe(port, bulk_endpoints), LinkPipe(port, report_endpoints)} {}

  void start();
  void stop();
  void forget();
  /// Time, from anywhere, microseconds; moves what waits.
  void tick(std::uint64_t now_us) {
    now_us_ = now_us;
    send();
  }

  /// Bytes that can be written now. While nobody owns the link they are taken and dropped, like
  /// those on a cable that is not plugged in.
  std::size_t room() const { return ring_.room(); }
  bool write(std::span<const std::uint8_t> frame);

  /// False when the endpoint is none of these pipes.
  bool on_sent(EndpointAddress address);
  bool on_received(EndpointAddress address, std::size_t size);
  void on_halt(EndpointAddress address);
  bool on_halt_cleared(EndpointAddress address);
  /// A packet for the report pipe that came through the control endpoint (SET_REPORT).
  void take_report(std::span<const std::uint8_t> bytes) { take(pipes_[1], bytes); }
  /// The host's program on a pipe has opened it or leaves it.
  void on_user(PipeKind kind, bool present);

 private:
  void send() {
    if (owner_ != nullptr) owner_->send_from(ring_);
  }
  void take(LinkPipe& pipe, std::span<const std::uint8_t> bytes);
  /// True when the pipe owns the link after this frame.
  bool admit(LinkPipe& pipe, const protocol::FrameView& frame);
  void release();

  Application* application_;
  std::array<LinkPipe, 2> pipes_;
  TransmitRing ring_{};
  LinkPipe* owner_ = nullptr;
  protocol::Name owner_name_{};
  std::uint64_t heard_us_ = 0;
  std::uint64_t now_us_ = 0;
};

}  // namespace umov::firmware::usb
