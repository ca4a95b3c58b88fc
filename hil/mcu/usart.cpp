#include "hil/mcu/usart.hpp"

#include <utility>

namespace umov::mcu {
namespace {

constexpr std::uint32_t sr = 0x00, dr = 0x04, brr = 0x08, cr1 = 0x0C, cr2 = 0x10, cr3 = 0x14;
constexpr std::uint32_t ore = 8, rxne = 32, tc = 64, txe = 128;
constexpr std::uint32_t receiver = 4, transmitter = 8, usart_enable = 1u << 13;
constexpr std::uint32_t interrupts = 0xE0;  // RXNEIE, TCIE, TXEIE, at the places of their flags
constexpr std::uint32_t receive_dma = 64, send_dma = 128;

}  // namespace

Usart::Usart(Scheduler& scheduler, std::function<Time()> bus_cycle, Wires wires)
    : scheduler_(&scheduler),
      bus_cycle_(std::move(bus_cycle)),
      wires_(std::move(wires)),
      send_slot_(scheduler.add([this] { sent(); })),
      receive_slot_(scheduler.add([this] { arrived(); })) {}

Time Usart::byte_time() const {
  constexpr Time bits = 10;
  return bits * brr_ * bus_cycle_();
}

void Usart::deliver(std::span<const std::uint8_t> bytes) {
  const bool idle = coming_.empty();
  coming_.insert(coming_.end(), bytes.begin(), bytes.end());
  if (!idle || coming_.empty()) return;
  // Nobody knows the speed of a receiver that has not been set up: the bytes go by in no time.
  scheduler_->set(receive_slot_, scheduler_->now() + (brr_ != 0 ? byte_time() : 0));
}

void Usart::arrived() {
  const std::uint8_t byte = coming_.front();
  coming_.pop_front();
  if (!coming_.empty())
    scheduler_->set(receive_slot_, scheduler_->now() + (brr_ != 0 ? byte_time() : 0));
  if ((cr1_ & usart_enable) == 0 || (cr1_ & receiver) == 0) return;
  if (data_ready_) {
    overrun_ = true;
  } else {
    received_ = byte;
    data_ready_ = true;
    ask_for_dma();
  }
  tell_interrupt();
}

void Usart::shift_next() {
  if (shifting_ || !waiting_) return;
  on_line_ = to_send_;
  waiting_ = false;
  shifting_ = true;
  scheduler_->set(send_slot_, scheduler_->now() + byte_time());
}

void Usart::sent() {
  shifting_ = false;
  if (wires_.on_byte) wires_.on_byte(on_line_);
  shift_next();
  ask_for_dma();
  tell_interrupt();
}

void Usart::ask_for_dma() {
  if (data_ready_ && (cr3_ & receive_dma) != 0) wires_.receive_request();
  const bool sends = (cr1_ & usart_enable) != 0 && (cr1_ & transmitter) != 0;
  while (sends && !waiting_ && (cr3_ & send_dma) != 0 && wires_.send_request()) {
  }
}

void Usart::on_stream_enabled() {
  ask_for_dma();
  tell_interrupt();
}

void Usart::tell_interrupt() {
  const std::uint32_t flags =
      (data_ready_ ? rxne : 0u) | (!waiting_ && !shifting_ ? tc : 0u) | (!waiting_ ? txe : 0u);
  wires_.interrupt((flags & cr1_ & interrupts) != 0);
}

std::uint32_t Usart::read(std::uint32_t offset) {
  switch (offset) {
    case sr:
      return (overrun_ ? ore : 0u) | (data_ready_ ? rxne : 0u) |
             (!waiting_ && !shifting_ ? tc : 0u) | (!waiting_ ? txe : 0u);
    case dr: {
      data_ready_ = false;
      overrun_ = false;
      tell_interrupt();
      return received_;
    }
    case brr:
      return brr_;
    case cr1:
      return cr1_;
    case cr2:
      return 0;
    case cr3:
      return cr3_;
    default:
      refuse_register("USART", offset);
  }
}

void Usart::write(std::uint32_t offset, std::uint32_t value) {
  switch (offset) {
    case sr:
      break;
    case dr:
      if ((cr1_ & usart_enable) == 0 || (cr1_ & transmitter) == 0 || brr_ == 0)
        refuse_setting("USART", "DR of a transmitter that is off", value);
      if (waiting_) refuse_setting("USART", "DR before the byte in it was sent", value);
      to_send_ = static_cast<std::uint8_t>(value);
      waiting_ = true;
      shift_next();
      break;
    case brr:
      brr_ = value & 0xFFFF;
      break;
    case cr1:
      if ((value & ~(usart_enable | receiver | transmitter | interrupts)) != 0)
        refuse_setting("USART", "CR1", value);
      cr1_ = value;
      ask_for_dma();
      break;
    case cr2:
      if (value != 0) refuse_setting("USART", "CR2", value);
      break;
    case cr3:
      if ((value & ~(receive_dma | send_dma)) != 0) refuse_setting("USART", "CR3", value);
      cr3_ = value;
      ask_for_dma();
      break;
    default:
      refuse_register("USART", offset);
  }
  tell_interrupt();
}

}  // namespace umov::mcu
