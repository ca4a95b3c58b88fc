#include "hil/mcu/stm32f407.hpp"

#include <algorithm>

#include "hil/mcu/chip_core.hpp"
#include "host/errors/error.hpp"

namespace umov::mcu {

Stm32f407::Stm32f407(Surroundings& surroundings, ChipOptions options)
    : surroundings_(&surroundings),
      options_(options),
      flash_(Flash::size, 0xFF),
      sram_(sram_size),
      ccm_(ccm_size),
      system_(system_size) {
  for (std::size_t i = 0; i < 12; ++i) {
    system_[unique_id_offset + i] =
        static_cast<std::uint8_t>(options.unique_id[i / 4] >> 8 * (i % 4));
  }
}

Stm32f407::~Stm32f407() = default;

void Stm32f407::flash(std::span<const Segment> image) {
  for (const Segment& segment : image) {
    const std::uint64_t offset = segment.address - std::uint64_t{Flash::base};
    if (segment.address < Flash::base || offset + segment.bytes.size() > Flash::size)
      throw Error("the image has a part at " + hexadecimal(segment.address) + " outside the flash",
                  "give an image linked for the board");
    std::copy(segment.bytes.begin(), segment.bytes.end(),
              flash_.begin() + static_cast<std::ptrdiff_t>(offset));
  }
}

void Stm32f407::protect_flash(std::uint32_t sectors) {
  protected_sectors_ = sectors;
  if (core_) core_->flash.protect(sectors);
}

void Stm32f407::reset(ResetSource source) {
  stands_until_ = 0;
  const Time at = core_ ? core_->cpu.now() : 0;
  if (core_) reset_flags_ = core_->rcc.reset_flags();
  reset_flags_ |= reset_flags_of(source);
  // Pins fall back to inputs.
  if (core_) {
    for (int port = 0; port < 5; ++port) {
      for (int pin = 0; pin < 16; ++pin) {
        if (core_->port(port).is_output(pin) && core_->port(port).level(pin))
          surroundings_->on_pin(port, pin, false, at);
      }
    }
  }
  if (source == ResetSource::power_on) {
    reset_flags_ = reset_flags_of(source);
    std::fill(sram_.begin(), sram_.end(), std::uint8_t{0xA5});  // anything but zero
    std::fill(ccm_.begin(), ccm_.end(), std::uint8_t{0xA5});
  }
  core_ = std::make_unique<Core>(*this, at);
  core_->flash.protect(protected_sectors_);
  core_->cpu.reset(Flash::base);
  in_rom_ = boot0_;
  for (const std::uint32_t address : breakpoints_) core_->cpu.add_breakpoint(address);
}

void Stm32f407::set_nrst(bool high) {
  if (high == nrst_) return;
  nrst_ = high;
  reset(ResetSource::pin);
}

void Stm32f407::step() {
  Core& c = *core_;
  c.scheduler.run_until(c.cpu.now());
  if (runs_program()) c.cpu.step();
  c.cpu.take_breakpoint();
}

void Stm32f407::set_breakpoint(std::uint32_t address, bool on) {
  if (on) {
    breakpoints_.insert(address);
    if (core_) core_->cpu.add_breakpoint(address);
  } else {
    breakpoints_.erase(address);
    if (core_) core_->cpu.remove_breakpoint(address);
  }
}

void Stm32f407::clear_breakpoints() {
  while (!breakpoints_.empty()) set_breakpoint(*breakpoints_.begin(), false);
}

std::uint32_t Stm32f407::debug_register(int number) const {
  return core_ ? core_->cpu.debug_register(number) : 0;
}

void Stm32f407::set_debug_register(int number, std::uint32_t value) {
  if (core_) core_->cpu.set_debug_register(number, value);
}

std::vector<std::uint8_t> Stm32f407::read_memory(std::uint32_t address, std::uint32_t size) const {
  const std::uint8_t* from = core_ ? core_->cpu.find_memory(address, size) : nullptr;
  if (from == nullptr) return {};
  return {from, from + size};
}

bool Stm32f407::write_memory(std::uint32_t address, std::span<const std::uint8_t> bytes) {
  if (address < sram_base || address - sram_base + bytes.size() > sram_size) return false;
  std::copy(bytes.begin(), bytes.end(),
            sram_.begin() + static_cast<std::ptrdiff_t>(address - sram_base));
  return true;
}

Time Stm32f407::now() const {
  return core_ ? core_->cpu.now() : 0;
}

void Stm32f407::run_until(Time limit) {
  if (!core_) reset(ResetSource::power_on);
  paused_ = false;
  while (core_->cpu.now() < limit && !paused_ && !halted_) {
    Core& c = *core_;
    c.scheduler.run_until(c.cpu.now());
    if (c.watchdog_expired) {
      ++watchdog_resets_;
      reset(ResetSource::watchdog);
      continue;
    }
    if (c.nvic.reset_requested()) {
      ++software_resets_;
      reset(ResetSource::software);
      continue;
    }
    if (paused_) break;
    if (c.cpu.now() < stands_until_) {
      c.cpu.skip_to(std::min({limit, c.scheduler.next(), stands_until_}));
      continue;
    }
    if (!runs_program()) {
      c.cpu.skip_to(std::min(limit, c.scheduler.next()));
      continue;
    }
    c.cpu.run(std::min(limit, c.scheduler.next()));
    if (c.cpu.take_breakpoint()) halted_ = true;
  }
}

void Stm32f407::drive_pin(int port, int pin, std::optional<bool> level) {
  driven_[static_cast<std::size_t>(port)][static_cast<std::size_t>(pin)] = level;
  if (core_) core_->port(port).drive(pin, level);
}

void Stm32f407::set_supply(std::uint32_t millivolts) {
  supply_mv_ = millivolts;
  if (core_) core_->pwr.set_supply(millivolts);
}

void Stm32f407::overrun_adc() {
  if (core_) core_->adc.overrun();
}

bool Stm32f407::fail_serial_dma(bool sending) {
  if (!core_) return false;
  core_->scheduler.run_until(core_->cpu.now());
  return core_->dma1.fail(sending ? usart2_tx_stream : usart2_rx_stream);
}

void Stm32f407::stand_still(Time duration) {
  stands_until_ = now() + duration;
}

bool Stm32f407::pin_level(int port, int pin) const {
  return core_ && core_->port(port).level(pin);
}

void Stm32f407::serial(std::span<const std::uint8_t> bytes) {
  if (!core_) return;
  core_->scheduler.run_until(core_->cpu.now());
  core_->usart2.deliver(bytes);
}

OtgFs* Stm32f407::usb() {
  if (!core_) return nullptr;
  core_->scheduler.run_until(core_->cpu.now());
  return &core_->otg;
}

std::uint64_t Stm32f407::instructions() const {
  return core_ ? core_->cpu.instructions() : 0;
}
std::uint64_t Stm32f407::instructions_in(int exception) const {
  return core_ ? core_->cpu.instructions_in(exception) : 0;
}
std::uint64_t Stm32f407::entries_of(int exception) const {
  return core_ ? core_->cpu.entries_of(exception) : 0;
}

}  // namespace umov::mcu
