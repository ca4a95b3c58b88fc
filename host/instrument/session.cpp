#include "host/instrument/session.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <utility>

#include "host/errors/error.hpp"
#include "host/instrument/link_lost.hpp"
#include "host/instrument/refusals.hpp"
#include "protocol/schema.hpp"

namespace umov::instrument {
namespace {

using std::chrono::microseconds;

/// Records and credits beyond this many unread events are dropped: the device sends them again.
constexpr std::size_t kept_events = 8192;

std::uint64_t to_us(std::chrono::milliseconds duration) {
  return static_cast<std::uint64_t>(microseconds(duration).count());
}

std::string text_of(const protocol::Name& name) {
  return std::string(name.data(), strnlen(name.data(), name.size()));
}

protocol::Name name_of(const std::string& text) {
  protocol::Name name{};
  std::copy_n(text.begin(), std::min(text.size(), name.size()), name.begin());
  return name;
}

std::string machine_name() {
  std::array<char, 256> name{};
  if (gethostname(name.data(), name.size() - 1) != 0) return "unnamed host";
  return name.data();
}

std::string version_text(std::uint16_t version, std::uint64_t hash) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "protocol version %u (schema %016llx)", unsigned{version},
                static_cast<unsigned long long>(hash));
  return text.data();
}

template <class M>
std::optional<M> decoded(std::span<const std::uint8_t> payload) {
  M message{};
  if (!protocol::decode(payload, message).ok()) return std::nullopt;
  return message;
}

}  // namespace

Session::Session(std::unique_ptr<Transport> transport, SessionOptions options)
    : transport_(std::move(transport)), options_(std::move(options)) {
  if (options_.host_name.empty()) options_.host_name = machine_name();
  // Not the numbers a crashed predecessor began with, whose replies may still be in the pipe.
  const std::uint64_t now = clock_us();
  sequence_ = static_cast<std::uint16_t>(now ^ (now >> 16) ^ (now >> 32));
  shake_hands();
  open_ = true;
  last_heartbeat_us_ = clock_us();
  synchronise_clock(options_.clock_round_trips);
}

void Session::shake_hands() {
  const std::uint8_t delimiter = protocol::frame_delimiter;
  transport_->write(std::span<const std::uint8_t>(&delimiter, 1));
  const protocol::Hello hello{protocol::protocol_version, protocol::schema_hash,
                              name_of(options_.host_name)};
  check_hello_reply(exchange(protocol::Hello::info.id, protocol::HelloReply::info.id,
                             protocol::AnswerTo<protocol::Hello>::repeatable, payload_of(hello)));
}

void Session::check_hello_reply(const Reply& reply) {
  // Version and hash lead the reply in every version of the protocol; the rest may differ.
  constexpr std::size_t stable_size = sizeof(std::uint16_t) + sizeof(std::uint64_t);
  if (reply.payload.size() < stable_size) throw_bad_reply(protocol::HelloReply::info.name);
  const std::uint8_t* from = reply.payload.data();
  const auto version = protocol::codec_detail::take<std::uint16_t>(from);
  const auto hash = protocol::codec_detail::take<std::uint64_t>(from);
  if (version != protocol::protocol_version || hash != protocol::schema_hash) {
    throw Error(Place{name()},
                "the controller speaks " + version_text(version, hash) + ", this program " +
                    version_text(protocol::protocol_version, protocol::schema_hash),
                "flash the firmware of this release, or use the release that fits the firmware");
  }
  const auto device = decoded<protocol::HelloReply>(reply.payload);
  if (!device) throw_bad_reply(protocol::HelloReply::info.name);
  device_ = *device;
}

std::uint16_t Session::send_frame(std::uint8_t type, std::span<const std::uint8_t> payload) {
  write_frame(type, ++sequence_, payload);
  return sequence_;
}

