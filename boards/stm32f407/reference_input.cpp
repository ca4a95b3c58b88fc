#include "boards/stm32f407/reference_input.hpp"

#include "boards/stm32f407/clock.hpp"
#include "boards/stm32f407/pins.hpp"
#include "boards/stm32f407/registers/core.hpp"
#include "boards/stm32f407/step_outputs.hpp"
#include "firmware/core/config/design_parameters.hpp"

namespace umov::boards::stm32f407 {
namespace {

static_assert(apb2_timer_hz == firmware::reference_clock_hz, "TIM1 is the reference clock");
constexpr std::uint32_t ticks_a_step_tick = firmware::reference_clock_hz / firmware::step_timer_hz;
static_assert(ticks_a_step_tick * firmware::step_timer_hz == firmware::reference_clock_hz);

/// TIM1 less the step clock in its ticks, modulo 2^16; the two run from the same crystal.
std::uint32_t ahead = 0;

std::uint32_t coarse_clock() {
  return step_clock() * ticks_a_step_tick + ahead;
}

}  // namespace

std::uint32_t reference_tick(std::uint32_t count) {
  const std::uint32_t coarse = coarse_clock();
  return coarse +
         static_cast<std::uint32_t>(std::int32_t{static_cast<std::int16_t>(count - coarse)});
}

void ReferenceInput::set_up() {
  configure_alternate(reference_input.pin, 1, Pull::down);
  TimerRegisters& timer = tim1();
  constexpr unsigned place = reference_input.channel - 1;
  timer.CR1 = timer_bits::URS;
  timer.PSC = 0;
  timer.ARR = 0xFFFF;
  change_bits(timer.CCMR[place / 2], 0xFFu << 8 * (place % 2),
              timer_bits::IC_OWN_INPUT << 8 * (place % 2));
  timer.CCER = timer_bits::CCE(reference_input.channel);
  timer.CR1 = timer_bits::URS | timer_bits::CEN;
  ahead = (timer.CNT - coarse_clock()) & 0xFFFF;
  timer.SR = 0;
  timer.DIER = flag;
}

void ReferenceInput::service() {
  const CriticalSection alone;
  edges_left_ = edges_a_tick;
  TimerRegisters& timer = tim1();
  if (timer.DIER != 0) return;
  timer.SR = 0;  // what has been captured meanwhile is old
  timer.DIER = flag;
}

}  // namespace umov::boards::stm32f407
