#include "hil/mcu/rcc.hpp"

#include <array>
#include <cmath>
#include <string>

#include "host/errors/error.hpp"

namespace umov::mcu {
namespace {

constexpr std::uint32_t cr = 0x00, pllcfgr = 0x04, cfgr = 0x08, ahb1enr = 0x30, ahb2enr = 0x34,
                        apb1enr = 0x40, apb2enr = 0x44, csr = 0x74;
constexpr std::uint32_t hse_on = 1u << 16, pll_on = 1u << 24;
constexpr std::uint32_t remove_flags = 1u << 24, all_flags = 0xFE00'0000;

/// Divider of a prescaler field: the bus runs undivided below `first`.
double divider(std::uint32_t field, std::uint32_t first) {
  return field < first ? 1.0 : std::exp2(static_cast<double>(field - first + 1));
}

}  // namespace

std::uint32_t reset_flags_of(ResetSource source) {
  constexpr std::uint32_t brown_out = 1u << 25, pin = 1u << 26, power = 1u << 27,
                          software = 1u << 28, watchdog = 1u << 29;
  switch (source) {
    case ResetSource::power_on:
      return power | brown_out | pin;
    case ResetSource::brown_out:
      return brown_out | pin;
    case ResetSource::pin:
      return pin;
    case ResetSource::software:
      return software | pin;
    case ResetSource::watchdog:
      return watchdog | pin;
  }
  return 0;
}

Rcc::Rcc(std::uint32_t crystal_hz, std::uint32_t reset_flags)
    : crystal_hz_(crystal_hz), csr_(reset_flags) {}

double Rcc::core_hz() const {
  constexpr double internal_hz = 16e6;
  double hz = internal_hz;
  switch (cfgr_ & 3u) {
    case 0:
      break;
    case 1:
      hz = crystal_hz_;
      break;
    case 2: {
      const double source = (pllcfgr_ >> 22 & 1u) != 0 ? crystal_hz_ : internal_hz;
      const double m = pllcfgr_ & 63u, n = pllcfgr_ >> 6 & 511u,
                   p = 2.0 * ((pllcfgr_ >> 16 & 3u) + 1);
      hz = source / m * n / p;
      break;
    }
    default:
      refuse_setting("RCC", "CFGR", cfgr_);
  }
  if ((cfgr_ >> 4 & 15u) >= 8) refuse_setting("RCC", "CFGR", cfgr_);  // core slower than the clock
  return hz;
}

Time Rcc::cycle(double hz) {
  const double units = static_cast<double>(time_per_second) / hz;
  if (!(hz > 0) || hz > 168e6 || std::abs(units - std::round(units)) > 1e-9) {
    throw Error("a clock of " + std::to_string(hz) + " Hz can't be emulated",
                "use one of at most 168 MHz of which 336 MHz is a multiple");
  }
  return static_cast<Time>(std::llround(units));
}

Time Rcc::core_cycle() const {
  return cycle(core_hz());
}
Time Rcc::apb1_cycle() const {
  return cycle(core_hz() / divider(cfgr_ >> 10 & 7u, 4));
}
Time Rcc::apb2_cycle() const {
  return cycle(core_hz() / divider(cfgr_ >> 13 & 7u, 4));
}
Time Rcc::apb1_timer_cycle() const {
  return (cfgr_ >> 10 & 7u) < 4 ? apb1_cycle() : apb1_cycle() / 2;
}
Time Rcc::apb2_timer_cycle() const {
  return (cfgr_ >> 13 & 7u) < 4 ? apb2_cycle() : apb2_cycle() / 2;
}

bool Rcc::enabled(Bus bus, unsigned bit) const {
  const std::uint32_t gates = bus == Bus::ahb1   ? ahb1enr_
                              : bus == Bus::ahb2 ? ahb2enr_
                              : bus == Bus::apb1 ? apb1enr_
                                                 : apb2enr_;
  return (gates >> bit & 1u) != 0;
}

std::uint32_t Rcc::read(std::uint32_t offset) {
  switch (offset) {
    case cr:
      // Oscillator and PLL are ready as soon as they are on.
      return cr_ | (cr_ & hse_on) << 1 | (cr_ & pll_on) << 1;
    case pllcfgr:
      return pllcfgr_;
    case cfgr:
      return cfgr_ | (cfgr_ & 3u) << 2;
    case ahb1enr:
      return ahb1enr_;
    case ahb2enr:
      return ahb2enr_;
    case apb1enr:
      return apb1enr_;
    case apb2enr:
      return apb2enr_;
    case csr:
      return csr_;
    default:
      refuse_register("RCC", offset);
  }
}

void Rcc::write(std::uint32_t offset, std::uint32_t value) {
  switch (offset) {
    case cr:
      cr_ = value & ~(hse_on << 1 | pll_on << 1);
      return;
    case pllcfgr:
      if ((cr_ & pll_on) != 0) refuse_setting("RCC", "PLLCFGR while the PLL runs", value);
      pllcfgr_ = value;
      return;
    case cfgr: {
      const std::uint32_t wanted = value & 3u;
      if ((wanted == 1 && (cr_ & hse_on) == 0) || (wanted == 2 && (cr_ & pll_on) == 0))
        refuse_setting("RCC", "CFGR before that clock is on", value);
      cfgr_ = value & ~12u;
      core_cycle();  // refused here rather than later
      return;
    }
    case ahb1enr:
      ahb1enr_ = value;
      return;
    case ahb2enr:
      ahb2enr_ = value;
      return;
    case apb1enr:
      apb1enr_ = value;
      return;
    case apb2enr:
      apb2enr_ = value;
      return;
    case csr:
      if ((value & remove_flags) != 0) csr_ &= ~all_flags;
      return;
    default:
      refuse_register("RCC", offset);
  }
}

std::uint32_t Pwr::read(std::uint32_t offset) {
  switch (offset) {
    case 0:
      return cr_;
    case 4:
      return ((cr_ & 0x4000u) != 0 ? 0x4000u : 0u) | (low_ ? 4u : 0u);  // scale ready, PVDO
    default:
      refuse_register("PWR", offset);
  }
}

void Pwr::write(std::uint32_t offset, std::uint32_t value) {
  if (offset != 0) refuse_register("PWR", offset);
  // Voltage scale, backup access, voltage detector: nothing of the low-power modes.
  if ((value & ~0x41F0u) != 0) refuse_setting("PWR", "CR", value);
  cr_ = value;
  compare();
}

void Pwr::set_supply(std::uint32_t millivolts) {
  supply_mv_ = millivolts;
  compare();
}

void Pwr::compare() {
  // Datasheet table 19, falling edges, typical.
  constexpr std::array<std::uint32_t, 8> level_mv = {2040, 2190, 2350, 2510,
                                                     2660, 2840, 2930, 3030};
  const bool low = (cr_ & 0x10u) != 0 && supply_mv_ < level_mv[cr_ >> 5 & 7u];
  if (low == low_) return;
  low_ = low;
  on_detector_(low);
}

}  // namespace umov::mcu
