// From reset to main. The boot loader uses no interrupts: the vectors end with the processor's own.
#include <cstddef>
#include <cstdint>

#include "boards/stm32f407/boot_request.hpp"
#include "boards/stm32f407/prepare_memory.hpp"
#include "boards/stm32f407/registers/core.hpp"

extern "C" {

int main();

/// A processor fault: from the beginning. Pins are inputs, the bench is dark.
[[noreturn]] void fault_handler() {
  using namespace umov::boards::stm32f407;
  reset_with(BootRequest::none);
}

[[noreturn]] void reset_handler() {
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

using Handler = void (*)();
union Vector {
  const std::uint32_t* stack_top;
  Handler handler;
};
}

namespace {

struct Table {
  Vector vector[16];
};

constexpr Table make_table() {
  Table table{};
  for (Vector& v : table.vector) v = {.handler = fault_handler};
  table.vector[0] = {.stack_top = image_stack_top};
  table.vector[1] = {.handler = reset_handler};
  return table;
}
[[gnu::section(".vectors"), gnu::used]] constinit const Table vectors = make_table();
static_assert(sizeof(Table) == umov::boards::stm32f407::boot_mark_address -
                                   umov::boards::stm32f407::memory_map::flash);

[[gnu::section(".boot_mark"), gnu::used]] constinit const umov::boards::stm32f407::BootMark mark =
    umov::boards::stm32f407::boot_mark;

}  // namespace
