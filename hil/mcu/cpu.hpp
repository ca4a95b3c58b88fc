// The processor: a Cortex-M4 run by Unicorn in slices, with exceptions as ARMv7-M has them.
#pragma once

#include <array>
#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "hil/mcu/nvic.hpp"
#include "hil/mcu/scheduler.hpp"

namespace umov::mcu {

/// Where the processor's loads and stores end that are no plain memory.
class Bus {
 public:
  virtual ~Bus() = default;
  /// Registers, `size` 1, 2 or 4. May throw umov::Error.
  virtual std::uint32_t read(std::uint32_t address, unsigned size) = 0;
  virtual void write(std::uint32_t address, unsigned size, std::uint32_t value) = 0;
  /// A store to read-only memory.
  virtual void store(std::uint32_t address, unsigned size, std::uint32_t value) = 0;
};

/// Time is counted in instructions: each takes one core cycle, the entry to an exception and the
/// return from it 12 each, the passage from one to the next 6. Wait states, pipeline refills and
/// multi-cycle instructions are not counted: a real chip is slower by what these cost.
/// A slice ends between two straight pieces of code (translation blocks); within one the clock
/// stands at its end. Interrupts are taken between them.
/// Not modelled: the process stack, privilege, faults that the program handles itself, the FPU's
/// registers in exceptions (the program must leave the FPU off).
class Cpu {
 public:
  Cpu(Scheduler& scheduler, Nvic& nvic, Bus& bus);
  ~Cpu();
  Cpu(const Cpu&) = delete;
  Cpu& operator=(const Cpu&) = delete;

  /// Memory of the program; `contents` must stay where it is.
  void map_memory(std::uint32_t address, std::span<std::uint8_t> contents, bool writable);
  /// Addresses that go to the bus; both multiples of 4096.
  void map_registers(std::uint32_t address, std::uint32_t size);

  /// Starts at the vector table at `address`.
  void reset(std::uint32_t address);
  void set_cycle(Time cycle) { cycle_ = cycle; }
  /// Runs until `limit`, an interrupt could be taken, or the program sleeps. Throws umov::Error for
  /// an access without memory, an undefined instruction, and what the bus refuses.
  void run(Time limit);
  /// The present slice ends at the next piece of code; also from within the bus.
  void yield() { stop_at_ = 0; }
  /// Nothing but an interrupt goes on.
  bool sleeping() const { return sleeping_; }
  /// Lets time pass without instructions.
  void skip_to(Time moment) { now_ = moment > now_ ? moment : now_; }
  Time now() const { return now_; }

  /// Instructions so far, and those within an exception (0: main program) without what
  /// interrupted it.
  std::uint64_t instructions() const;
  std::uint64_t instructions_in(int exception) const {
    return spent_[static_cast<std::size_t>(exception)];
  }
  std::uint64_t entries_of(int exception) const {
    return entries_[static_cast<std::size_t>(exception)];
  }
  std::uint32_t program_counter() const;

  // For a debugger. While a breakpoint divides a piece of code, its instructions are counted twice.
  /// 0 to 15: R0 to PC; 16: xPSR.
  std::uint32_t debug_register(int number) const;
  void set_debug_register(int number, std::uint32_t value);
  /// The program stops before the instruction at `address`.
  void add_breakpoint(std::uint32_t address);
  void remove_breakpoint(std::uint32_t address);
  /// Whether the last slice ended at a breakpoint; forgets it.
  bool take_breakpoint() { return std::exchange(at_breakpoint_, false); }
  /// One instruction, or the entry to an exception that is due.
  void step();
  /// Bytes of memory; null where there is none.
  const std::uint8_t* find_memory(std::uint32_t address, std::uint32_t bytes) const;

 private:
  struct Callbacks;
  struct Block {
    std::uint16_t bytes = 0, instructions = 0;
  };

  std::uint32_t reg(int id) const;
  void set_reg(int id, std::uint32_t value);
  Nvic::Masks masks() const;
  template <class Action>
  void guard(Action&& action);
  void look_up();
  void run_instructions(std::size_t most);
  void put_back_stores();
  std::uint8_t* place(std::uint32_t address, std::uint32_t bytes, bool to_write);
  std::uint32_t load(std::uint32_t address);
  void store(std::uint32_t address, std::uint32_t value);
  void enter(int exception);
  void jump_to_handler(int exception, std::uint32_t exc_return);
  void return_from_exception(std::uint32_t exc_return);
  unsigned count_instructions(std::uint32_t address, std::uint32_t bytes);
  [[noreturn]] void fail(const std::string& what, const std::string& remedy);

  struct Memory {
    std::uint32_t begin;
    std::span<std::uint8_t> contents;
    bool writable;
  };
  struct Region {
    Cpu* cpu;
    std::uint32_t begin;
  };

  Scheduler* scheduler_;
  Nvic* nvic_;
  Bus* bus_;
  void* engine_ = nullptr;
  std::vector<Memory> memory_;
  std::vector<std::unique_ptr<Region>> regions_;
  std::vector<Block> blocks_;  // by address of the flash image
  Time now_ = 0;
  Time cycle_ = 21;
  Time stop_at_ = 0;
  bool stopped_ = false;
  bool sleeping_ = false;
  bool returning_ = false;
  bool at_breakpoint_ = false;
  bool leaving_breakpoint_ = false;
  std::map<std::uint32_t, std::size_t> breakpoints_;  // address, Unicorn's hook
  std::vector<std::pair<std::uint32_t, std::vector<std::uint8_t>>> made_of_stores_;
  std::exception_ptr refused_;
  std::string fault_;
  std::array<std::uint64_t, Nvic::exception_count> spent_{};
  std::array<std::uint64_t, Nvic::exception_count> entries_{};
  int current_ = 0;
};

}  // namespace umov::mcu
