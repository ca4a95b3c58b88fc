// A conversation with a controller: handshake, requests and replies, events, heartbeat, clock.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host/instrument/clock_sync.hpp"
#include "host/instrument/transport.hpp"
#include "protocol/codec.hpp"
#include "protocol/frame.hpp"
#include "protocol/messages.hpp"
#include "protocol/requests.hpp"

namespace umov::instrument {

/// All times are in the clock of the transport, which may be virtual.
struct SessionOptions {
  std::string host_name;  ///< shown to whoever finds the device busy; empty = this machine's name
  std::chrono::milliseconds answer_timeout{500};   ///< for one attempt
  int attempts = 6;                                ///< of a request that may be repeated
  std::chrono::milliseconds heartbeat{400};        ///< silence after which get_status is sent
  int clock_round_trips = 8;                       ///< made when the session opens
  std::chrono::milliseconds clock_interval{5000};  ///< between further ones
};

/// A refusal of a streamed message (program_row, record_ack).
struct StreamRefusal {
  std::uint16_t sequence = 0;  ///< what Session::send returned for the message refused
  protocol::ErrorReply reply{};
};

/// Answer to a heartbeat.
struct Heartbeat {
  std::uint16_t sequence = 0;
  protocol::Status status{};
};

/// What the device says of its own accord, and answers to heartbeats and streamed messages.
using Event = std::variant<protocol::RowCredit, protocol::Record, protocol::FaultEvent, Heartbeat,
                           StreamRefusal>;

/// Owns the transport. Not thread-safe. Everything may throw LinkLost.
class Session {
 public:
  /// Shakes hands. Throws LinkLost when nobody answers, umov::Error when the other end speaks
  /// another schema (both are named) or serves another host (who is named if known).
  explicit Session(std::unique_ptr<Transport> transport, SessionOptions options = {});
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Who answered, and the scales of its numbers.
  const protocol::HelloReply& device() const { return device_; }
  std::string name() const { return transport_->name(); }
  /// Host clock that belongs to this pipe, microseconds.
  std::uint64_t clock_us() const { return transport_->clock_us(); }

  /// Sends a request and waits for its reply; events that arrive meanwhile are kept.
  /// Repeats it only when protocol::AnswerTo<M>::repeatable. Throws Refused when the device refuses
  /// it, Unanswered when no answer came to a request that must not be repeated, LinkLost when none
  /// came to several attempts, umov::Error when a field is out of range (nothing is sent).
  template <protocol::Request M>
  protocol::ReplyTo<M> request(const M& message);

  /// Sends a message that is not answered (program_row, record_ack); returns its sequence number.
  /// Throws umov::Error when a field is out of range.
  template <class M>
  std::uint16_t send(const M& message);

  /// Waits up to `timeout` for events, sending heartbeats as they fall due. Returns at once when
  /// one is there; true when next_event() has one.
  bool poll(std::chrono::microseconds timeout);
  /// Takes the oldest event.
  std::optional<Event> next_event();

  /// Number of the latest request or streamed message; counts up modulo 65536.
  std::uint16_t last_sequence() const { return sequence_; }

  /// Status of the latest heartbeat or get_status; empty before the first.
  const std::optional<protocol::Status>& latest_status() const { return latest_status_; }

  /// Makes `round_trips` more and returns the clock.
  const ClockSync& synchronise_clock(int round_trips);
  const ClockSync& clock() const { return clock_; }

 private:
  struct Pending {
    std::uint16_t sequence;
    std::uint8_t request;
    std::uint8_t reply;
  };
  struct Reply {
    std::uint8_t type;
    std::vector<std::uint8_t> payload;
  };

  void shake_hands();
  void check_hello_reply(const Reply& reply);
  Reply exchange(std::uint8_t request, std::uint8_t reply, bool repeatable,
                 std::span<const std::uint8_t> payload);
  std::optional<Reply> await_reply(const Pending& pending);
  std::uint16_t send_frame(std::uint8_t type, std::span<const std::uint8_t> payload);
  void write_frame(std::uint8_t type, std::uint16_t sequence,
                   std::span<const std::uint8_t> payload);
  std::optional<protocol::FrameView> next_frame(std::uint64_t deadline_us);
  void handle(const protocol::FrameView& frame);
  void keep(Event event);
  void send_what_is_due();
  void take_clock_reply(const protocol::TimeSyncReply& reply);
  [[noreturn]] void throw_out_of_range(std::string_view message, std::string_view field,
                                       std::int64_t min, std::int64_t max) const;
  [[noreturn]] void throw_restarted() const;
  [[noreturn]] void throw_bad_reply(std::string_view message) const;
  template <class M>
  std::array<std::uint8_t, protocol::wire_size<M>> payload_of(const M& message) const;

  std::unique_ptr<Transport> transport_;
  SessionOptions options_;
  protocol::HelloReply device_{};
  protocol::FrameReader reader_{};
  std::array<std::uint8_t, 4096> received_{};
  std::span<const std::uint8_t> unread_{};
  std::deque<Event> events_;
  std::optional<protocol::Status> latest_status_;
  ClockSync clock_;
  std::uint16_t sequence_ = 0;
  std::uint64_t last_heartbeat_us_ = 0;
  std::uint64_t last_clock_us_ = 0;
  bool open_ = false;
};

template <class M>
std::array<std::uint8_t, protocol::wire_size<M>> Session::payload_of(const M& message) const {
  std::array<std::uint8_t, protocol::wire_size<M>> payload{};
  if (const protocol::CodecResult result = protocol::encode(message, payload); !result.ok()) {
    int number = 0;
    protocol::for_each_field<M>([&](const auto& declared) {
      if (number++ != result.field) return;
      throw_out_of_range(M::info.name, declared.name, declared.min, declared.max);
    });
  }
  return payload;
}

template <protocol::Request M>
protocol::ReplyTo<M> Session::request(const M& message) {
  using ReplyMessage = protocol::ReplyTo<M>;
  const auto payload = payload_of(message);
  const Reply reply =
      exchange(M::info.id, ReplyMessage::info.id, protocol::AnswerTo<M>::repeatable, payload);
  ReplyMessage answer{};
  if (!protocol::decode(std::span<const std::uint8_t>(reply.payload), answer).ok()) {
    throw_bad_reply(ReplyMessage::info.name);
  }
  if constexpr (std::is_same_v<ReplyMessage, protocol::Status>) latest_status_ = answer;
  return answer;
}

template <class M>
std::uint16_t Session::send(const M& message) {
  static_assert(!protocol::Request<M> && M::info.sender == protocol::Sender::host,
                "use request() for messages that are answered");
  const auto payload = payload_of(message);
  return send_frame(M::info.id, payload);
}

}  // namespace umov::instrument
