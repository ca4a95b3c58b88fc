// A USART with 8 data bits, no parity, one stop bit, 16-fold oversampling (RM0090 30), by DMA or
// register.
#pragma once

#include <deque>
#include <span>

#include "hil/mcu/peripheral.hpp"

namespace umov::mcu {

class Usart : public Peripheral {
 public:
  struct Wires {
    InterruptLine interrupt;
    std::function<bool()> receive_request, send_request;  ///< DMA; false when no stream is ready
    std::function<void(std::uint8_t byte)> on_byte;       ///< the stop bit of a byte has been sent
  };
  Usart(Scheduler& scheduler, std::function<Time()> bus_cycle, Wires wires);

  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;
  /// Bytes on the receive line, one after the other from now on at the line's speed. Those that
  /// come while the receiver is off are lost, as on a wire.
  void deliver(std::span<const std::uint8_t> bytes);
  /// A DMA stream has been switched on.
  void on_stream_enabled();

 private:
  Time byte_time() const;
  void sent();
  void arrived();
  void shift_next();
  void ask_for_dma();
  void tell_interrupt();

  Scheduler* scheduler_;
  std::function<Time()> bus_cycle_;
  Wires wires_;
  Scheduler::Slot send_slot_, receive_slot_;
  std::uint32_t brr_ = 0, cr1_ = 0, cr3_ = 0;
  bool overrun_ = false;
  bool data_ready_ = false;  // RXNE
  std::uint8_t received_ = 0;
  bool waiting_ = false;  // a byte in the data register, not yet in the shift register
  std::uint8_t to_send_ = 0;
  bool shifting_ = false;
  std::uint8_t on_line_ = 0;
  std::deque<std::uint8_t> coming_;
};

}  // namespace umov::mcu
