// Edges of an external reference: TIM1 counts at the core's clock, and a capture channel notes its
// count at each rising edge.
#pragma once

#include <cstdint>

#include "boards/stm32f407/board_description.hpp"
#include "boards/stm32f407/registers/timer.hpp"

namespace umov::boards::stm32f407 {

/// The reference clock at which TIM1 counted `count`, less than 0.19 ms ago or ahead: TIM1 has 16
/// bits, the step clock tells which of its rounds it is. Any context.
std::uint32_t reference_tick(std::uint32_t count);

/// Contexts: on_interrupt() in the capture interrupt, the rest in the main loop.
class ReferenceInput {
 public:
  /// After the step clock has started.
  void set_up();

  /// For each edge calls `on_edge(tick)`. An edge that came before the last one was read is lost,
  /// as one that the reference left out.
  template <class OnEdge>
  void on_interrupt(OnEdge&& on_edge) {
    TimerRegisters& timer = tim1();
    if ((timer.SR & flag) == 0) return;
    timer.SR = ~(flag | lost_flag);
    on_edge(reference_tick(timer.CCR[reference_input.channel - 1]));
    edges_left_ = edges_left_ - 1;
    if (edges_left_ == 0) timer.DIER = 0;
  }
  /// Each millisecond: what comes faster than a reference may is looked at for part of the time
  /// only, and takes no more of the processor.
  void service();

 private:
  static constexpr std::uint32_t flag = timer_bits::CC(reference_input.channel);
  static constexpr std::uint32_t lost_flag = timer_bits::CCOF(reference_input.channel);
  /// Twice what the fastest reference has in a millisecond.
  static constexpr std::uint32_t edges_a_tick = 40;

  volatile std::uint32_t edges_left_ = edges_a_tick;
};

}  // namespace umov::boards::stm32f407
