// A timer that counts up: TIM2 and TIM5 with 32 bits, TIM1 and TIM8 with 16 (RM0090 17, 18).
// Channels compare, with interrupt, DMA request and output, or capture the rising edges of their
// own input, with interrupt; update with trigger. No filter, prescaler or falling edge of a
// capture, no down- or one-pulse counting, no repetition.
#pragma once

#include <array>

#include "hil/mcu/peripheral.hpp"

namespace umov::mcu {

class Timer : public Peripheral {
 public:
  /// Where a timer's lines go; empty ones nowhere.
  struct Wires {
    InterruptLine interrupt;
    std::function<void(int channel)> dma_request;            ///< channel 1 to 4
    Pulse trigger;                                           ///< TRGO
    std::function<void(int channel, bool level)> on_output;  ///< OCx as enabled by CCER
  };
  /// `top`: largest count. `cycle`: duration of a cycle of the timer's clock.
  Timer(const char* name, std::uint32_t top, Scheduler& scheduler, std::function<Time()> cycle,
        Wires wires);

  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;
  /// The input of a channel, 1 to 4, rises at the scheduler's now().
  void rise(int channel);

 private:
  struct Channel {
    std::uint32_t compare = 0;  ///< or what was captured
    bool captures = false;
    unsigned mode = 0;  ///< OCxM
    bool reference = false;
    bool shown = false;
  };

  bool running() const { return (cr1_ & 1u) != 0; }
  std::uint32_t count() const;
  void set_count(std::uint32_t value);
  void plan();
  void happen();
  void match(int channel);
  void update();
  void show_outputs();
  void change_modes();
  void tell_interrupt() { wires_.interrupt((sr_ & dier_ & 0x1Fu) != 0); }

  const char* name_;
  std::uint32_t top_;
  Scheduler* scheduler_;
  std::function<Time()> cycle_;
  Wires wires_;
  Scheduler::Slot slot_;
  std::uint32_t cr1_ = 0, cr2_ = 0, dier_ = 0, sr_ = 0, ccer_ = 0, arr_;
  std::array<std::uint32_t, 2> ccmr_{};
  std::uint32_t prescaler_ = 0, prescaler_next_ = 0;
  std::array<Channel, 4> channels_{};
  // While running the count was `base_count_` at `base_time_` and grows by one a tick.
  std::uint32_t base_count_ = 0;
  Time base_time_ = 0;
  Time tick_ = 1;
};

}  // namespace umov::mcu
