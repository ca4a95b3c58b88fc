#include "boards/stm32f407/step_outputs.hpp"

#include "boards/stm32f407/clock.hpp"
#include "boards/stm32f407/registers/core.hpp"

namespace umov::boards::stm32f407 {

using namespace timer_bits;

static_assert(apb1_timer_hz % firmware::step_timer_hz == 0);

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
  for_each_axis([]<std::size_t axis>() {
    constexpr AxisPins pins = axis_pins[axis];
    configure_output(pins.direction);
    set_mode<axis>(OC_FORCE_LOW);
    set_bits(timer_of<axis>().CCER, CCE(pins.channel));
    configure_alternate(pins.step, pins.timer == 2 ? 1 : 2);
  });
}

void StepOutputs::start(int axis, std::uint32_t ticks) {
  const CriticalSection alone;
  for_each_axis([&]<std::size_t each>() {
    if (static_cast<int>(each) != axis) return;
    TimerRegisters& timer = timer_of<each>();
    ending_[each] = false;
    timer.SR = ~CC(axis_pins[each].channel);
    set_bits(timer.DIER, CC(axis_pins[each].channel));
    lowered_at_[each] = timer.CNT - low_ticks;  // it has been low for long
    arm<each>(timer.CNT + ticks);
  });
}

void StepOutputs::stop(int axis) {
  const CriticalSection alone;
  for_each_axis([&]<std::size_t each>() {
    if (static_cast<int>(each) != axis) return;
    set_mode<each>(OC_FROZEN);
    const bool armed = (timer_of<each>().DIER & CC(axis_pins[each].channel)) != 0;
    if (armed && read(axis_pins[each].step)) {
      ending_[each] = true;
    } else {
      disarm<each>();
    }
  });
}

}  // namespace umov::boards::stm32f407
