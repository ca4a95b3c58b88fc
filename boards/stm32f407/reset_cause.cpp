#include "boards/stm32f407/reset_cause.hpp"

#include "boards/stm32f407/boot_request.hpp"
#include "boards/stm32f407/registers/core.hpp"
#include "boards/stm32f407/registers/rcc.hpp"

namespace umov::boards::stm32f407 {
namespace {

/// In memory that nothing clears or copies over at a reset; after power-on it holds anything.
struct FaultNote {
  std::uint32_t mark, program_counter, complement;

  bool valid() const volatile { return mark == marked && complement == ~program_counter; }
  static constexpr std::uint32_t marked = 0x4641'554C;
};
[[gnu::section(".kept_over_reset"), gnu::used]] volatile FaultNote fault_note;

}  // namespace

void reset_after_fault(std::uint32_t program_counter) {
  fault_note.mark = FaultNote::marked;
  fault_note.program_counter = program_counter;
  fault_note.complement = ~program_counter;
  constexpr std::uint32_t key = 0x05FA'0000, system_reset = 1u << 2;
  asm volatile("dsb" : : : "memory");
  scb().AIRCR = key | system_reset;
  for (;;) {
  }
}

ResetReport take_reset_cause() {
  using namespace rcc_bits;
  std::uint32_t flags = 0;
  if (!take_reset_flags(flags)) flags = rcc().CSR;
  set_bits(rcc().CSR, RMVF);
  const bool noted = fault_note.valid();
  const auto program_counter = static_cast<std::int32_t>(fault_note.program_counter);
  fault_note.mark = 0;
  using enum firmware::ResetCause;
  if ((flags & PORRSTF) != 0) return {power_on};
  if ((flags & IWDGRSTF) != 0) return {watchdog};
  if ((flags & BORRSTF) != 0) return {brown_out};
  if ((flags & SFTRSTF) != 0 && noted) return {processor_fault, program_counter};
  return {power_on};
}

}  // namespace umov::boards::stm32f407
