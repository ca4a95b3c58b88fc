// Reset and clock control (RM0090 7) with power control's voltage scale (5.4.1): which clock each
// block has, and whether it has one at all.
#pragma once

#include <functional>
#include <utility>

#include "hil/mcu/peripheral.hpp"

namespace umov::mcu {

/// Why the chip starts; flags of RCC_CSR.
enum class ResetSource : std::uint8_t { power_on, brown_out, pin, software, watchdog };

class Rcc : public Peripheral {
 public:
  /// `crystal_hz`: HSE.
  Rcc(std::uint32_t crystal_hz, std::uint32_t reset_flags);

  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;

  /// Durations of a cycle. A clock that 336 MHz is no multiple of is refused (umov::Error).
  Time core_cycle() const;
  Time apb1_cycle() const;
  Time apb2_cycle() const;
  /// Timers run twice as fast as their bus unless that runs at the core's speed.
  Time apb1_timer_cycle() const;
  Time apb2_timer_cycle() const;

  /// Buses with clock gates, as the enable registers group them.
  enum class Bus : std::uint8_t { ahb1, ahb2, apb1, apb2 };
  bool enabled(Bus bus, unsigned bit) const;
  std::uint32_t reset_flags() const { return csr_; }

 private:
  double core_hz() const;
  static Time cycle(double hz);

  std::uint32_t crystal_hz_;
  std::uint32_t cr_ = 0x83, pllcfgr_ = 0x2400'3010, cfgr_ = 0;
  std::uint32_t ahb1enr_ = 0x0010'0000, ahb2enr_ = 0, apb1enr_ = 0, apb2enr_ = 0;
  std::uint32_t csr_;
};

/// Flags that a reset of this kind leaves in RCC_CSR, on top of those not cleared before.
std::uint32_t reset_flags_of(ResetSource source);

/// Voltage scale, and the detector that tells when the supply falls below a level (5.2.3).
class Pwr : public Peripheral {
 public:
  /// `on_detector(low)`: its output, when it changes.
  explicit Pwr(std::function<void(bool low)> on_detector) : on_detector_(std::move(on_detector)) {}
  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;
  void set_supply(std::uint32_t millivolts);

 private:
  void compare();

  std::function<void(bool)> on_detector_;
  std::uint32_t cr_ = 0x4000;
  std::uint32_t supply_mv_ = 3300;
  bool low_ = false;
};

}  // namespace umov::mcu
