// The link: USART2, both directions by DMA through rings.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace umov::boards::stm32f407 {

/// Contexts: on_sent() in the interrupt of the sending stream, the rest in the main loop.
class UartLink {
 public:
  void set_up();
  std::size_t room() const { return sent_.size() - (head_ - tail_); }
  /// False if it does not fit now; nothing is queued then.
  bool write(std::span<const std::uint8_t> bytes);
  /// Hands the bytes that have come in since to `take`, in one or two pieces.
  template <class Take>
  void read(Take&& take) {
    const std::size_t end = received_end();
    if (end < read_) {
      take(std::span<const std::uint8_t>(received_).subspan(read_));
      read_ = 0;
    }
    if (end > read_) take(std::span<const std::uint8_t>(received_).subspan(read_, end - read_));
    read_ = end;
  }
  void on_sent();

 private:
  std::size_t received_end() const;
  void send_next();

  /// 20 ms at 1 Mbaud; the main loop looks each millisecond.
  std::array<std::uint8_t, 2048> received_{};
  std::size_t read_ = 0;
  std::array<std::uint8_t, 4096> sent_{};
  // Counted without wrapping; head in the main loop, tail and flying_ in the interrupt or while it
  // is kept out.
  std::uint32_t head_ = 0;
  volatile std::uint32_t tail_ = 0;
  volatile std::uint32_t flying_ = 0;
};

}  // namespace umov::boards::stm32f407
