#include "boards/stm32f407/sampling.hpp"

#include "boards/stm32f407/clock.hpp"
#include "boards/stm32f407/pins.hpp"
#include "boards/stm32f407/reference_input.hpp"
#include "boards/stm32f407/registers/adc.hpp"
#include "boards/stm32f407/registers/core.hpp"
#include "boards/stm32f407/registers/dma.hpp"
#include "boards/stm32f407/registers/timer.hpp"
#include "firmware/core/config/design_parameters.hpp"

namespace umov::boards::stm32f407 {
namespace {

constexpr std::uint32_t pair_mode =
    adc_bits::MULTI_REGULAR_SIMULTANEOUS | adc_bits::DDS | adc_bits::ADCPRE_DIV4;

constexpr std::uint32_t ticks_per_sample = apb2_timer_hz / firmware::sample_rate_hz;
static_assert(ticks_per_sample * firmware::sample_rate_hz == apb2_timer_hz);

// RM0090 table 43: ADC1 is stream 0 channel 0, TIM8_CH1 stream 2 channel 7.
constexpr unsigned pair_stream = 0, level_stream = 2;
constexpr std::uint32_t pair_control = dma_bits::CHSEL(0) | dma_bits::PRIORITY_VERY_HIGH |
                                       dma_bits::MSIZE_WORD | dma_bits::PSIZE_WORD |
                                       dma_bits::MINC | dma_bits::CIRC | dma_bits::TCIE |
                                       dma_bits::HTIE | dma_bits::TEIE;
constexpr std::uint32_t level_control =
    dma_bits::CHSEL(7) | dma_bits::PRIORITY_VERY_HIGH | dma_bits::MSIZE_WORD |
    dma_bits::PSIZE_WORD | dma_bits::MINC | dma_bits::CIRC | dma_bits::MEMORY_TO_PERIPHERAL;

/// 28 cycles of 21 MHz: the source behind the pins may have up to 10 kOhm.
constexpr std::uint32_t sample_time = 2;

/// From the trigger to the moment at which the voltage is held, in ticks of the timers.
constexpr std::uint32_t hold_ticks = 28 * 4 * (apb2_timer_hz / apb2_hz);

/// DMA reads and writes memory behind the compiler's back.
void memory_is_shared() {
  asm volatile("dmb" : : : "memory");
}

std::uint32_t address(const volatile void* place) {
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(place));
}

void stop_stream(unsigned stream) {
  DmaRegisters& dma = dma2();
  clear_bits(dma.stream[stream].CR, dma_bits::EN);
  while ((dma.stream[stream].CR & dma_bits::EN) != 0) {
  }
  dma.IFCR[stream / 4] = dma_bits::ALL << dma_bits::flag_shift(stream);
}

void start_stream(unsigned stream, std::uint32_t control, volatile std::uint32_t& peripheral,
                  const std::uint32_t* memory, std::uint32_t words) {
  DmaStreamRegisters& s = dma2().stream[stream];
  s.PAR = address(&peripheral);
  s.M0AR = address(memory);
  s.NDTR = words;
  s.CR = control;
  s.CR = control | dma_bits::EN;
}

void sample_input(AdcRegisters& adc, AnalogInput input) {
  if (input.channel >= 10) {
    adc.SMPR1 = sample_time << 3 * (input.channel - 10);
  } else {
    adc.SMPR2 = sample_time << 3 * input.channel;
  }
  adc.SQR1 = 0;
  adc.SQR3 = input.channel;
}

}  // namespace

