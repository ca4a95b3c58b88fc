// Bytes for the host that no transfer has taken yet.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace umov::firmware::usb {

class TransmitRing {
 public:
  /// What a board's link must hold (Board::link_room) and a little more.
  static constexpr std::size_t capacity = 4096;

  std::size_t size() const { return size_; }
  std::size_t room() const { return capacity - size_; }
  void clear() { size_ = 0; }

  /// All of `bytes` or nothing.
  bool push(std::span<const std::uint8_t> bytes) {
    if (bytes.size() > room()) return false;
    std::size_t at = (first_ + size_) % capacity;
    for (const std::uint8_t byte : bytes) {
      buffer_[at] = byte;
      at = at + 1 == capacity ? 0 : at + 1;
    }
    size_ += bytes.size();
    return true;
  }

  /// Takes as many as there are and fit; returns how many.
  std::size_t pop(std::span<std::uint8_t> out) {
    const std::size_t count = std::min(out.size(), size_);
    for (std::size_t i = 0; i < count; ++i) {
      out[i] = buffer_[first_];
      first_ = first_ + 1 == capacity ? 0 : first_ + 1;
    }
    size_ -= count;
    return count;
  }

 private:
  std::array<std::uint8_t, capacity> buffer_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace umov::firmware::usb
