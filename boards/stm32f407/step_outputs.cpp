#include "boards/stm32f407/step_outputs.hpp"

#include "boards/stm32f407/clock.hpp"
#include "boards/stm32f407/pins.hpp"
#include "boards/stm32f407/registers/core.hpp"

namespace umov::boards::stm32f407 {
namespace {

using namespace timer_bits;

constexpr std::uint32_t pulse_ticks = step_pulse_us * (firmware::step_timer_hz / 1'000'000);
static_assert(apb1_timer_hz % firmware::step_timer_hz == 0);

TimerRegisters& timer_of(int axis) {
  return axis_pins[static_cast<std::size_t>(axis)].timer == 2 ? tim2() : tim5();
}
unsigned channel_of(int axis) {
  return axis_pins[static_cast<std::size_t>(axis)].channel;
}
Pin step_pin(int axis) {
  return axis_pins[static_cast<std::size_t>(axis)].step;
}

void set_mode(int axis, std::uint32_t mode) {
  const unsigned place = channel_of(axis) - 1;
  const unsigned shift = 8 * (place % 2) + 4;
  change_bits(timer_of(axis).CCMR[place / 2], 7u << shift, mode << shift);
}

}  // namespace

std::uint32_t step_clock() {
  return tim5().CNT;
}

void StepOutputs::set_up() {
  for (TimerRegisters* timer : {&tim2(), &tim5()}) {
    timer->CR1 = URS;
    timer->PSC = apb1_timer_hz / firmware::step_timer_hz - 1;
    timer->ARR = 0xFFFF'FFFF;
    timer->EGR = UG;
    timer->CR1 = URS | CEN;
  }
  for (int axis = 0; axis < static_cast<int>(axis_pins.size()); ++axis) {
    const AxisPins& pins = axis_pins[index(axis)];
    configure_output(pins.direction);
    set_mode(axis, OC_FORCE_LOW);
    set_bits(timer_of(axis).CCER, CCE(pins.channel));
    configure_alternate(pins.step, pins.timer == 2 ? 1 : 2);
  }
}

void StepOutputs::start(int axis, std::uint32_t ticks) {
  const CriticalSection alone;
  TimerRegisters& timer = timer_of(axis);
  ending_[index(axis)] = false;
  timer.SR = ~CC(channel_of(axis));
  set_bits(timer.DIER, CC(channel_of(axis)));
  arm(axis, timer.CNT + ticks);
}

void StepOutputs::stop(int axis) {
  const CriticalSection alone;
  set_mode(axis, OC_FROZEN);
  if ((timer_of(axis).DIER & CC(channel_of(axis))) != 0 && read(step_pin(axis))) {
    ending_[index(axis)] = true;
  } else {
    disarm(axis);
  }
}

bool StepOutputs::raised(int axis) const {
  const TimerRegisters& timer = timer_of(axis);
  return (timer.SR & timer.DIER & CC(channel_of(axis))) != 0;
}

std::uint32_t StepOutputs::take(int axis) {
  TimerRegisters& timer = timer_of(axis);
  timer.SR = ~CC(channel_of(axis));
  return timer.CCR[channel_of(axis) - 1];
}

void StepOutputs::end_pulse(int axis) {
  const TimerRegisters& timer = timer_of(axis);
  while (timer.CNT - raised_at_[index(axis)] < pulse_ticks) {
  }
  set_mode(axis, OC_FORCE_LOW);
}

void StepOutputs::arm(int axis, std::uint32_t due) {
  TimerRegisters& timer = timer_of(axis);
  const unsigned channel = channel_of(axis);
  raised_at_[index(axis)] = due;
  timer.CCR[channel - 1] = due;
  set_mode(axis, OC_HIGH_ON_MATCH);
  // The tick may have gone by before the channel was ready: then there is no match for 2^32 ticks,
  // or one that found the pin held low.
  const std::uint32_t now = timer.CNT;
  if (static_cast<std::int32_t>(now - due) < 0 || read(step_pin(axis))) return;
  raised_at_[index(axis)] = now;
  set_mode(axis, OC_FORCE_HIGH);
  timer.EGR = CC(channel);
}

void StepOutputs::disarm(int axis) {
  TimerRegisters& timer = timer_of(axis);
  clear_bits(timer.DIER, CC(channel_of(axis)));
  set_mode(axis, OC_FORCE_LOW);
  timer.SR = ~CC(channel_of(axis));
}

}  // namespace umov::boards::stm32f407
