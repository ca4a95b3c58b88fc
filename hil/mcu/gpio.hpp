// Ports A to E (RM0090 8), external interrupts (12) and their choice of port (9.2.3).
#pragma once

#include <array>
#include <optional>
#include <utility>

#include "hil/mcu/peripheral.hpp"

namespace umov::mcu {

/// Level of a pin changed at the scheduler's now(): as driven by the chip.
using PinChange = std::function<void(int port, int pin, bool level)>;

class Exti;

/// One port. A pin in alternate mode shows the level of its function's source.
class Gpio : public Peripheral {
 public:
  Gpio(int port, Exti& exti, PinChange on_change);

  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;

  /// Told of every change of a pin's level, whoever drives it.
  void listen(PinChange on_level) { on_level_ = std::move(on_level); }
  /// What the outside drives a pin to; empty: nothing, the pull decides.
  void drive(int pin, std::optional<bool> level);
  /// Output of the function `alternate` towards a pin, whether the pin uses it or not.
  void set_alternate(int pin, unsigned alternate, bool level);
  /// Whether the pin is in alternate mode with this function.
  bool uses_alternate(int pin, unsigned alternate) const;
  /// Level on the pin.
  bool level(int pin) const;
  /// Whether the chip drives the pin.
  bool is_output(int pin) const;

 private:
  unsigned mode(int pin) const { return moder_ >> 2 * pin & 3u; }
  /// Works out the levels of these pins and tells what has changed.
  void settle(std::uint32_t pins);
  void settle_pin(int pin);

  int port_;
  Exti* exti_;
  PinChange on_change_;
  PinChange on_level_;
  std::uint32_t moder_, otyper_ = 0, ospeedr_ = 0, pupdr_, odr_ = 0;
  std::array<std::uint32_t, 2> afr_{};
  std::array<std::optional<bool>, 16> driven_{};
  std::array<std::array<std::optional<bool>, 16>, 16> functions_{};  // pin, alternate
  std::uint32_t shown_ = 0;                                          // levels last told
  std::uint32_t outputs_ = 0;                                        // pins the chip drove then
};

/// External interrupt lines 0 to 16.
class Exti : public Peripheral {
 public:
  /// `lines(mask)`: levels of the requests pending, bit n = line n.
  explicit Exti(std::function<void(std::uint32_t pending)> lines);

  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;
  void on_edge(int port, int pin, bool rising);
  /// Line 16: the output of the supply's voltage detector changes.
  void on_supply_edge(bool rising);
  /// SYSCFG_EXTICR: which port a line listens to.
  void select(int line, int port) { port_of_[static_cast<std::size_t>(line)] = port; }
  int selected(int line) const { return port_of_[static_cast<std::size_t>(line)]; }

 private:
  void latch(std::uint32_t line, bool rising);

  std::function<void(std::uint32_t)> lines_;
  std::uint32_t imr_ = 0, emr_ = 0, rtsr_ = 0, ftsr_ = 0, pr_ = 0;
  std::array<int, 16> port_of_{};
};

class Syscfg : public Peripheral {
 public:
  explicit Syscfg(Exti& exti) : exti_(&exti) {}
  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;

 private:
  Exti* exti_;
};

}  // namespace umov::mcu
