// ADC1 and ADC2 in regular simultaneous mode, started by a timer's trigger (RM0090 13): one channel
// each, sampled at the same instant, the pair fetched by DMA.
#pragma once

#include "hil/mcu/peripheral.hpp"

namespace umov::mcu {

/// Voltage on an analog input as a 12-bit code, at the scheduler's now().
using AnalogInput = std::function<std::uint16_t(unsigned channel)>;

/// The block of both converters and their common registers, offset from ADC1.
class Adc : public Peripheral {
 public:
  /// `dma_request` returns false when no stream is ready to fetch.
  Adc(Scheduler& scheduler, std::function<Time()> apb2_cycle, AnalogInput input,
      std::function<bool()> dma_request, InterruptLine interrupt);

  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;
  /// Trigger number `source` of EXTSEL rises.
  void on_trigger(unsigned source);
  /// The master reports an overrun, as after a pair that nobody fetched in time.
  void overrun();
  /// The DMA stream has been switched on: a request that waits is served.
  void on_stream_enabled();

 private:
  struct Converter {
    std::uint32_t sr = 0, cr1 = 0, cr2 = 0, smpr1 = 0, smpr2 = 0, sqr1 = 0, sqr2 = 0, sqr3 = 0;
    std::uint32_t data = 0;
  };
  Time adc_cycle() const;
  Time sample_cycles(const Converter& c) const;
  static unsigned channel(const Converter& c) { return c.sqr3 & 31u; }
  void hold();
  void finish();
  void ask_for_dma();
  void tell_interrupt();

  Scheduler* scheduler_;
  std::function<Time()> apb2_cycle_;
  AnalogInput input_;
  std::function<bool()> dma_request_;
  InterruptLine interrupt_;
  Scheduler::Slot hold_slot_, finish_slot_;
  Converter master_, slave_;
  std::uint32_t ccr_ = 0;
  std::uint32_t held_ = 0;
  std::uint32_t pair_ = 0;
  bool converting_ = false;
  bool unread_ = false;
};

}  // namespace umov::mcu
