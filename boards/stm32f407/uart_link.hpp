// The link: USART2, both directions by DMA through rings.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/core/usb/link_switch.hpp"

namespace umov::boards::stm32f407 {

/// Contexts: on_sent() in the interrupt of the sending stream, the rest in the main loop.
class UartLink final : public firmware::usb::SerialLine {
 public:
  void set_up();
  std::size_t room() const override { return sent_.size() - (head_ - tail_); }
  bool write(std::span<const std::uint8_t> bytes) override;
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
  /// A DMA error ends a transfer early: what is left of it is sent anew.
  void on_sent();
  /// Once a millisecond: a receiving stream that an error has switched off is started again.
  void service();

 private:
  std::size_t received_end() const;
  void start_receiving();
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
