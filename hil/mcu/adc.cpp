#include "hil/mcu/adc.hpp"

#include <array>
#include <utility>

namespace umov::mcu {
namespace {

constexpr std::uint32_t slave_offset = 0x100, csr = 0x300, ccr = 0x304, cdr = 0x308;
constexpr std::uint32_t sr = 0x00, cr1 = 0x04, cr2 = 0x08, smpr1 = 0x0C, smpr2 = 0x10, sqr1 = 0x2C,
                        sqr2 = 0x30, sqr3 = 0x34, dr = 0x4C;
constexpr std::uint32_t eoc = 2, strt = 16, ovr = 32, ovr_interrupt = 1u << 26, on = 1;
constexpr std::uint32_t modelled_cr1 = ovr_interrupt;
constexpr std::uint32_t modelled_cr2 = on | 0x3F00'0000;  // EXTSEL, EXTEN

}  // namespace

Adc::Adc(Scheduler& scheduler, std::function<Time()> apb2_cycle, AnalogInput input,
         std::function<bool()> dma_request, InterruptLine interrupt)
    : scheduler_(&scheduler),
      apb2_cycle_(std::move(apb2_cycle)),
      input_(std::move(input)),
      dma_request_(std::move(dma_request)),
      interrupt_(std::move(interrupt)),
      hold_slot_(scheduler.add([this] { hold(); })),
      finish_slot_(scheduler.add([this] { finish(); })) {}

Time Adc::adc_cycle() const {
  return apb2_cycle_() * 2 * ((ccr_ >> 16 & 3u) + 1);
}

Time Adc::sample_cycles(const Converter& c) const {
  constexpr std::array<Time, 8> cycles = {3, 15, 28, 56, 84, 112, 144, 480};
  const unsigned n = channel(c);
  const std::uint32_t field = n >= 10 ? c.smpr1 >> 3 * (n - 10) : c.smpr2 >> 3 * n;
  return cycles[field & 7u];
}

void Adc::on_trigger(unsigned source) {
  const bool listens = (master_.cr2 >> 28 & 3u) == 1 && (master_.cr2 >> 24 & 15u) == source;
  if (!listens || (master_.cr2 & on) == 0 || (slave_.cr2 & on) == 0 || converting_) return;
  if ((ccr_ & 31u) != 6) refuse_setting("ADC", "CCR (other than regular simultaneous)", ccr_);
  // After an overrun in DMA mode conversions wait until it has been acknowledged.
  if ((master_.sr & ovr) != 0) return;
  converting_ = true;
  master_.sr |= strt;
  slave_.sr |= strt;
  scheduler_->set(hold_slot_, scheduler_->now() + sample_cycles(master_) * adc_cycle());
}

void Adc::hold() {
  held_ = static_cast<std::uint32_t>(input_(channel(master_)) & 0xFFF) |
          static_cast<std::uint32_t>(input_(channel(slave_)) & 0xFFF) << 16;
  constexpr Time conversion_cycles = 12;
  scheduler_->set(finish_slot_, scheduler_->now() + conversion_cycles * adc_cycle());
}

void Adc::finish() {
  converting_ = false;
  if (unread_ && (ccr_ >> 14 & 3u) != 0) return overrun();
  pair_ = held_;
  master_.data = held_ & 0xFFFF;
  slave_.data = held_ >> 16;
  master_.sr |= eoc;
  slave_.sr |= eoc;
  unread_ = true;
  ask_for_dma();
}

void Adc::overrun() {
  master_.sr |= ovr;
  tell_interrupt();
}

void Adc::ask_for_dma() {
  if (unread_ && (ccr_ >> 14 & 3u) == 2) dma_request_();
}

void Adc::on_stream_enabled() {
  ask_for_dma();
}

void Adc::tell_interrupt() {
  interrupt_((master_.sr & ovr) != 0 && (master_.cr1 & ovr_interrupt) != 0);
}

std::uint32_t Adc::read(std::uint32_t offset) {
  switch (offset) {
    case csr:
      return master_.sr | slave_.sr << 8;
    case ccr:
      return ccr_;
    case cdr:
      unread_ = false;
      master_.sr &= ~eoc;
      slave_.sr &= ~eoc;
      return pair_;
    default:
      break;
  }
  if (offset >= slave_offset + 0x50) refuse_register("ADC", offset);
  Converter& c = offset >= slave_offset ? slave_ : master_;
  switch (offset % slave_offset) {
    case sr:
      return c.sr;
    case cr1:
      return c.cr1;
    case cr2:
      return c.cr2;
    case smpr1:
      return c.smpr1;
    case smpr2:
      return c.smpr2;
    case sqr1:
      return c.sqr1;
    case sqr2:
      return c.sqr2;
    case sqr3:
      return c.sqr3;
    case dr:
      c.sr &= ~eoc;
      return c.data;
    default:
      refuse_register("ADC", offset);
  }
}

void Adc::write(std::uint32_t offset, std::uint32_t value) {
  if (offset == ccr) {
    if ((value & ~0x0003'E01Fu) != 0) refuse_setting("ADC", "CCR", value);
    ccr_ = value;
    if ((ccr_ >> 14 & 3u) == 0) unread_ = false;  // a request that waits is withdrawn
    return;
  }
  if (offset >= slave_offset + 0x50) refuse_register("ADC", offset);
  Converter& c = offset >= slave_offset ? slave_ : master_;
  switch (offset % slave_offset) {
    case sr:
      c.sr &= value;
      break;
    case cr1:
      if ((value & ~modelled_cr1) != 0) refuse_setting("ADC", "CR1", value);
      c.cr1 = value;
      break;
    case cr2:
      if ((value & ~modelled_cr2) != 0) refuse_setting("ADC", "CR2", value);
      c.cr2 = value;
      break;
    case smpr1:
      c.smpr1 = value;
      break;
    case smpr2:
      c.smpr2 = value;
      break;
    case sqr1:
      if (value != 0) refuse_setting("ADC", "SQR1 (more than one conversion)", value);
      c.sqr1 = value;
      break;
    case sqr2:
      c.sqr2 = value;
      break;
    case sqr3:
      c.sqr3 = value;
      break;
    default:
      refuse_register("ADC", offset);
  }
  tell_interrupt();
}

}  // namespace umov::mcu
