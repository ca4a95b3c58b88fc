// From reset to main: vector table, memory, and what happens when the processor faults.
#include <cstddef>
#include <cstdint>

#include "boards/stm32f407/prepare_memory.hpp"
#include "boards/stm32f407/registers/core.hpp"
#include "boards/stm32f407/reset_cause.hpp"

extern "C" {

extern std::uint32_t image_stack_begin[];

int main();

void tim1_cc_handler();
void tim2_handler();
void tim5_handler();
void exti4_handler();
void exti9_5_handler();
void exti15_10_handler();
void pvd_handler();
void adc_handler();
void dma2_stream0_handler();
void dma1_stream6_handler();
void otg_fs_handler();
void systick_handler();

/// A processor fault: nothing can be trusted any more, the stack least of all. Reset; the outputs
/// are inputs from then on and their external pull-downs keep the light off. `frame`: where the
/// stack stood.
[[noreturn, gnu::used]] void fault_seen(const std::uint32_t* frame) {
  constexpr std::uint32_t place_of_counter = 6;
  const bool readable = frame >= image_stack_begin && frame + 8 <= image_stack_top;
  umov::boards::stm32f407::reset_after_fault(readable ? frame[place_of_counter] : 0xFFFF'FFFF);
}

/// Also where an interrupt without a handler ends. Goes on with a stack of its own.
[[noreturn, gnu::naked]] void fault_handler() {
  asm volatile(
      "mrs r0, msp\n\t"
      "ldr r1, =image_stack_top\n\t"
      "mov sp, r1\n\t"
      "b fault_seen\n\t"
      ".ltorg");
}

[[noreturn]] void reset_handler();

using Handler = void (*)();
union Vector {
  const std::uint32_t* stack_top;
  Handler handler;
};
}

namespace {

using umov::boards::stm32f407::Irq;

struct Table {
  Vector vector[16 + 82];
};

constexpr std::size_t place(Irq irq) {
  return 16 + static_cast<std::size_t>(irq);
}

constexpr Table make_table() {
  Table table{};
  for (Vector& v : table.vector) v = {.handler = fault_handler};
  table.vector[0] = {.stack_top = image_stack_top};
  table.vector[1] = {.handler = reset_handler};
  table.vector[15] = {.handler = systick_handler};
  table.vector[place(Irq::tim1_cc)] = {.handler = tim1_cc_handler};
  table.vector[place(Irq::tim2)] = {.handler = tim2_handler};
  table.vector[place(Irq::tim5)] = {.handler = tim5_handler};
  table.vector[place(Irq::exti4)] = {.handler = exti4_handler};
  table.vector[place(Irq::exti9_5)] = {.handler = exti9_5_handler};
  table.vector[place(Irq::exti15_10)] = {.handler = exti15_10_handler};
  table.vector[place(Irq::pvd)] = {.handler = pvd_handler};
  table.vector[place(Irq::adc)] = {.handler = adc_handler};
  table.vector[place(Irq::dma2_stream0)] = {.handler = dma2_stream0_handler};
  table.vector[place(Irq::dma1_stream6)] = {.handler = dma1_stream6_handler};
  table.vector[place(Irq::otg_fs)] = {.handler = otg_fs_handler};
  return table;
}

/// Room for the image's header, which the build fills in (protocol/image_header.hpp).
struct HeaderRoom {
  std::uint8_t bytes[512];
};
[[gnu::section(".image_header"), gnu::used]] constinit const HeaderRoom header_room = {};

/// The image's own vectors, behind its header.
[[gnu::section(".vectors"), gnu::used]] constinit const Table vectors = make_table();

/// What the chip reads at power-on while no boot loader is there: it goes straight to the image.
struct FirstVectors {
  Vector stack, reset;
};
[[gnu::section(".first_vectors"), gnu::used]] constinit const FirstVectors first_vectors = {
    {.stack_top = image_stack_top}, {.handler = reset_handler}};

}  // namespace

extern "C" {

void reset_handler() {
  umov::boards::stm32f407::scb().VTOR = reinterpret_cast<std::uintptr_t>(&vectors);
  umov::boards::stm32f407::prepare_memory();
  main();
  fault_handler();
}

// Called where a pure virtual function would be: never, or something is badly wrong.
[[noreturn]] void __cxa_pure_virtual() {
  fault_handler();
}
[[noreturn]] void abort() {
  fault_handler();
}
}
