// Rows of the program that have arrived and are not yet measured.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/config/design_parameters.hpp"
#include "protocol/messages.hpp"

namespace umov::firmware {

/// Holds rows [first, next): consecutive indices, at most row_capacity.
class RowRing {
 public:
  void restart(std::uint32_t index) { first_ = next_ = index; }
  bool empty() const { return first_ == next_; }
  std::uint32_t free() const { return row_capacity - (next_ - first_); }
  /// Index of the row wanted next.
  std::uint32_t next() const { return next_; }
  /// Takes the row that is wanted; there must be room.
  void push(const protocol::ProgramRow& row) { rows_[next_++ % row_capacity] = row; }
  const protocol::ProgramRow& front() const { return rows_[first_ % row_capacity]; }
  void pop() { ++first_; }

 private:
  static_assert((row_capacity & (row_capacity - 1)) == 0, "indices wrap with the ring");
  std::array<protocol::ProgramRow, row_capacity> rows_{};
  std::uint32_t first_ = 0;
  std::uint32_t next_ = 0;
};

}  // namespace umov::firmware
