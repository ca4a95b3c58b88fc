#include "hil/mcu/gpio.hpp"

#include <utility>

namespace umov::mcu {
namespace {

constexpr std::uint32_t moder = 0x00, otyper = 0x04, ospeedr = 0x08, pupdr = 0x0C, idr = 0x10,
                        odr = 0x14, bsrr = 0x18, afrl = 0x20, afrh = 0x24;
constexpr unsigned output_mode = 1, alternate_mode = 2, analog_mode = 3;

}  // namespace

Gpio::Gpio(int port, Exti& exti, PinChange on_change)
    : port_(port),
      exti_(&exti),
      on_change_(std::move(on_change)),
      moder_(port == 0   ? 0xA800'0000
             : port == 1 ? 0x0000'0280
                         : 0),
      pupdr_(port == 0   ? 0x6400'0000
             : port == 1 ? 0x0000'0100
                         : 0) {
  settle(0xFFFF);
}

bool Gpio::uses_alternate(int pin, unsigned alternate) const {
  return mode(pin) == alternate_mode &&
         (afr_[static_cast<std::size_t>(pin / 8)] >> 4 * (pin % 8) & 15u) == alternate;
}

bool Gpio::is_output(int pin) const {
  if (mode(pin) == output_mode) return true;
  if (mode(pin) != alternate_mode) return false;
  const unsigned af = afr_[static_cast<std::size_t>(pin / 8)] >> 4 * (pin % 8) & 15u;
  return functions_[static_cast<std::size_t>(pin)][af].has_value();
}

bool Gpio::level(int pin) const {
  const auto p = static_cast<std::size_t>(pin);
  if (mode(pin) == output_mode) return (odr_ >> pin & 1u) != 0;
  if (mode(pin) == alternate_mode) {
    const unsigned af = afr_[p / 8] >> 4 * (pin % 8) & 15u;
    if (functions_[p][af]) return *functions_[p][af];
  }
  if (mode(pin) == analog_mode) return false;  // the Schmitt trigger is off
  if (driven_[p]) return *driven_[p];
  return (pupdr_ >> 2 * pin & 3u) == 1;
}

void Gpio::settle(std::uint32_t pins) {
  for (int pin = 0; pin < 16; ++pin) {
    if ((pins >> pin & 1u) != 0) settle_pin(pin);
  }
}

void Gpio::settle_pin(int pin) {
  const std::uint32_t bit = 1u << pin;
  const bool now = level(pin), before = (shown_ & bit) != 0;
  const bool out = is_output(pin), was_out = (outputs_ & bit) != 0;
  if (now == before && out == was_out) return;
  shown_ = now ? shown_ | bit : shown_ & ~bit;
  outputs_ = out ? outputs_ | bit : outputs_ & ~bit;
  if (now != before) exti_->on_edge(port_, pin, now);
  if (now != before && on_level_) on_level_(port_, pin, now);
  if (out || was_out) on_change_(port_, pin, out && now);
}

void Gpio::drive(int pin, std::optional<bool> level) {
  auto& driven = driven_[static_cast<std::size_t>(pin)];
  if (driven == level) return;
  driven = level;
  settle_pin(pin);
}

void Gpio::set_alternate(int pin, unsigned alternate, bool level) {
  auto& function = functions_[static_cast<std::size_t>(pin)][alternate];
  if (function == level) return;
  function = level;
  if (uses_alternate(pin, alternate)) settle_pin(pin);
}

std::uint32_t Gpio::read(std::uint32_t offset) {
  switch (offset) {
    case moder:
      return moder_;
    case otyper:
      return otyper_;
    case ospeedr:
      return ospeedr_;
    case pupdr:
      return pupdr_;
    case idr:
      return shown_;
    case odr:
      return odr_;
    case bsrr:
      return 0;
    case afrl:
      return afr_[0];
    case afrh:
      return afr_[1];
    default:
      refuse_register("GPIO", offset);
  }
}

void Gpio::write(std::uint32_t offset, std::uint32_t value) {
  switch (offset) {
    case moder:
      moder_ = value;
      break;
    case otyper:
      if (value != 0) refuse_setting("GPIO", "OTYPER (open drain)", value);
      otyper_ = value;
      break;
    case ospeedr:
      ospeedr_ = value;
      break;
    case pupdr:
      pupdr_ = value;
      break;
    case odr:
      odr_ = value & 0xFFFF;
      break;
    case bsrr:
      odr_ = (odr_ & ~(value >> 16)) | (value & 0xFFFF);  // set wins over reset
      return settle(value | value >> 16);
    case afrl:
      afr_[0] = value;
      break;
    case afrh:
      afr_[1] = value;
      break;
    default:
      refuse_register("GPIO", offset);
  }
  settle(0xFFFF);
}

Exti::Exti(std::function<void(std::uint32_t)> lines) : lines_(std::move(lines)) {}

void Exti::on_edge(int port, int pin, bool rising) {
  if (selected(pin) == port) latch(1u << pin, rising);
}

void Exti::on_supply_edge(bool rising) {
  latch(1u << 16, rising);
}

void Exti::latch(std::uint32_t line, bool rising) {
  if (((rising ? rtsr_ : ftsr_) & line) == 0) return;
  pr_ |= line;
  lines_(pr_ & imr_);
}

std::uint32_t Exti::read(std::uint32_t offset) {
  switch (offset) {
    case 0x00:
      return imr_;
    case 0x04:
      return emr_;
    case 0x08:
      return rtsr_;
    case 0x0C:
      return ftsr_;
    case 0x10:
      return 0;
    case 0x14:
      return pr_;
    default:
      refuse_register("EXTI", offset);
  }
}

void Exti::write(std::uint32_t offset, std::uint32_t value) {
  switch (offset) {
    case 0x00:
      imr_ = value;
      break;
    case 0x04:
      if (value != 0) refuse_setting("EXTI", "EMR", value);
      break;
    case 0x08:
      rtsr_ = value;
      break;
    case 0x0C:
      ftsr_ = value;
      break;
    case 0x10:
      pr_ |= value & imr_;
      break;
    case 0x14:
      pr_ &= ~value;
      break;
    default:
      refuse_register("EXTI", offset);
  }
  lines_(pr_ & imr_);
}

std::uint32_t Syscfg::read(std::uint32_t offset) {
  if (offset < 0x08 || offset > 0x14) refuse_register("SYSCFG", offset);
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) {
    const int line = static_cast<int>(offset - 0x08) + i;
    value |= static_cast<std::uint32_t>(exti_->selected(line)) << 4 * i;
  }
  return value;
}

void Syscfg::write(std::uint32_t offset, std::uint32_t value) {
  if (offset < 0x08 || offset > 0x14) refuse_register("SYSCFG", offset);
  for (int i = 0; i < 4; ++i) {
    exti_->select(static_cast<int>(offset - 0x08) + i, static_cast<int>(value >> 4 * i & 15u));
  }
}

}  // namespace umov::mcu
