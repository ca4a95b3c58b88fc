#include "hil/mcu/cpu.hpp"

#include <unicorn/unicorn.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <string>
#include <utility>

#include "hil/mcu/peripheral.hpp"
#include "host/errors/error.hpp"

namespace umov::mcu {
namespace {

constexpr Time entry_cycles = 12, return_cycles = 12, chain_cycles = 6;
constexpr std::uint32_t frame_bytes = 32;
constexpr std::uint32_t xpsr_aligned = 1u << 9, xpsr_thumb = 1u << 24;
constexpr std::uint32_t code_begin = 0x0800'0000, code_size = 0x10'0000;

uc_engine* engine(void* handle) {
  return static_cast<uc_engine*>(handle);
}

void check(uc_err error, const char* what) {
  if (error == UC_ERR_OK) return;
  throw Error(std::string("the emulated processor can't ") + what + ": " + uc_strerror(error),
              "report this with the version of libunicorn");
}

}  // namespace

/// What Unicorn calls back. Exceptions must not pass through its generated code: they are kept and
/// thrown on when the slice has ended.
struct Cpu::Callbacks {
  static void block(uc_engine* uc, std::uint64_t address, std::uint32_t bytes, void* self) {
    auto& cpu = *static_cast<Cpu*>(self);
    cpu.put_back_stores();
    if (cpu.now_ >= cpu.stop_at_) {  // the block is not run
      cpu.stopped_ = true;
      uc_emu_stop(uc);
      return;
    }
    const unsigned count = cpu.count_instructions(static_cast<std::uint32_t>(address), bytes);
    cpu.now_ += count * cpu.cycle_;
    cpu.spent_[static_cast<std::size_t>(cpu.current_)] += count;
  }

  static void interrupt(uc_engine* uc, std::uint32_t number, void* self) {
    auto& cpu = *static_cast<Cpu*>(self);
    constexpr std::uint32_t exception_exit = 8;
    if (number == exception_exit) {
      cpu.returning_ = true;
    } else {
      cpu.fault_ = "processor exception " + std::to_string(number);
    }
    cpu.stopped_ = true;
    uc_emu_stop(uc);
  }

  static void breakpoint(uc_engine* uc, std::uint64_t, std::uint32_t, void* self) {
    auto& cpu = *static_cast<Cpu*>(self);
    if (std::exchange(cpu.leaving_breakpoint_, false)) return;
    cpu.at_breakpoint_ = true;
    cpu.stopped_ = true;
    uc_emu_stop(uc);
  }

  static bool no_memory(uc_engine*, uc_mem_type type, std::uint64_t address, int size, std::int64_t,
                        void* self) {
    auto& cpu = *static_cast<Cpu*>(self);
    const char* verb = type == UC_MEM_FETCH_UNMAPPED || type == UC_MEM_FETCH_PROT ? "fetch from"
                       : type == UC_MEM_WRITE_UNMAPPED                            ? "store to"
                                                                                  : "load from";
    cpu.fault_ = std::string("bus fault: ") + verb + " " +
                 hexadecimal(static_cast<std::uint32_t>(address)) + " (" + std::to_string(size) +
                 " bytes)";
    return false;
  }

  static bool store_to_rom(uc_engine*, uc_mem_type, std::uint64_t address, int size,
                           std::int64_t value, void* self) {
    auto& cpu = *static_cast<Cpu*>(self);
    cpu.guard([&] {
      const auto place = static_cast<std::uint32_t>(address);
      const auto bytes = static_cast<unsigned>(size);
      cpu.bus_->store(place, bytes, static_cast<std::uint32_t>(value));
      // Unicorn stores the value all the same: what the memory has made of it is put back.
      const std::uint8_t* made = cpu.place(place, bytes, false);
      cpu.made_of_stores_.push_back({place, {made, made + bytes}});
      cpu.stop_at_ = 0;
    });
    return true;
  }

  static std::uint64_t load(Cpu& cpu, std::uint32_t address, unsigned size) {
    std::uint32_t value = 0;
    cpu.guard([&] {
      cpu.put_back_stores();
      cpu.scheduler_->run_until(cpu.now_);
      value = cpu.bus_->read(address, size);
    });
    cpu.look_up();
    return value;
  }

