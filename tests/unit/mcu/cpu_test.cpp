// The processor with a few hand-assembled instructions: exceptions, sleep, counted time, faults.
#include "hil/mcu/cpu.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "host/errors/error.hpp"

namespace umov::mcu {
namespace {

constexpr std::uint32_t flash_base = 0x0800'0000, ram_base = 0x2000'0000;
constexpr Time cycle = 2;
// Where the pieces of the program are, as offsets in the flash.
constexpr std::uint32_t main_at = 0x400, first_at = 0x500, second_at = 0x600;
constexpr int first = 16, second = 17;

class CpuTest : public testing::Test, public Bus {
 protected:
  CpuTest() {
    nvic.write(0xD08, 4, flash_base);
    nvic.write(0x100, 4, 3);  // both interrupts enabled
    word(0, ram_base + 0x1000);
    word(4, flash_base + main_at + 1);
    word(4 * first, flash_base + first_at + 1);
    word(4 * second, flash_base + second_at + 1);
    cpu.map_memory(flash_base, flash, false);
    cpu.map_memory(ram_base, ram, true);
    cpu.map_registers(0x4000'0000, 0x1000);
    cpu.set_cycle(cycle);
  }
  void word(std::uint32_t at, std::uint32_t value) { std::memcpy(&flash[at], &value, 4); }
  void code(std::uint32_t at, std::initializer_list<std::uint16_t> halves) {
    for (const std::uint16_t half : halves) {
      std::memcpy(&flash[at], &half, 2);
      at += 2;
    }
  }
  void priority(int exception, std::uint32_t value) {
    nvic.write(0x400 + static_cast<std::uint32_t>(exception - 16), 1, value << 4);
  }
  /// Runs until `limit` as the chip's loop does.
  void run_until(Time limit) {
    while (cpu.now() < limit) {
      scheduler.run_until(cpu.now());
      cpu.run(std::min(limit, scheduler.next()));
    }
  }
  std::string error_of(const std::function<void()>& action) {
    try {
      action();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  std::uint32_t read(std::uint32_t, unsigned) override { return 0; }
  void write(std::uint32_t address, unsigned, std::uint32_t value) override {
    if (on_write) on_write(address, value);
  }
  void store(std::uint32_t address, unsigned, std::uint32_t) override { stored_to = address; }

  std::vector<std::uint8_t> flash = std::vector<std::uint8_t>(0x1000, 0xFF);
  std::vector<std::uint8_t> ram = std::vector<std::uint8_t>(0x2000);
  Scheduler scheduler;
  Nvic nvic;
  Cpu cpu{scheduler, nvic, *this};
  std::function<void(std::uint32_t, std::uint32_t)> on_write;
  std::uint32_t stored_to = 0;
};

TEST_F(CpuTest, EveryInstructionIsACycle) {
  // movs r0, #0; movw r1, #1000 (32 bits); loop: adds r0, #1; cmp r0, r1; bne loop; wfi
  code(main_at, {0x2000, 0xF240, 0x31E8, 0x3001, 0x4288, 0xD1FC, 0xBF30});
  cpu.reset(flash_base);
  run_until(1'000'000);
  EXPECT_TRUE(cpu.sleeping());
  EXPECT_EQ(cpu.instructions(), 2u + 1000u * 3u + 1u);
}

TEST_F(CpuTest, PendingInterruptsFollowOneAnotherWithoutAReturnBetween) {
  code(main_at, {0xBF30, 0xE7FD});    // wfi; b back
  code(first_at, {0x3401, 0x4770});   // adds r4, #1; bx lr
  code(second_at, {0x3501, 0x4770});  // adds r5, #1; bx lr
  cpu.reset(flash_base);
  run_until(100);
  const Time before = cpu.now();
  const std::uint64_t instructions = cpu.instructions();
  nvic.pend(first);
  nvic.pend(second);
  while (!(cpu.entries_of(second) == 1 && nvic.nesting() == 0)) cpu.run(1'000'000);
  EXPECT_EQ(cpu.entries_of(first), 1u);
  EXPECT_EQ(cpu.instructions_in(first), 2u);
  EXPECT_EQ(cpu.instructions_in(second), 2u);
  // Entry, passage, return; and the instructions.
  EXPECT_EQ(cpu.now() - before, (12 + 6 + 12 + cpu.instructions() - instructions) * cycle);
}

TEST_F(CpuTest, AMoreUrgentInterruptNestsAndEveryoneGoesOnWhereTheyWere) {
  priority(first, 5);
  priority(second, 1);
  // ldr r7, =0x40000000; movs r0, #11; loop: wfi; b loop
  code(main_at, {0x4F01, 0x200B, 0xBF30, 0xE7FD});
  word(main_at + 8, 0x4000'0000);
  // movs r0, #7; str r0, [r7]; str r0, [r7, #4]; bx lr
  code(first_at, {0x2007, 0x6038, 0x6078, 0x4770});
  // movs r0, #9; str r0, [r7, #8]; bx lr
  code(second_at, {0x2009, 0x60B8, 0x4770});
  std::vector<std::pair<std::uint32_t, std::uint32_t>> written;
  on_write = [&](std::uint32_t address, std::uint32_t value) {
    written.emplace_back(address & 0xFF, value);
    if ((address & 0xFF) == 0) nvic.pend(second);
  };
  cpu.reset(flash_base);
  run_until(100);
  nvic.pend(first);
  run_until(2'000);
  // The nested handler left r0 as it was for the one it interrupted. Interrupts are taken between
  // two pieces of straight code, so the store that follows may come before it.
  ASSERT_EQ(written.size(), 3u);
  EXPECT_EQ(written[0], std::pair(0u, 7u));
  for (const auto& [place, value] : written) EXPECT_EQ(value, place == 8 ? 9u : 7u);
  EXPECT_EQ(nvic.nesting(), 0u);
  EXPECT_TRUE(cpu.sleeping());
}

TEST_F(CpuTest, AMaskedInterruptIsTakenRightAfterTheMaskFalls) {
  // cpsid i; movs r0, #100; loop: subs r0, #1; bne loop; cpsie i; wfi
  code(main_at, {0xB672, 0x2064, 0x3801, 0xD1FD, 0xB662, 0xBF30, 0xE7FD});
  code(first_at, {0x4770});
  cpu.reset(flash_base);
  run_until(20 * cycle);
  nvic.pend(first);
  while (cpu.entries_of(first) == 0) cpu.run(1'000'000);
  EXPECT_EQ(cpu.instructions_in(0), 2u + 200u + 1u);
}

TEST_F(CpuTest, SleepEndsWithAMaskedInterruptToo) {
  // cpsid i; wfi; movs r0, #1; str r0, [r7]...: goes on behind the sleep without a handler.
  code(main_at, {0xB672, 0xBF30, 0x2001, 0xE7FE});
  code(first_at, {0x4770});
  cpu.reset(flash_base);
  run_until(100);
  EXPECT_TRUE(cpu.sleeping());
  nvic.pend(first);
  run_until(200);
  EXPECT_FALSE(cpu.sleeping());
  EXPECT_EQ(cpu.entries_of(first), 0u);
}

TEST_F(CpuTest, TheStackIsAlignedForAnExceptionAndRestored) {
  // sub sp, #4; loop: wfi; b loop
  code(main_at, {0xB081, 0xBF30, 0xE7FD});
  // mov r0, sp; ldr r1, =...; str r0, [r1]; bx lr
  code(first_at, {0x4668, 0x4901, 0x6008, 0x4770});
  word(first_at + 8, 0x4000'0000);
  std::uint32_t sp = 0;
  on_write = [&](std::uint32_t, std::uint32_t value) { sp = value; };
  cpu.reset(flash_base);
  for (int i = 0; i < 3; ++i) {
    run_until(cpu.now() + 100);
    nvic.pend(first);
    run_until(cpu.now() + 200);
    EXPECT_EQ(sp, ram_base + 0x1000 - 4 - 4 - 32) << "the same each time: restored";
  }
}

TEST_F(CpuTest, AccessWithoutMemoryNamesTheAddress) {
  code(main_at, {0x4801, 0x6801, 0xE7FE, 0xBF00});  // ldr r0, =0x30000000; ldr r1, [r0]
  word(main_at + 8, 0x3000'0000);
  cpu.reset(flash_base);
  const std::string load = error_of([&] { run_until(1000); });
  EXPECT_NE(load.find("bus fault: load from 0x30000000"), std::string::npos) << load;
  EXPECT_NE(load.find("program counter 0x0800040"), std::string::npos) << load;
}

TEST_F(CpuTest, StoreWithoutMemoryAndUndefinedInstructionsStopToo) {
  code(main_at, {0x4801, 0x6001, 0xE7FE, 0xBF00});  // str r1, [r0]
  word(main_at + 8, 0x1234'5678);
  cpu.reset(flash_base);
  const std::string store = error_of([&] { run_until(1000); });
  EXPECT_NE(store.find("store to 0x12345678"), std::string::npos) << store;

  code(main_at, {0xDE00});  // udf #0
  cpu.reset(flash_base);
  EXPECT_NE(error_of([&] { run_until(cpu.now() + 1000); }), "");
}

TEST_F(CpuTest, AStackThatRunsOverIsAFault) {
  word(0, ram_base + 16);
  code(main_at, {0xBF30, 0xE7FD});
  code(first_at, {0x4770});
  cpu.reset(flash_base);
  run_until(100);
  nvic.pend(first);
  const std::string text = error_of([&] { run_until(1000); });
  EXPECT_NE(text.find("stack"), std::string::npos) << text;
}

TEST_F(CpuTest, AStoreToTheFlashGoesToTheFlashAndChangesNothing) {
  // ldr r0, =flash + 0x800; str r1, [r0]; wfi
  code(main_at, {0x4801, 0x6001, 0xBF30, 0xE7FD});
  word(main_at + 8, flash_base + 0x800);
  cpu.reset(flash_base);
  run_until(100);
  EXPECT_EQ(stored_to, flash_base + 0x800);
  EXPECT_EQ(flash[0x800], 0xFF);
}

}  // namespace
}  // namespace umov::mcu
