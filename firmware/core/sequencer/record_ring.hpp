// Records that the host has not yet acknowledged.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/config/design_parameters.hpp"
#include "protocol/messages.hpp"

namespace umov::firmware {

/// Holds records [first_unacknowledged, next): consecutive indices, at most record_capacity. A
/// cursor marks what has been sent.
class RecordRing {
 public:
  void restart(std::uint32_t index) {
    first_ = next_ = cursor_ = index;
    first_slot_ = 0;
  }
  bool full() const { return next_ - first_ == record_capacity; }
  bool empty() const { return next_ == first_; }
  std::uint32_t first_unacknowledged() const { return first_; }
  /// Index of the record that comes next.
  std::uint32_t next() const { return next_; }
  /// There must be room.
  void push(const protocol::Record& record) {
    records_[slot(next_)] = record;
    ++next_;
  }
  /// Forgets records below `index`, which lies in [first_unacknowledged, next].
  void acknowledge(std::uint32_t index) {
    first_slot_ = slot(index);
    first_ = index;
    if (cursor_ < index) cursor_ = index;
  }
  bool unsent() const { return cursor_ != next_; }
  bool sent_unacknowledged() const { return cursor_ != first_; }
  const protocol::Record& to_send() const { return records_[slot(cursor_)]; }
  void mark_sent() { ++cursor_; }
  void send_all_again() { cursor_ = first_; }

 private:
  std::uint32_t slot(std::uint32_t index) const {
    return (first_slot_ + (index - first_)) % record_capacity;
  }
  std::array<protocol::Record, record_capacity> records_{};
  std::uint32_t first_ = 0;
  std::uint32_t next_ = 0;
  std::uint32_t cursor_ = 0;
  std::uint32_t first_slot_ = 0;
};

}  // namespace umov::firmware
