#include "boards/stm32f407/stm32_board.hpp"

#include <array>
#include <utility>

#include "boards/stm32f407/pins.hpp"
#include "boards/stm32f407/registers/core.hpp"
#include "boards/stm32f407/registers/watchdog.hpp"

namespace umov::boards::stm32f407 {
namespace {

enum class Edge : std::uint8_t { rising, falling };

/// An input whose edge interrupts by its EXTI line.
void configure_watched(Pin pin, Edge edge) {
  configure(pin, PinMode::input, Pull::down);
  const unsigned shift = 4u * (pin.number % 4u);
  change_bits(syscfg().EXTICR[pin.number / 4u], 15u << shift,
              static_cast<std::uint32_t>(pin.port) << shift);
  set_bits(edge == Edge::rising ? exti().RTSR : exti().FTSR, pin.mask());
  exti().PR = pin.mask();
  set_bits(exti().IMR, pin.mask());
}

/// The supply's voltage: EXTI line 16 rises when it falls below the detector's level.
void watch_supply() {
  set_bits(pwr().CR, pwr_bits::PLS_2V84 | pwr_bits::PVDE);
  set_bits(exti().RTSR, supply_line);
  exti().PR = supply_line;
  set_bits(exti().IMR, supply_line);
}

}  // namespace

void Stm32Board::set_up() {
  for (const Pin pin : laser_pins) configure_output(pin);
  for (const Pin pin : gain_pins) configure_output(pin);
  configure_output(shutter_pin);
  for (const Pin pin : {interlock_pin, emergency_pin, cool_pin}) {
    configure_watched(pin, Edge::falling);
  }
  watch_supply();
  for (const AxisPins& axis : axis_pins) {
    for (const Pin pin : {axis.home, axis.lower_limit, axis.upper_limit}) {
      configure(pin, PinMode::input, Pull::up);
    }
    configure_watched(axis.stall, Edge::rising);
  }
  steps_.set_up();
  sampling_.set_up();
  reference_.set_up();
  serial_.set_up();
}

std::uint64_t Stm32Board::time_us() const {
  // The clock wraps after 18 minutes; the main loop asks each millisecond.
  const std::uint32_t low = step_clock();
  if (low < clock_low_) ++clock_high_;
  clock_low_ = low;
  constexpr std::uint32_t ticks_per_us = firmware::step_timer_hz / 1'000'000;
  return (std::uint64_t{clock_high_} << 32 | low) / ticks_per_us;
}

void Stm32Board::set_direction(int axis, int direction) {
  drive(axis_pins[static_cast<std::size_t>(axis)].direction, direction > 0);
}

firmware::AxisInputs Stm32Board::switches(int axis) const {
  // Asked at every step: addresses and masks are worked out beforehand.
  struct Input {
    std::uintptr_t port;
    std::uint32_t mask;
    explicit constexpr Input(Pin pin) : port(gpio_base(pin.port)), mask(pin.mask()) {}
    bool read() const { return (at<GpioRegisters>(port).IDR & mask) != 0; }
  };
  struct Inputs {
    Input home, lower_limit, upper_limit;
  };
  static constexpr auto inputs = []<std::size_t... i>(std::index_sequence<i...>) {
    return std::array{Inputs{Input(axis_pins[i].home), Input(axis_pins[i].lower_limit),
                             Input(axis_pins[i].upper_limit)}...};
  }
  (std::make_index_sequence<axis_pins.size()>{});
  const Inputs& in = inputs[static_cast<std::size_t>(axis)];
  return {in.home.read(), in.lower_limit.read(), in.upper_limit.read()};
}

void Stm32Board::set_laser(int laser, bool on) {
  drive(laser_pins[static_cast<std::size_t>(laser)], on);
}

void Stm32Board::set_shutter(bool open) {
  drive(shutter_pin, open);
}

void Stm32Board::set_gain(int range) {
  for (unsigned i = 0; i < gain_pins.size(); ++i) {
    drive(gain_pins[i], (static_cast<unsigned>(range) >> i & 1u) != 0);
  }
}

bool Stm32Board::interlock_closed() const {
  return read(interlock_pin);
}
bool Stm32Board::emergency_released() const {
  return read(emergency_pin);
}
bool Stm32Board::overheated() const {
  return !read(cool_pin);
}
bool Stm32Board::supply_low() const {
  return (pwr().CSR & pwr_bits::PVDO) != 0;
}
bool Stm32Board::stalled(int axis) const {
  return read(axis_pins[static_cast<std::size_t>(axis)].stall);
}

void Stm32Board::mask_interrupts() {
  asm volatile("cpsid i" : : : "memory");
}

void Stm32Board::unmask_interrupts() {
  asm volatile("cpsie i" : : : "memory");
}

}  // namespace umov::boards::stm32f407
