// A debugger at the emulated chip: registers, memory, steps, breakpoints, interrupting, by the
// bytes of GDB's protocol; and over TCP.
#include "hil/mcu/gdb/gdb_stub.hpp"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstring>

#include "hil/mcu/gdb/gdb_server.hpp"

namespace umov::mcu {
namespace {

constexpr std::uint32_t flash_base = 0x0800'0000, main_at = 0x100;

class Nothing final : public Surroundings {
 public:
  void on_pin(int, int, bool, Time) override {}
  std::uint16_t analog(unsigned, Time) override { return 0; }
  void on_serial(std::uint8_t, Time) override {}
};

class Debugger : public testing::Test {
 protected:
  Debugger() {
    const auto put = [this](std::uint32_t at, std::initializer_list<std::uint16_t> halves) {
      for (const std::uint16_t half : halves) {
        std::memcpy(&chip.flash_contents()[at], &half, 2);
        at += 2;
      }
    };
    put(0, {0x1000, 0x2000, main_at + 1, 0x0800});
    // movs r0, #0; loop: adds r0, #1; nop; b loop
    put(main_at, {0x2000, 0x3001, 0xBF00, 0xE7FC});
    chip.reset(ResetSource::power_on);
    stub.connected();
  }
  static std::string framed(const std::string& packet) {
    unsigned sum = 0;
    for (const char c : packet) sum += static_cast<unsigned char>(c);
    std::array<char, 8> tail{};
    std::snprintf(tail.data(), tail.size(), "#%02x", sum & 255u);
    return "$" + packet + tail.data();
  }
  /// The packet that answers, without its frame.
  std::string ask(const std::string& packet) {
    std::string out;
    stub.take(framed(packet), out);
    EXPECT_EQ(out.substr(0, 1), "+");
    return inside(out.substr(1));
  }
  static std::string inside(const std::string& out) {
    const std::size_t begin = out.find('$'), end = out.find('#');
    return begin == std::string::npos ? "" : out.substr(begin + 1, end - begin - 1);
  }
  std::uint32_t program_counter() { return chip.debug_register(15); }

  Nothing nothing;
  Stm32f407 chip{nothing};
  GdbStub stub{chip};
};

TEST_F(Debugger, ReadsAndWritesRegistersAndMemory) {
  EXPECT_EQ(ask("?"), "S05");
  EXPECT_EQ(ask("pf"), "00010008") << "at the beginning of the program, low byte first";
  EXPECT_EQ(ask("g").size(), 17u * 8);
  EXPECT_EQ(ask("P3=78563412"), "OK");
  EXPECT_EQ(chip.debug_register(3), 0x1234'5678u);
  EXPECT_EQ(ask("m8000100,4"), "00200130");
  EXPECT_EQ(ask("M20000010,2:beef"), "OK");
  EXPECT_EQ(ask("m20000010,2"), "beef");
  EXPECT_EQ(ask("M8000100,1:00"), "E01") << "flash is not written";
  EXPECT_EQ(ask("m40000000,4"), "E01") << "registers of peripherals are not read";
  EXPECT_EQ(ask("m8000100"), "E01");
  EXPECT_EQ(ask("qXfer:features:read:target.xml:0,fff").substr(0, 6), "l<?xml");
  EXPECT_EQ(ask("vMustReplyEmpty"), "");
}

TEST_F(Debugger, StepsInstructionByInstruction) {
  for (const std::uint32_t next : {0x102u, 0x104u, 0x106u, 0x102u, 0x104u}) {
    EXPECT_EQ(ask("s"), "S05");
    EXPECT_EQ(program_counter(), flash_base + next);
  }
  EXPECT_EQ(chip.debug_register(0), 2u);
}

TEST_F(Debugger, StopsAtABreakpointEachTimeRoundAndNotWhenItIsGone) {
  EXPECT_EQ(ask("Z0,8000104,2"), "OK");
  for (std::uint32_t round = 1; round <= 5; ++round) {
    std::string out;
    EXPECT_EQ(ask("c"), "");
    chip.run_until(chip.now() + time_per_second);
    stub.look_at_chip(out);
    EXPECT_EQ(inside(out), "S05");
    EXPECT_EQ(program_counter(), flash_base + 0x104);
    EXPECT_EQ(chip.debug_register(0), round);
  }
  EXPECT_EQ(ask("z0,8000104,2"), "OK");
  ask("c");
  const Time until = chip.now() + 1000 * time_per_us;
  chip.run_until(until);
  EXPECT_GE(chip.now(), until);
  EXPECT_FALSE(chip.halted());
}

TEST_F(Debugger, InterruptsAProgramThatRunsAndHaltsTime) {
  ask("c");
  chip.run_until(chip.now() + 1000 * time_per_us);
  std::string out;
  stub.take("\x03", out);
  EXPECT_EQ(inside(out), "S02");
  const Time now = chip.now();
  chip.run_until(now + time_per_second);
  EXPECT_EQ(chip.now(), now);
  EXPECT_EQ(ask("D"), "OK");
  chip.run_until(now + time_per_us);
  EXPECT_GT(chip.now(), now) << "detached: it goes on";
}

TEST_F(Debugger, BreakpointsOutliveAResetAndDamagedPacketsAreAskedForAgain) {
  ask("Z1,8000106,2");
  chip.reset(ResetSource::pin);
  ask("c");
  chip.run_until(chip.now() + time_per_second);
  EXPECT_TRUE(chip.halted());
  EXPECT_EQ(program_counter(), flash_base + 0x106);
  std::string out;
  stub.take("$g#00", out);
  EXPECT_EQ(out, "-");
}

TEST_F(Debugger, ComesOverTcpInPiecesOfAnySize) {
  GdbServer server(chip, 0);
  const int end = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(server.port());
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::connect(end, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  for (const char byte : framed("m8000100,4")) {
    ::send(end, &byte, 1, 0);
    server.service();
  }
  for (int i = 0; i < 100; ++i) server.service();
  std::array<char, 64> buffer{};
  const ssize_t count = ::recv(end, buffer.data(), buffer.size(), 0);
  EXPECT_EQ(std::string(buffer.data(), static_cast<std::size_t>(count)), "+" + framed("00200130"));
  ::close(end);
  for (int i = 0; i < 1000 && chip.halted(); ++i) server.service();
  EXPECT_FALSE(chip.halted()) << "the debugger has gone";
}

TEST_F(Debugger, AChipInResetOrInItsRomLoaderDoesNothing) {
  ask("D");
  chip.set_nrst(false);
  chip.run_until(chip.now() + 1000 * time_per_us);
  EXPECT_EQ(chip.instructions(), 0u);
  chip.set_boot0(true);
  chip.set_nrst(true);
  chip.run_until(chip.now() + 1000 * time_per_us);
  EXPECT_EQ(chip.instructions(), 0u) << "the ROM loader's part";
  chip.set_nrst(false);
  chip.set_boot0(false);
  chip.set_nrst(true);
  chip.run_until(chip.now() + 1000 * time_per_us);
  EXPECT_GT(chip.instructions(), 1000u);
}

}  // namespace
}  // namespace umov::mcu
