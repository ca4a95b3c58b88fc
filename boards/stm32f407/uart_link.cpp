#include "boards/stm32f407/uart_link.hpp"

#include <algorithm>

#include "boards/stm32f407/clock.hpp"
#include "boards/stm32f407/pins.hpp"
#include "boards/stm32f407/registers/core.hpp"
#include "boards/stm32f407/registers/dma.hpp"
#include "boards/stm32f407/registers/usart.hpp"

namespace umov::boards::stm32f407 {
namespace {

static_assert(link_tx == Pin{Port::A, 2} && link_rx == Pin{Port::A, 3}, "USART2 on its pins");
static_assert(apb1_hz % link_baud == 0, "a baud rate without rounding");

// RM0090 table 42: USART2_RX is stream 5, USART2_TX stream 6, both channel 4.
constexpr unsigned receiving = 5, sending = 6;
constexpr std::uint32_t usart_channel = dma_bits::CHSEL(4);

std::uint32_t address(const volatile void* place) {
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(place));
}

/// DMA reads and writes memory behind the compiler's back.
void memory_is_shared() {
  asm volatile("dmb" : : : "memory");
}

}  // namespace

void UartLink::set_up() {
  configure_alternate(link_tx, 7);
  configure_alternate(link_rx, 7, Pull::up);
  UsartRegisters& usart = usart2();
  usart.BRR = apb1_hz / link_baud;
  usart.CR3 = usart_bits::DMAR | usart_bits::DMAT;
  start_receiving();
  usart.CR1 = usart_bits::UE | usart_bits::TE | usart_bits::RE;
}

void UartLink::start_receiving() {
  read_ = 0;
  dma1().IFCR[receiving / 4] = dma_bits::ALL << dma_bits::flag_shift(receiving);
  DmaStreamRegisters& stream = dma1().stream[receiving];
  stream.PAR = address(&usart2().DR);
  stream.M0AR = address(received_.data());
  stream.NDTR = received_.size();
  stream.CR = usart_channel | dma_bits::MINC | dma_bits::CIRC;
  set_bits(stream.CR, dma_bits::EN);
}

void UartLink::service() {
  // RM0090 10.3.19: a bus error clears EN. What came meanwhile is lost, as on any line; frames
  // have a CRC.
  if ((dma1().stream[receiving].CR & dma_bits::EN) == 0) start_receiving();
}

std::size_t UartLink::received_end() const {
  const std::size_t end = received_.size() - dma1().stream[receiving].NDTR;
  memory_is_shared();
  return end % received_.size();
}

bool UartLink::write(std::span<const std::uint8_t> bytes) {
  if (bytes.size() > room()) return false;
  // The interrupt sends up to the head: it moves on when all bytes are there.
  std::uint32_t head = head_;
  for (const std::uint8_t byte : bytes) sent_[head++ % sent_.size()] = byte;
  const CriticalSection alone;
  head_ = head;
  if (flying_ == 0) send_next();
  return true;
}

void UartLink::on_sent() {
  dma1().IFCR[sending / 4] = dma_bits::ALL << dma_bits::flag_shift(sending);
  // All of it, or after an error what had been fetched by then.
  tail_ = tail_ + flying_ - (dma1().stream[sending].NDTR & 0xFFFFu);
  flying_ = 0;
  send_next();
}

void UartLink::send_next() {
  const std::uint32_t start = tail_ % sent_.size();
  const auto left = static_cast<std::uint32_t>(sent_.size() - start);
  const std::uint32_t count = std::min(head_ - tail_, left);
  if (count == 0) return;
  memory_is_shared();
  flying_ = count;
  DmaStreamRegisters& stream = dma1().stream[sending];
  stream.PAR = address(&usart2().DR);
  stream.M0AR = address(sent_.data() + start);
  stream.NDTR = count;
  stream.CR = usart_channel | dma_bits::MINC | dma_bits::MEMORY_TO_PERIPHERAL | dma_bits::TCIE |
              dma_bits::TEIE;
  set_bits(stream.CR, dma_bits::EN);
}

}  // namespace umov::boards::stm32f407