  static void store(Cpu& cpu, std::uint32_t address, unsigned size, std::uint32_t value) {
    cpu.guard([&] {
      cpu.put_back_stores();
      cpu.scheduler_->run_until(cpu.now_);
      cpu.bus_->write(address, size, value);
    });
    cpu.look_up();
  }
};

Cpu::Cpu(Scheduler& scheduler, Nvic& nvic, Bus& bus)
    : scheduler_(&scheduler), nvic_(&nvic), bus_(&bus), blocks_(code_size / 2) {
  uc_engine* uc = nullptr;
  check(uc_open(UC_ARCH_ARM, static_cast<uc_mode>(UC_MODE_THUMB | UC_MODE_MCLASS), &uc), "start");
  engine_ = uc;
  check(uc_ctl_set_cpu_model(uc, UC_CPU_ARM_CORTEX_M4), "be a Cortex-M4");
  const auto add = [&](int type, void* call) {
    uc_hook hook = 0;
    check(uc_hook_add(uc, &hook, type, call, this, 1, 0), "be watched");
  };
  add(UC_HOOK_BLOCK, reinterpret_cast<void*>(&Callbacks::block));
  add(UC_HOOK_INTR, reinterpret_cast<void*>(&Callbacks::interrupt));
  add(UC_HOOK_MEM_UNMAPPED | UC_HOOK_MEM_FETCH_PROT | UC_HOOK_MEM_READ_PROT,
      reinterpret_cast<void*>(&Callbacks::no_memory));
  add(UC_HOOK_MEM_WRITE_PROT, reinterpret_cast<void*>(&Callbacks::store_to_rom));
}

Cpu::~Cpu() {
  uc_close(engine(engine_));
}

template <class Action>
void Cpu::guard(Action&& action) {
  if (refused_) return;
  try {
    action();
  } catch (...) {
    refused_ = std::current_exception();  // thrown on in run()
    stop_at_ = 0;
  }
}

void Cpu::put_back_stores() {
  if (made_of_stores_.empty()) return;
  for (const auto& [address, bytes] : made_of_stores_) {
    std::copy(bytes.begin(), bytes.end(),
              place(address, static_cast<std::uint32_t>(bytes.size()), false));
  }
  made_of_stores_.clear();
}

/// After an access to the bus: what it set off may be due before the slice ends.
void Cpu::look_up() {
  stop_at_ = std::min(stop_at_, scheduler_->next());
  if (nvic_->take_change()) stop_at_ = 0;
}

void Cpu::map_memory(std::uint32_t address, std::span<std::uint8_t> contents, bool writable) {
  check(uc_mem_map_ptr(engine(engine_), address, contents.size(),
                       writable ? UC_PROT_ALL : UC_PROT_READ | UC_PROT_EXEC, contents.data()),
        "map memory");
  memory_.push_back({address, contents, writable});
}

void Cpu::map_registers(std::uint32_t address, std::uint32_t size) {
  regions_.push_back(std::make_unique<Region>(Region{this, address}));
  const auto read = [](uc_engine*, std::uint64_t offset, unsigned bytes, void* region) {
    const auto& r = *static_cast<Region*>(region);
    return Callbacks::load(*r.cpu, r.begin + static_cast<std::uint32_t>(offset), bytes);
  };
  const auto write = [](uc_engine*, std::uint64_t offset, unsigned bytes, std::uint64_t value,
                        void* region) {
    const auto& r = *static_cast<Region*>(region);
    Callbacks::store(*r.cpu, r.begin + static_cast<std::uint32_t>(offset), bytes,
                     static_cast<std::uint32_t>(value));
  };
  check(uc_mmio_map(engine(engine_), address, size, read, regions_.back().get(), write,
                    regions_.back().get()),
        "map registers");
}

std::uint32_t Cpu::reg(int id) const {
  std::uint32_t value = 0;
  uc_reg_read(engine(engine_), id, &value);
  return value;
}

void Cpu::set_reg(int id, std::uint32_t value) {
  uc_reg_write(engine(engine_), id, &value);
}

Nvic::Masks Cpu::masks() const {
  return {.primask = (reg(UC_ARM_REG_PRIMASK) & 1u) != 0,
          .faultmask = (reg(UC_ARM_REG_FAULTMASK) & 1u) != 0,
          .basepri = reg(UC_ARM_REG_BASEPRI)};
}

std::uint32_t Cpu::program_counter() const {
  return reg(UC_ARM_REG_PC);
}

std::uint64_t Cpu::instructions() const {
  return std::accumulate(spent_.begin(), spent_.end(), std::uint64_t{0});
}

std::uint8_t* Cpu::place(std::uint32_t address, std::uint32_t bytes, bool to_write) {
  for (const Memory& m : memory_) {
    if (address < m.begin || address - m.begin + std::uint64_t{bytes} > m.contents.size()) continue;
    if (to_write && !m.writable) break;
    return m.contents.data() + (address - m.begin);
  }
  fail("bus fault: the stack or the vectors are at " + hexadecimal(address),
       "look for a stack that ran over or a pointer that was overwritten");
}

std::uint32_t Cpu::load(std::uint32_t address) {
  std::uint32_t value = 0;
  std::memcpy(&value, place(address, 4, false), 4);
  return value;
}

void Cpu::store(std::uint32_t address, std::uint32_t value) {
  std::memcpy(place(address, 4, true), &value, 4);
}

void Cpu::fail(const std::string& what, const std::string& remedy) {
  throw Error(what + ", program counter " + hexadecimal(program_counter()) + ", link register " +
                  hexadecimal(reg(UC_ARM_REG_LR)) + ", after " + std::to_string(instructions()) +
                  " instructions",
              remedy);
}

void Cpu::reset(std::uint32_t address) {
  set_reg(UC_ARM_REG_SP, load(address));
  set_reg(UC_ARM_REG_LR, 0xFFFF'FFFF);
  set_reg(UC_ARM_REG_PRIMASK, 0);
  set_reg(UC_ARM_REG_XPSR, xpsr_thumb);
  set_reg(UC_ARM_REG_PC, load(address + 4) | 1u);
  sleeping_ = false;
  current_ = 0;
}

unsigned Cpu::count_instructions(std::uint32_t address, std::uint32_t bytes) {
  const bool cached = address >= code_begin && address - code_begin < code_size;
  Block* block = cached ? &blocks_[(address - code_begin) / 2] : nullptr;
  if (block != nullptr && block->bytes == bytes && bytes != 0) return block->instructions;
  const std::uint8_t* code = place(address, bytes, false);
  unsigned count = 0;
  for (std::uint32_t at = 0; at < bytes; ++count) {
    // The upper five bits tell 32-bit instructions (ARMv7-M A5.1).
    at += code[at + 1] >> 3 >= 0x1D ? 4 : 2;
  }
  if (block != nullptr) {
    *block = {static_cast<std::uint16_t>(bytes), static_cast<std::uint16_t>(count)};
  }
  return count;
}

void Cpu::jump_to_handler(int exception, std::uint32_t exc_return) {
  nvic_->enter(exception);
  ++entries_[static_cast<std::size_t>(exception)];
  current_ = exception;
  set_reg(UC_ARM_REG_LR, exc_return);
  set_reg(UC_ARM_REG_XPSR, xpsr_thumb | static_cast<std::uint32_t>(exception));
  const std::uint32_t vector = nvic_->vector_table() + 4 * static_cast<std::uint32_t>(exception);
  set_reg(UC_ARM_REG_PC, load(vector) | 1u);
}

void Cpu::enter(int exception) {
  const std::uint32_t control = reg(UC_ARM_REG_CONTROL);
  if (control != 0)
    fail("an exception with the FPU, the process stack or less privilege in use (CONTROL " +
             hexadecimal(control) + ")",
         "the emulated processor does not model it: leave them off");
  std::uint32_t sp = reg(UC_ARM_REG_SP);
  std::uint32_t xpsr = reg(UC_ARM_REG_XPSR) & ~xpsr_aligned;
  if ((sp & 4u) != 0) {
    sp -= 4;
    xpsr |= xpsr_aligned;
  }
  sp -= frame_bytes;
  const std::array<std::uint32_t, 8> frame = {
      reg(UC_ARM_REG_R0),  reg(UC_ARM_REG_R1), reg(UC_ARM_REG_R2), reg(UC_ARM_REG_R3),
      reg(UC_ARM_REG_R12), reg(UC_ARM_REG_LR), reg(UC_ARM_REG_PC), xpsr};
  for (std::uint32_t i = 0; i < frame.size(); ++i) store(sp + 4 * i, frame[i]);
  set_reg(UC_ARM_REG_SP, sp);
  now_ += entry_cycles * cycle_;
  jump_to_handler(exception, nvic_->nesting() == 0 ? 0xFFFF'FFF9 : 0xFFFF'FFF1);
}

void Cpu::return_from_exception(std::uint32_t exc_return) {
  const bool to_thread = (exc_return & 0xFu) >= 8;
  if (to_thread != (nvic_->nesting() == 1))
    fail("a return from an exception with " + hexadecimal(exc_return),
         "look at what changed the link register of the handler");
  nvic_->leave(nvic_->active());
  if (const int next = nvic_->to_take(masks())) {
    now_ += chain_cycles * cycle_;
    return jump_to_handler(next, to_thread ? 0xFFFF'FFF9 : 0xFFFF'FFF1);
  }
  const std::uint32_t sp = reg(UC_ARM_REG_SP);
  std::array<std::uint32_t, 8> frame;
  for (std::uint32_t i = 0; i < frame.size(); ++i) frame[i] = load(sp + 4 * i);
  constexpr std::array<int, 6> registers = {UC_ARM_REG_R0, UC_ARM_REG_R1,  UC_ARM_REG_R2,
                                            UC_ARM_REG_R3, UC_ARM_REG_R12, UC_ARM_REG_LR};
  for (std::size_t i = 0; i < registers.size(); ++i) set_reg(registers[i], frame[i]);
  const std::uint32_t xpsr = frame[7];
  if ((xpsr & 0x1FFu) != static_cast<std::uint32_t>(nvic_->active()))
    fail("a frame of another exception on the stack", "look for a stack that ran over");
  set_reg(UC_ARM_REG_SP, sp + frame_bytes + ((xpsr & xpsr_aligned) != 0 ? 4 : 0));
  set_reg(UC_ARM_REG_XPSR, (xpsr & ~xpsr_aligned) | xpsr_thumb);
  set_reg(UC_ARM_REG_PC, frame[6] | 1u);
  current_ = nvic_->active();
  now_ += return_cycles * cycle_;
}

void Cpu::run(Time limit) {
  const Nvic::Masks masked = masks();
  if (sleeping_) {
    if (!nvic_->wakes(masked)) return skip_to(limit);
    sleeping_ = false;
  }
  if (const int exception = nvic_->to_take(masked)) enter(exception);
  nvic_->take_change();
  // An interrupt that is held off is looked for again after every piece of code.
  stop_at_ = nvic_->wakes(masks()) ? now_ + 1 : limit;
  if (now_ >= limit) return;
  run_instructions(0);
}

void Cpu::step() {
  const Nvic::Masks masked = masks();
  if (sleeping_) {
    if (!nvic_->wakes(masked)) return skip_to(std::min(scheduler_->next(), now_ + time_per_second));
    sleeping_ = false;
  }
  if (const int exception = nvic_->to_take(masked)) return enter(exception);
  nvic_->take_change();
  stop_at_ = never;
  run_instructions(1);
}

/// At most so many, 0: until something ends the slice.
void Cpu::run_instructions(std::size_t most) {
  stopped_ = returning_ = false;
  // The program goes on behind a breakpoint that it stands at.
  leaving_breakpoint_ = breakpoints_.contains(program_counter());
  const uc_err error = uc_emu_start(engine(engine_), program_counter() | 1u, 0xFFFF'FFFF, 0, most);
  put_back_stores();
  if (refused_) std::rethrow_exception(std::exchange(refused_, nullptr));
  if (!fault_.empty()) fail(fault_, "see what the program does there");
  if (error != UC_ERR_OK)
    fail(std::string("the program can't go on: ") + uc_strerror(error),
         "see what the program does there");
  if (returning_) return return_from_exception(program_counter());
  sleeping_ = !stopped_ && most == 0;  // WFI
}

std::uint32_t Cpu::debug_register(int number) const {
  if (number < 13) return reg(UC_ARM_REG_R0 + number);
  constexpr std::array<int, 4> others = {UC_ARM_REG_SP, UC_ARM_REG_LR, UC_ARM_REG_PC,
                                         UC_ARM_REG_XPSR};
  return reg(others.at(static_cast<std::size_t>(number - 13)));
}

void Cpu::set_debug_register(int number, std::uint32_t value) {
  if (number < 13) return set_reg(UC_ARM_REG_R0 + number, value);
  constexpr std::array<int, 4> others = {UC_ARM_REG_SP, UC_ARM_REG_LR, UC_ARM_REG_PC,
                                         UC_ARM_REG_XPSR};
  set_reg(others.at(static_cast<std::size_t>(number - 13)), number == 15 ? value | 1u : value);
}

void Cpu::add_breakpoint(std::uint32_t address) {
  if (breakpoints_.contains(address)) return;
  uc_hook hook = 0;
  check(uc_hook_add(engine(engine_), &hook, UC_HOOK_CODE,
                    reinterpret_cast<void*>(&Callbacks::breakpoint), this, address, address),
        "stop at an address");
  breakpoints_[address] = hook;
  // What has been translated before does not call back.
  uc_ctl_remove_cache(engine(engine_), address & ~1u, (address & ~1u) + 2);
}

void Cpu::remove_breakpoint(std::uint32_t address) {
  const auto found = breakpoints_.find(address);
  if (found == breakpoints_.end()) return;
  uc_hook_del(engine(engine_), found->second);
  breakpoints_.erase(found);
}

const std::uint8_t* Cpu::find_memory(std::uint32_t address, std::uint32_t bytes) const {
  for (const Memory& m : memory_) {
    if (address >= m.begin && address - m.begin + std::uint64_t{bytes} <= m.contents.size())
      return m.contents.data() + (address - m.begin);
  }
  return nullptr;
}

}  // namespace umov::mcu
