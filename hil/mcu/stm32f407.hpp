// The chip: processor, memory and peripherals put together, running an image in virtual time.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "hil/mcu/elf_file.hpp"
#include "hil/mcu/rcc.hpp"
#include "hil/mcu/scheduler.hpp"

namespace umov::mcu {

class OtgFs;

/// What the pins end in. All calls come in the order of virtual time.
class Surroundings {
 public:
  virtual ~Surroundings() = default;
  /// The chip drives a pin to another level (false too when it stops driving it).
  virtual void on_pin(int port, int pin, bool level, Time now) = 0;
  /// Voltage on input `channel` of ADC1 and ADC2 as a 12-bit code.
  virtual std::uint16_t analog(unsigned channel, Time now) = 0;
  /// USART2 has sent a byte.
  virtual void on_serial(std::uint8_t byte, Time now) = 0;
  /// The next moment after `now` at which an input changes that must be exact; never: none does.
  virtual Time next_change(Time now) {
    (void)now;
    return never;
  }
  /// That moment has come: drives the pin.
  virtual void change(Time now) { (void)now; }
};

struct ChipOptions {
  std::uint32_t crystal_hz = 8'000'000;
  std::array<std::uint32_t, 3> unique_id = {0x0030'0041, 0x3234'510A, 0x3331'3736};
};

/// Deterministic: the same image and the same calls give the same run. Not thread-safe. What the
/// program does that the model does not cover is refused by umov::Error from run_until().
class Stm32f407 {
 public:
  Stm32f407(Surroundings& surroundings, ChipOptions options = {});
  ~Stm32f407();

  /// Writes an image into the flash, as a programmer does.
  void flash(std::span<const Segment> image);
  /// Contents of the flash, 1 MB; kept over resets.
  std::vector<std::uint8_t>& flash_contents() { return flash_; }
  /// Sectors of the flash (bit n: sector n) that take no erasing and programming any more, but an
  /// error flag: write protection, as a stand-in for wear. Kept over resets.
  void protect_flash(std::uint32_t sectors);
  /// The chip starts; needs vectors at the beginning of the flash.
  void reset(ResetSource source);

  /// Lets time pass up to `limit`, or until pause() is called.
  void run_until(Time limit);
  /// Ends run_until() after the present instant; for use from the surroundings.
  void pause() { paused_ = true; }
  Time now() const;

  /// What the outside does to a pin; empty: leaves it to the pull.
  void drive_pin(int port, int pin, std::optional<bool> level);
  bool pin_level(int port, int pin) const;
  /// Voltage of the supply, for the detector; what resets the chip is reset(). 3,300 at first.
  void set_supply(std::uint32_t millivolts);
  /// The ADC reports an overrun.
  void overrun_adc();
  /// The bus refuses a transfer of the serial line's stream, of what is sent or of what is
  /// received; false when that stream is off.
  bool fail_serial_dma(bool sending);
  /// The processor does nothing for so long, as one that hangs; the peripherals go on.
  void stand_still(Time duration);
  /// Bytes to USART2.
  void serial(std::span<const std::uint8_t> bytes);

  /// The USB connector, for transactions at this moment; null before the first reset. Not to be
  /// kept: a reset makes another one.
  OtgFs* usb();

  /// Resets since the beginning by watchdog and by the program.
  unsigned watchdog_resets() const { return watchdog_resets_; }
  unsigned software_resets() const { return software_resets_; }

  /// Levels of the two pins that choose what starts, and start it. While NRST is low the chip is in
  /// reset; when it rises with BOOT0 high, the chip's ROM loader has it, which is not modelled: it
  /// does nothing until the next reset. A reset by watchdog, program or supply looks at BOOT0 too.
  void set_boot0(bool high) { boot0_ = high; }
  void set_nrst(bool high);
  bool runs_program() const { return nrst_ && !in_rom_; }

  // For a debugger: all but halted() and halt() while it is halted.
  /// A halted chip lets no time pass: run_until() returns at once. It is halted by halt() and at
  /// breakpoints, which outlive resets.
  bool halted() const { return halted_; }
  void halt() { halted_ = true; }
  void go_on() { halted_ = false; }
  /// One instruction. Throws what run_until() throws.
  void step();
  void set_breakpoint(std::uint32_t address, bool on);
  void clear_breakpoints();
  /// 0 to 15: R0 to PC; 16: xPSR.
  std::uint32_t debug_register(int number) const;
  void set_debug_register(int number, std::uint32_t value);
  /// Empty where there is no memory (registers of peripherals are not read: that may change them).
  std::vector<std::uint8_t> read_memory(std::uint32_t address, std::uint32_t size) const;
  /// RAM only; false elsewhere.
  bool write_memory(std::uint32_t address, std::span<const std::uint8_t> bytes);

  /// Instructions since the last reset: all, and in one exception without what interrupted it
  /// (16 + n: interrupt n; 0: main program); and how often an exception was entered.
  std::uint64_t instructions() const;
  std::uint64_t instructions_in(int exception) const;
  std::uint64_t entries_of(int exception) const;

 private:
  struct Core;

  Surroundings* surroundings_;
  ChipOptions options_;
  std::vector<std::uint8_t> flash_, sram_, ccm_, system_;
  std::array<std::array<std::optional<bool>, 16>, 5> driven_{};
  std::uint32_t reset_flags_ = 0;
  std::uint32_t protected_sectors_ = 0;
  unsigned watchdog_resets_ = 0, software_resets_ = 0;
  bool paused_ = false;
  std::uint32_t supply_mv_ = 3300;
  Time stands_until_ = 0;
  bool boot0_ = false, nrst_ = true, in_rom_ = false;
  bool halted_ = false;
  std::set<std::uint32_t> breakpoints_;
  std::unique_ptr<Core> core_;
};

}  // namespace umov::mcu
