// The inside of the chip: processor and peripherals wired together. Only for stm32f407.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <string>

#include "hil/mcu/adc.hpp"
#include "hil/mcu/cpu.hpp"
#include "hil/mcu/dma.hpp"
#include "hil/mcu/flash.hpp"
#include "hil/mcu/gpio.hpp"
#include "hil/mcu/iwdg.hpp"
#include "hil/mcu/nvic.hpp"
#include "hil/mcu/otg_fs.hpp"
#include "hil/mcu/stm32f407.hpp"
#include "hil/mcu/systick.hpp"
#include "hil/mcu/timer.hpp"
#include "hil/mcu/usart.hpp"
#include "host/errors/error.hpp"

namespace umov::mcu {

inline constexpr std::uint32_t sram_base = 0x2000'0000, ccm_base = 0x1000'0000,
                               system_base = 0x1FFF'7000, unique_id_offset = 0xA10;
inline constexpr std::size_t sram_size = 128 * 1024, ccm_size = 64 * 1024, system_size = 4096;

/// Interrupt requests (RM0090 table 61).
inline constexpr int irq_pvd = 1, irq_exti4 = 10, irq_adc = 18, irq_exti9_5 = 23, irq_tim1_cc = 27,
                     irq_tim2 = 28, irq_usart2 = 38, irq_exti15_10 = 40, irq_tim5 = 50,
                     irq_tim8_cc = 46, irq_otg_fs = 67;
inline constexpr std::array<int, 8> irq_dma1 = {11, 12, 13, 14, 15, 16, 17, 47};
inline constexpr std::array<int, 8> irq_dma2 = {56, 57, 58, 59, 60, 68, 69, 70};

/// DMA requests of the peripherals modelled (RM0090 tables 42, 43).
inline constexpr int adc_stream = 0, tim8_ch1_stream = 2, usart2_rx_stream = 5,
                     usart2_tx_stream = 6;
inline constexpr unsigned adc_channel = 0, tim8_ch1_channel = 7, usart2_channel = 4;

/// EXTSEL of TIM8_TRGO (RM0090 13.13.3).
inline constexpr unsigned trigger_tim8 = 14;

/// Pins a compare channel can reach (datasheet table 9).
struct ChannelPin {
  int timer, channel, port, pin;
  unsigned alternate;
};
inline constexpr std::array<ChannelPin, 13> channel_pins = {{{2, 1, 0, 0, 1},
                                                             {2, 1, 0, 5, 1},
                                                             {2, 1, 0, 15, 1},
                                                             {2, 2, 0, 1, 1},
                                                             {2, 2, 1, 3, 1},
                                                             {2, 3, 0, 2, 1},
                                                             {2, 3, 1, 10, 1},
                                                             {2, 4, 0, 3, 1},
                                                             {2, 4, 1, 11, 1},
                                                             {5, 1, 0, 0, 2},
                                                             {5, 2, 0, 1, 2},
                                                             {5, 3, 0, 2, 2},
                                                             {5, 4, 0, 3, 2}}};

/// Pins a capture channel can listen to.
inline constexpr std::array<ChannelPin, 8> capture_pins = {{{1, 1, 0, 8, 1},
                                                            {1, 1, 4, 9, 1},
                                                            {1, 2, 0, 9, 1},
                                                            {1, 2, 4, 11, 1},
                                                            {1, 3, 0, 10, 1},
                                                            {1, 3, 4, 13, 1},
                                                            {1, 4, 0, 11, 1},
                                                            {1, 4, 4, 14, 1}}};

/// All that a reset begins anew.
struct Stm32f407::Core final : Bus {
  explicit Core(Stm32f407& the_chip, Time now)
      : chip(the_chip),
        cpu(scheduler, nvic, *this),
        rcc(the_chip.options_.crystal_hz, the_chip.reset_flags_),
        pwr([this](bool low) { exti.on_supply_edge(low); }),
        systick(
            scheduler, [this] { return rcc.core_cycle(); },
            [this] { nvic.pend(Nvic::systick_exception); }),
        flash(the_chip.flash_, [this](Time stall) { cpu.skip_to(cpu.now() + stall); }),
        exti([this](std::uint32_t pending) {
          nvic.set_line(irq_exti4, (pending & 0x10u) != 0);
          nvic.set_line(irq_exti9_5, (pending & 0x3E0u) != 0);
          nvic.set_line(irq_exti15_10, (pending & 0xFC00u) != 0);
          nvic.set_line(irq_pvd, (pending & 0x1'0000u) != 0);
          constexpr std::uint32_t others = ~0x1'FFF0u;
          if ((pending & others) != 0) refuse_setting("EXTI", "IMR (lines 4 to 16 only)", pending);
        }),
        syscfg(exti),
        dma1("DMA1", master(),
             [this](int stream, bool level) {
               nvic.set_line(irq_dma1[static_cast<std::size_t>(stream)], level);
             }),
        dma2("DMA2", master(),
             [this](int stream, bool level) {
               nvic.set_line(irq_dma2[static_cast<std::size_t>(stream)], level);
             }),
        tim1("TIM1", 0xFFFF, scheduler, [this] { return rcc.apb2_timer_cycle(); },
             {.interrupt = line(irq_tim1_cc), .dma_request = {}, .trigger = {}, .on_output = {}}),
        tim2("TIM2", 0xFFFF'FFFF, scheduler, [this] { return rcc.apb1_timer_cycle(); },
             {.interrupt = line(irq_tim2),
              .dma_request = {},
              .trigger = {},
              .on_output = [this](int channel, bool level) { show_channel(2, channel, level); }}),
        tim5("TIM5", 0xFFFF'FFFF, scheduler, [this] { return rcc.apb1_timer_cycle(); },
             {.interrupt = line(irq_tim5),
              .dma_request = {},
              .trigger = {},
              .on_output = [this](int channel, bool level) { show_channel(5, channel, level); }}),
        tim8("TIM8", 0xFFFF, scheduler, [this] { return rcc.apb2_timer_cycle(); },
             {.interrupt = line(irq_tim8_cc),
              .dma_request =
                  [this](int channel) {
                    if (channel == 1) dma2.request(tim8_ch1_stream, tim8_ch1_channel);
                  },
              .trigger = [this] { adc.on_trigger(trigger_tim8); },
              .on_output = {}}),
        adc(
            scheduler, [this] { return rcc.apb2_cycle(); },
            [this](unsigned channel) {
              return chip.surroundings_->analog(channel, scheduler.now());
            },
            [this] { return dma2.request(adc_stream, adc_channel); }, line(irq_adc)),
        usart2(
            scheduler, [this] { return rcc.apb1_cycle(); },
            {.interrupt = line(irq_usart2),
             .receive_request = [this] { return dma1.request(usart2_rx_stream, usart2_channel); },
             .send_request = [this] { return dma1.request(usart2_tx_stream, usart2_channel); },
             .on_byte =
                 [this](std::uint8_t byte) {
                   chip.surroundings_->on_serial(byte, scheduler.now());
                 }}),
        iwdg(scheduler, [this] { watchdog_expired = true; }),
        otg(line(irq_otg_fs)),
        change_slot(scheduler.add([this] {
          chip.surroundings_->change(scheduler.now());
          plan_change();
        })) {
    scheduler.run_until(now);
    cpu.skip_to(now);
    for (int p = 0; p < 5; ++p) {
      ports.push_back(std::make_unique<Gpio>(p, exti, [this](int port, int pin, bool level) {
        chip.surroundings_->on_pin(port, pin, level, scheduler.now());
      }));
      for (int pin = 0; pin < 16; ++pin) {
        ports.back()->drive(
            pin, chip.driven_[static_cast<std::size_t>(p)][static_cast<std::size_t>(pin)]);
      }
    }
    for (auto& each : ports) {
      each->listen([this](int port_number, int pin, bool level) {
        if (level) capture(port_number, pin);
      });
    }
    plan_change();
    for (const ChannelPin& c : channel_pins) port(c.port).set_alternate(c.pin, c.alternate, false);
    dma1.on_enable([this](int) { usart2.on_stream_enabled(); });
    dma2.on_enable([this](int stream) {
      if (stream == adc_stream) adc.on_stream_enabled();
    });
    cpu.map_memory(Flash::base, chip.flash_, false);
    cpu.map_memory(sram_base, chip.sram_, true);
    cpu.map_memory(ccm_base, chip.ccm_, true);
    cpu.map_memory(system_base, chip.system_, false);
    cpu.map_registers(0x4000'0000, 0x8'0000);
    cpu.map_registers(0x5000'0000, 0x4'0000);
    cpu.map_registers(0xE000'E000, 0x1000);
    cpu.set_cycle(rcc.core_cycle());
    pwr.set_supply(the_chip.supply_mv_);
  }

  InterruptLine line(int irq) {
    return [this, irq](bool level) { nvic.set_line(irq, level); };
  }
  Gpio& port(int number) { return *ports[static_cast<std::size_t>(number)]; }
  const Gpio& port(int number) const { return *ports[static_cast<std::size_t>(number)]; }

  void show_channel(int timer, int channel, bool level) {
    for (const ChannelPin& c : channel_pins) {
      if (c.timer == timer && c.channel == channel)
        port(c.port).set_alternate(c.pin, c.alternate, level);
    }
  }

  void capture(int port_number, int pin) {
    for (const ChannelPin& c : capture_pins) {
      if (c.port == port_number && c.pin == pin && port(c.port).uses_alternate(pin, c.alternate))
        tim1.rise(c.channel);
    }
  }
  void plan_change() {
    scheduler.set(change_slot, chip.surroundings_->next_change(scheduler.now()));
  }

  BusMaster master() {
    return {
        .read = [this](std::uint32_t address, unsigned bytes) { return dma_read(address, bytes); },
        .write = [this](std::uint32_t address, unsigned bytes,
                        std::uint32_t value) { dma_write(address, bytes, value); }};
  }

  std::uint8_t* memory(std::uint32_t address, unsigned bytes) {
    // The core-coupled memory is out of the controllers' reach.
    if (address >= sram_base && address - sram_base + bytes <= sram_size)
      return chip.sram_.data() + (address - sram_base);
    if (address >= Flash::base && address - Flash::base + bytes <= Flash::size)
      return chip.flash_.data() + (address - Flash::base);
    return nullptr;
  }
  std::uint32_t dma_read(std::uint32_t address, unsigned bytes) {
    const std::uint8_t* from = memory(address, bytes);
    if (from == nullptr) return registers(address & ~3u).peripheral->read(offset_of(address));
    std::uint32_t value = 0;
    for (unsigned i = 0; i < bytes; ++i) value |= static_cast<std::uint32_t>(from[i]) << 8 * i;
    return value;
  }
  void dma_write(std::uint32_t address, unsigned bytes, std::uint32_t value) {
    std::uint8_t* to = address >= sram_base ? memory(address, bytes) : nullptr;
    if (to == nullptr) return registers(address & ~3u).peripheral->write(offset_of(address), value);
    for (unsigned i = 0; i < bytes; ++i) to[i] = static_cast<std::uint8_t>(value >> 8 * i);
  }

  /// A block on the bus and the gate of its clock.
  struct Mapped {
    std::uint32_t begin, size;
    Peripheral* peripheral;
    const char* name;
    Rcc::Bus bus;
    int gate;  ///< bit of the enable register, -1: always on
  };

  const Mapped& registers(std::uint32_t address) {
    if (table.empty()) fill_table();
    // Most accesses go where the last one went.
    if (last_mapped != nullptr && address >= last_mapped->begin &&
        address - last_mapped->begin < last_mapped->size) {
      return *last_mapped;
    }
    for (const Mapped& m : table) {
      if (address < m.begin || address - m.begin >= m.size) continue;
      if (m.gate >= 0 && !rcc.enabled(m.bus, static_cast<unsigned>(m.gate)))
        refuse_setting(m.name, "an access while its clock is off, address", address);
      last_mapped = &m;
      return m;
    }
    throw Error("bus fault: no block at " + hexadecimal(address) + ", program counter " +
                    hexadecimal(cpu.program_counter()),
                "see what the program does there; blocks modelled: hil/mcu/README.md");
  }
  std::uint32_t offset_of(std::uint32_t address) {
    return (address & ~3u) - registers(address).begin;
  }

  void fill_table() {
    using enum Rcc::Bus;
    table = {{0x4000'0000, 0x400, &tim2, "TIM2", apb1, 0},
             {0x4000'0C00, 0x400, &tim5, "TIM5", apb1, 3},
             {0x4000'3000, 0x400, &iwdg, "IWDG", apb1, -1},
             {0x4000'4400, 0x400, &usart2, "USART2", apb1, 17},
             {0x4000'7000, 0x400, &pwr, "PWR", apb1, 28},
             {0x4001'0000, 0x400, &tim1, "TIM1", apb2, 0},
             {0x4001'0400, 0x400, &tim8, "TIM8", apb2, 1},
             {0x4001'2000, 0x400, &adc, "ADC", apb2, 8},
             {0x4001'3800, 0x400, &syscfg, "SYSCFG", apb2, 14},
             {0x4001'3C00, 0x400, &exti, "EXTI", apb2, -1},
             {0x4002'3800, 0x400, &rcc, "RCC", ahb1, -1},
             {0x4002'3C00, 0x400, &flash, "the flash interface", ahb1, -1},
             {0x4002'6000, 0x400, &dma1, "DMA1", ahb1, 21},
             {0x4002'6400, 0x400, &dma2, "DMA2", ahb1, 22},
             {0x5000'0000, 0x4'0000, &otg, "OTG_FS", ahb2, 7}};
    for (int p = 0; p < 5; ++p) {
      table.push_back(
          {0x4002'0000 + 0x400 * static_cast<std::uint32_t>(p), 0x400, &port(p), "GPIO", ahb1, p});
    }
  }

  // Bus
  std::uint32_t read(std::uint32_t address, unsigned size) override {
    if (address >= 0xE000'E010 && address < 0xE000'E020) return systick.read(address & 0xFu);
    if (address >= 0xE000'E000) return nvic.read(address - 0xE000'E000, size);
    const Mapped& m = registers(address);
    const std::uint32_t word = m.peripheral->read((address - m.begin) & ~3u);
    return size == 4 ? word : word >> 8 * (address & 3u) & ((1u << 8 * size) - 1);
  }
  void write(std::uint32_t address, unsigned size, std::uint32_t value) override {
    if (address >= 0xE000'E010 && address < 0xE000'E020)
      return systick.write(address & 0xFu, value);
    if (address >= 0xE000'E000) return nvic.write(address - 0xE000'E000, size, value);
    const Mapped& m = registers(address);
    if (size != 4) refuse_setting(m.name, "a store narrower than a word", address);
    m.peripheral->write(address - m.begin, value);
    if (m.peripheral == &rcc) {
      cpu.set_cycle(rcc.core_cycle());
      last_mapped = nullptr;  // gates may have changed
    }
  }
  void store(std::uint32_t address, unsigned size, std::uint32_t value) override {
    if (address < Flash::base || address - Flash::base >= Flash::size)
      throw Error("bus fault: store to read-only memory at " + hexadecimal(address),
                  "see what the program does there");
    flash.store(address, size, value);
  }

  Stm32f407& chip;
  Scheduler scheduler;
  Nvic nvic;
  Cpu cpu;
  Rcc rcc;
  Pwr pwr;
  SysTick systick;
  Flash flash;
  Exti exti;
  Syscfg syscfg;
  std::vector<std::unique_ptr<Gpio>> ports;
  Dma dma1, dma2;
  Timer tim1, tim2, tim5, tim8;
  Adc adc;
  Usart usart2;
  Iwdg iwdg;
  OtgFs otg;
  Scheduler::Slot change_slot;
  std::vector<Mapped> table;
  const Mapped* last_mapped = nullptr;
  bool watchdog_expired = false;
};

}  // namespace umov::mcu
