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
    const std::size_t at = (first_ + size_) % capacity;
    const std::size_t until_end = std::min(bytes.size(), capacity - at);
    std::copy_n(bytes.begin(), until_end, buffer_.begin() + static_cast<std::ptrdiff_t>(at));
    std::copy(bytes.begin() + static_cast<std::ptrdiff_t>(until_end), bytes.end(), buffer_.begin());
    size_ += bytes.size();
    return true;
  }

  /// Takes as many as there are and fit; returns how many.
  std::size_t pop(std::span<std::uint8_t> out) {
    const std::size_t count = std::min(out.size(), size_);
    const std::size_t until_end = std::min(count, capacity - first_);
    std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(first_), until_end, out.begin());
    std::copy_n(buffer_.begin(), count - until_end,
                out.begin() + static_cast<std::ptrdiff_t>(until_end));
    first_ = (first_ + count) % capacity;
    size_ -= count;
    return count;
  }

 private:
  std::array<std::uint8_t, capacity> buffer_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace umov::firmware::usb
