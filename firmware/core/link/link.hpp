// Frames in and out, and how long the host has been silent. What a message means, the controller
// knows.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/core/config/design_parameters.hpp"
#include "firmware/core/port.hpp"
#include "protocol/frame.hpp"
#include "protocol/messages.hpp"

namespace umov::firmware {

class Link {
 public:
  explicit Link(Board& board) : board_(&board) {}

  /// Calls `on_frame` for every good frame in `bytes`; any of them is a sign of life.
  template <class Handler>
  void receive(std::span<const std::uint8_t> bytes, Handler&& on_frame) {
    reader_.feed(bytes, [&](const protocol::FrameView& frame) {
      last_heard_us_ = board_->link_time_us();
      heard_ = true;
      on_frame(frame);
    });
  }

  /// Answers the request of that number. A reply that does not fit the board's buffer is dropped
  /// and counted: the host asks again.
  template <class M>
  void reply(std::uint16_t sequence, const M& message) {
    if (!write(sequence, message)) ++dropped_replies_;
  }
  void refuse(std::uint16_t sequence, std::uint8_t request, protocol::Refusal reason,
              std::int32_t detail = -1) {
    reply(sequence, protocol::ErrorReply{request, static_cast<std::uint8_t>(reason), detail});
  }
  void accept(std::uint16_t sequence, std::uint8_t request) {
    reply(sequence, protocol::Done{request});
  }
  /// Whether something of that kind may be said unasked now.
  template <class M>
  bool has_room() const {
    return board_->link_room() >= protocol::wire_frame_size<M> + reply_reserve_bytes;
  }
  /// Says something unasked; false if it does not fit now.
  template <class M>
  bool tell(const M& message) {
    if (!has_room<M>()) return false;
    if (!write(own_sequence_, message)) return false;
    ++own_sequence_;
    return true;
  }

  /// Nothing heard for link_timeout_us, or never.
  bool silent() const {
    return !heard_ || board_->link_time_us() - last_heard_us_ >= link_timeout_us;
  }
  std::uint32_t dropped_replies() const { return dropped_replies_; }

 private:
  template <class M>
  bool write(std::uint16_t sequence, const M& message) {
    std::array<std::uint8_t, protocol::wire_frame_size<M>> frame;
    const std::size_t size = protocol::FrameWriter::write(sequence, message, frame);
    return size > 0 && board_->write_link(std::span<const std::uint8_t>(frame.data(), size));
  }

  Board* board_;
  protocol::FrameReader reader_{};
  std::uint64_t last_heard_us_ = 0;
  bool heard_ = false;
  std::uint16_t own_sequence_ = 0;
  std::uint32_t dropped_replies_ = 0;
};

}  // namespace umov::firmware
