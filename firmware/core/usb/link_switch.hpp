// Which of the pipes the protocol runs on: bulk, reports, or the board's serial line. One host at a
// time owns the link: the first whose `hello` arrives, until it has been silent for a while or says
// that it leaves. A `hello` on another pipe is meanwhile answered with `busy` and the owner's name.
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

/// A line beside USB that carries the same protocol, for boards that have one.
class SerialLine {
 public:
  virtual std::size_t room() const = 0;
  /// Queues all of it; false if it does not fit now.
  virtual bool write(std::span<const std::uint8_t> bytes) = 0;

 protected:
  SerialLine() = default;
  SerialLine(const SerialLine&) = default;
  SerialLine& operator=(const SerialLine&) = default;
  ~SerialLine() = default;
};

class LinkSwitch {
 public:
  /// `serial` may be null.
  LinkSwitch(Port& port, Application& application, SerialLine* serial = nullptr)
      : application_(&application),
        serial_(serial),
        pipes_{LinkPipe(port, bulk_endpoints), LinkPipe(port, report_endpoints)} {}

  void start();
  void stop();
  void forget();
  /// Time, from anywhere, microseconds; moves what waits.
  void tick(std::uint64_t now_us) {
    now_us_ = now_us;
    send();
  }

  /// Whether a host owns the link.
  bool owned() const { return owner_ != Owner::nobody; }
  /// Bytes that can be written now; none while nobody owns the link.
  std::size_t room() const;
  /// False if the frame does not fit now or nobody is there to read it.
  bool write(std::span<const std::uint8_t> frame);
  /// Bytes that came over the serial line.
  void take_serial(std::span<const std::uint8_t> bytes);

  /// False when the endpoint is none of these pipes.
  bool on_sent(EndpointAddress address);
  bool on_received(EndpointAddress address, std::size_t size);
  void on_halt(EndpointAddress address);
  bool on_halt_cleared(EndpointAddress address);
  /// A packet for the report pipe that came through the control endpoint (SET_REPORT).
  void take_report(std::span<const std::uint8_t> bytes) { take(PipeKind::reports, bytes); }
  /// The host's program on a pipe has opened it or leaves it.
  void on_user(PipeKind kind, bool present);

 private:
  /// The first two in the order of PipeKind.
  enum class Owner : std::uint8_t { bulk, reports, serial, nobody };
  static constexpr Owner owner_of(PipeKind kind) { return static_cast<Owner>(kind); }

  LinkPipe* owning_pipe() {
    return owner_ < Owner::serial ? &pipes_[static_cast<std::size_t>(owner_)] : nullptr;
  }
  void send() {
    if (LinkPipe* pipe = owning_pipe()) pipe->send_from(ring_);
  }
  void take(PipeKind kind, std::span<const std::uint8_t> bytes);
  void take(Owner from, protocol::FrameReader& reader, std::span<const std::uint8_t> bytes);
  /// True when `from` owns the link after this frame.
  bool admit(Owner from, const protocol::FrameView& frame);
  /// To a host that does not own the link.
  template <class M>
  void answer(Owner from, std::uint16_t sequence, const M& message);
  void release();
  void release_usb();

  Application* application_;
  SerialLine* serial_;
  std::array<LinkPipe, 2> pipes_;
  protocol::FrameReader serial_reader_{};
  TransmitRing ring_{};
  Owner owner_ = Owner::nobody;
  protocol::Name owner_name_{};
  std::uint64_t heard_us_ = 0;
  std::uint64_t now_us_ = 0;
};

}  // namespace umov::firmware::usb
