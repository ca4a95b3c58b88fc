// Signal and monitor sampled at the same instants, with the modulation that goes with them.
//
// TIM8 runs at the sample rate. Its update triggers ADC1 and ADC2 together; DMA stores the pairs.
// Half a sample earlier its compare channel lets a second DMA stream write the modulation's level
// for that sample, so that light is steady when it is sampled, to the tick, without an interrupt.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace umov::boards::stm32f407 {

class Sampling {
 public:
  /// Pairs handed to the core at a time: 2.5 ms at 100 kS/s.
  static constexpr std::size_t block_samples = 250;

  void set_up();
  /// Sample 0 comes half a sample from now. Returns the tick of the reference clock at which its
  /// voltage is held.
  std::uint32_t start(std::uint32_t phase_step);
  /// Any context; the modulation ends dark.
  void stop();

  /// Interrupt of the pairs' DMA stream: calls `on_block(signal, monitor)` for the block that is
  /// full. False when samples were lost, were merged with later ones, or the modulation was not
  /// written in time; sampling has stopped then.
  template <class OnBlock>
  bool on_interrupt(OnBlock&& on_block) {
    if (!running_) return true;
    const unsigned half = next_half_;
    // Halves fill in turn. The other one full as well: the interrupt came more than a block late,
    // and what is in this half has been, or is being, overwritten.
    if (failed() || full(1 - half)) return false;
    if (!take_flag(half)) return true;
    next_half_ = 1 - half;
    separate(half);
    refill(half);
    if (full(1 - half)) return false;  // it took until the DMA came back to this half
    on_block(std::span<const std::uint16_t>(signal_), std::span<const std::uint16_t>(monitor_));
    return true;
  }
  /// ADC interrupt: true when a conversion was not fetched in time, whatever for.
  bool take_overrun();

 private:
  bool full(unsigned half) const;
  bool take_flag(unsigned half);
  bool failed() const;
  void separate(unsigned half);
  void refill(unsigned half);

  std::array<std::uint32_t, 2 * block_samples> pairs_{};
  std::array<std::uint32_t, 2 * block_samples> levels_{};
  std::array<std::uint16_t, block_samples> signal_{};
  std::array<std::uint16_t, block_samples> monitor_{};
  unsigned next_half_ = 0;
  std::uint32_t phase_ = 0;
  std::uint32_t phase_step_ = 0;
  volatile bool running_ = false;
};

}  // namespace umov::boards::stm32f407