void Session::write_frame(std::uint8_t type, std::uint16_t sequence,
                          std::span<const std::uint8_t> payload) {
  std::array<std::uint8_t, protocol::max_wire_frame_size> frame{};
  const std::size_t size = protocol::FrameWriter::write_raw(type, sequence, payload, frame);
  transport_->write(std::span<const std::uint8_t>(frame.data(), size));
}

std::optional<protocol::FrameView> Session::next_frame(std::uint64_t deadline_us) {
  // Past the deadline one more read takes what is there; a flood of garbage can't hold us longer.
  for (bool last_read = false;;) {
    protocol::FrameView frame;
    if (reader_.next(unread_, frame)) return frame;
    if (last_read) return std::nullopt;
    const std::uint64_t now = clock_us();
    last_read = now >= deadline_us;
    const std::uint64_t left = last_read ? 0 : deadline_us - now;
    const std::size_t count =
        transport_->read(received_, microseconds(static_cast<microseconds::rep>(left)));
    unread_ = std::span<const std::uint8_t>(received_.data(), count);
  }
}

Session::Reply Session::exchange(std::uint8_t request, std::uint8_t reply, bool repeatable,
                                 std::span<const std::uint8_t> payload) {
  const Pending pending{++sequence_, request, reply};
  const int attempts = repeatable ? options_.attempts : 1;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    write_frame(request, pending.sequence, payload);
    if (auto answer = await_reply(pending)) return std::move(*answer);
  }
  const std::string silence = "no answer to " + std::string(protocol::message_name(request)) +
                              " within " +
                              std::to_string(options_.answer_timeout.count() * attempts) + " ms";
  if (repeatable) throw LinkLost(name(), silence);
  throw Unanswered(name(), silence);
}

std::optional<Session::Reply> Session::await_reply(const Pending& pending) {
  const std::uint64_t deadline = clock_us() + to_us(options_.answer_timeout);
  while (const auto frame = next_frame(deadline)) {
    // One with another number answered somebody else's hello; 0: the pipe answers unread.
    if (!open_ && frame->type == protocol::Busy::info.id &&
        (frame->sequence == pending.sequence || frame->sequence == 0)) {
      const auto busy = decoded<protocol::Busy>(frame->payload);
      const std::string owner = busy ? text_of(busy->owner) : std::string();
      throw Error(Place{name()},
                  "the controller is in use" + (owner.empty() ? "" : " by host '" + owner + "'"),
                  "end the program that uses it, then repeat the command");
    }
    if (frame->sequence == pending.sequence) {
      if (frame->type == pending.reply) {
        const auto done = decoded<protocol::Done>(frame->payload);
        const bool of_other =
            frame->type == protocol::Done::info.id && (!done || done->request != pending.request);
        if (!of_other) {
          return Reply{frame->type, {frame->payload.begin(), frame->payload.end()}};
        }
      }
      if (frame->type == protocol::ErrorReply::info.id) {
        const auto refusal = decoded<protocol::ErrorReply>(frame->payload);
        if (refusal && refusal->request == pending.request) {
          const auto code = static_cast<protocol::Refusal>(refusal->code);
          if (open_ && code == protocol::Refusal::schema_mismatch) throw_restarted();
          throw Refused(name(), protocol::message_name(pending.request), *refusal);
        }
      }
    }
    if (open_) handle(*frame);
  }
  return std::nullopt;
}