void Sampling::set_up() {
  configure_output(modulation_pin);
  configure(signal_input.pin, PinMode::analog);
  configure(monitor_input.pin, PinMode::analog);
  adc_common().CCR = pair_mode;
  sample_input(adc1(), signal_input);
  sample_input(adc2(), monitor_input);
  adc1().CR1 = adc_bits::OVRIE;
  adc1().CR2 = adc_bits::EXTSEL_TIM8_TRGO | adc_bits::EXTEN_RISING | adc_bits::ADON;
  adc2().CR2 = adc_bits::ADON;

  TimerRegisters& timer = tim8();
  timer.CR1 = timer_bits::URS;
  timer.CR2 = timer_bits::MMS_UPDATE;
  timer.PSC = 0;
  timer.ARR = ticks_per_sample - 1;
  timer.CCR[0] = ticks_per_sample / 2;
  timer.DIER = timer_bits::CC1DE;
}

std::uint32_t Sampling::start(std::uint32_t phase_step) {
  stop();
  phase_ = 0;
  next_half_ = 0;
  phase_step_ = phase_step;
  refill(0);
  refill(1);
  // A pair that was converted after the last stop still asks for DMA: without the mode it no longer
  // does, and sample 0 is the first one fetched.
  adc_common().CCR = pair_mode;
  adc1().SR = 0;
  adc_common().CCR = pair_mode | adc_bits::DMA_MODE_2;
  start_stream(pair_stream, pair_control, adc_common().CDR, pairs_.data(), pairs_.size());
  start_stream(level_stream, level_control, gpio(modulation_pin.port).BSRR, levels_.data(),
               levels_.size());
  running_ = true;
  const CriticalSection alone;
  // The next tick is the compare channel's: the level of sample 0.
  tim8().CNT = ticks_per_sample / 2 - 1;
  tim8().CR1 = timer_bits::URS | timer_bits::CEN;
  // Read between two readings of the other clock: on the way to a timer each takes the same time.
  const std::uint32_t before = tim1().CNT;
  const std::uint32_t count = tim8().CNT;
  const std::uint32_t after = tim1().CNT;
  const std::uint32_t moment = before + ((after - before) & 0xFFFF) / 2;
  return reference_tick(moment) + ticks_per_sample - count + hold_ticks;
}

void Sampling::stop() {
  const CriticalSection alone;
  running_ = false;
  tim8().CR1 = timer_bits::URS;
  stop_stream(pair_stream);
  stop_stream(level_stream);
  drive(modulation_pin, false);
}

bool Sampling::full(unsigned half) const {
  const std::uint32_t flag = half == 0 ? dma_bits::HTIF : dma_bits::TCIF;
  return running_ && (dma2().ISR[0] >> dma_bits::flag_shift(pair_stream) & flag) != 0;
}

bool Sampling::take_flag(unsigned half) {
  if (!full(half)) return false;
  const std::uint32_t flag = half == 0 ? dma_bits::HTIF : dma_bits::TCIF;
  dma2().IFCR[0] = flag << dma_bits::flag_shift(pair_stream);
  return true;
}

bool Sampling::failed() const {
  return (dma2().ISR[0] >> dma_bits::flag_shift(pair_stream) & dma_bits::TEIF) != 0;
}

bool Sampling::take_overrun() {
  if ((adc1().SR & adc_bits::OVR) == 0) return false;
  adc1().SR = ~adc_bits::OVR;
  return true;
}

void Sampling::separate(unsigned half) {
  memory_is_shared();
  const std::uint32_t* pair = pairs_.data() + half * block_samples;
  for (std::size_t i = 0; i < block_samples; ++i) {
    signal_[i] = static_cast<std::uint16_t>(pair[i]);
    monitor_[i] = static_cast<std::uint16_t>(pair[i] >> 16);
  }
}

void Sampling::refill(unsigned half) {
  constexpr std::uint32_t light = set_reset_word(modulation_pin, true);
  constexpr std::uint32_t dark = set_reset_word(modulation_pin, false);
  std::uint32_t phase = phase_;
  std::uint32_t* level = levels_.data() + half * block_samples;
  for (std::size_t i = 0; i < block_samples; ++i) {
    level[i] = phase < 0x8000'0000u ? light : dark;
    phase += phase_step_;
  }
  phase_ = phase;
  memory_is_shared();
}

}  // namespace umov::boards::stm32f407