void Session::handle(const protocol::FrameView& frame) {
  switch (frame.type) {
    case protocol::RowCredit::info.id:
      if (auto credit = decoded<protocol::RowCredit>(frame.payload)) keep(*credit);
      break;
    case protocol::Record::info.id:
      if (auto record = decoded<protocol::Record>(frame.payload)) keep(*record);
      break;
    case protocol::FaultEvent::info.id:
      if (auto fault = decoded<protocol::FaultEvent>(frame.payload)) keep(*fault);
      break;
    case protocol::Status::info.id:
      if (auto status = decoded<protocol::Status>(frame.payload)) {
        latest_status_ = *status;
        keep(Heartbeat{frame.sequence, *status});
      }
      break;
    case protocol::TimeSyncReply::info.id:
      if (auto reply = decoded<protocol::TimeSyncReply>(frame.payload)) take_clock_reply(*reply);
      break;
    case protocol::ErrorReply::info.id: {
      const auto refusal = decoded<protocol::ErrorReply>(frame.payload);
      if (!refusal) break;
      if (static_cast<protocol::Refusal>(refusal->code) == protocol::Refusal::schema_mismatch) {
        throw_restarted();
      }
      if (refusal->request == protocol::ProgramRow::info.id ||
          refusal->request == protocol::RecordAck::info.id) {
        keep(StreamRefusal{frame.sequence, *refusal});
      }
      break;
    }
    default:
      break;  // late or repeated replies
  }
}

void Session::keep(Event event) {
  const bool sent_again = !std::holds_alternative<protocol::FaultEvent>(event);
  if (events_.size() >= kept_events && sent_again) return;
  events_.push_back(std::move(event));
}

void Session::take_clock_reply(const protocol::TimeSyncReply& reply) {
  clock_.add({reply.host_time_us, reply.received_us, reply.sent_us, clock_us()});
}

void Session::send_what_is_due() {
  const std::uint64_t now = clock_us();
  if (now - last_heartbeat_us_ >= to_us(options_.heartbeat)) {
    last_heartbeat_us_ = now;
    send_frame(protocol::GetStatus::info.id, payload_of(protocol::GetStatus{}));
  }
  if (now - last_clock_us_ >= to_us(options_.clock_interval)) {
    last_clock_us_ = now;
    send_frame(protocol::TimeSync::info.id, payload_of(protocol::TimeSync{clock_us()}));
  }
}

bool Session::poll(microseconds timeout) {
  const std::uint64_t deadline =
      clock_us() + static_cast<std::uint64_t>(std::max<microseconds::rep>(timeout.count(), 0));
  do {
    send_what_is_due();
    const std::uint64_t next_due = std::min(last_heartbeat_us_ + to_us(options_.heartbeat),
                                            last_clock_us_ + to_us(options_.clock_interval));
    // An event that waits already: take what has arrived besides, but do not wait for more.
    const std::uint64_t wait_until = events_.empty() ? std::min(deadline, next_due) : 0;
    if (const auto frame = next_frame(wait_until)) handle(*frame);
    protocol::FrameView frame;
    while (reader_.next(unread_, frame)) handle(frame);
  } while (events_.empty() && clock_us() < deadline);
  return !events_.empty();
}

std::optional<Event> Session::next_event() {
  if (events_.empty()) return std::nullopt;
  Event event = std::move(events_.front());
  events_.pop_front();
  return event;
}

const ClockSync& Session::synchronise_clock(int round_trips) {
  for (int i = 0; i < round_trips; ++i) {
    // A repeated request would measure the first attempt's timeout; the slow trip is filtered out.
    const auto reply = request(protocol::TimeSync{clock_us()});
    take_clock_reply(reply);
  }
  last_clock_us_ = clock_us();
  return clock_;
}

void Session::throw_out_of_range(std::string_view message, std::string_view field, std::int64_t min,
                                 std::int64_t max) const {
  throw Error(Place{name()},
              "the field " + std::string(field) + " of the message " + std::string(message) +
                  " is out of range",
              "allowed is " + std::to_string(min) + " to " + std::to_string(max));
}

void Session::throw_restarted() const {
  // It had accepted our schema, so it has forgotten the session.
  throw LinkLost(name(), "the controller was restarted");
}

void Session::throw_bad_reply(std::string_view message) const {
  throw Error(Place{name()},
              "the controller sent a " + std::string(message) + " with impossible contents",
              "flash the firmware of this release");
}

}  // namespace umov::instrument
