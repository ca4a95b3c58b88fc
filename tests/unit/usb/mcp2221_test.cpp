// The GPIO adapter as its data sheet and Linux' driver have it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "hil/usbip/bus.hpp"
#include "hil/usbip/mcp2221.hpp"

namespace umov::test {
namespace {

using usbip::Handshake;
using usbip::Packet;

class Wires final : public usbip::GpioLines {
 public:
  void drive(int pin, std::optional<bool> level) override { driven[pin] = level; }
  bool level(int pin) const override { return pin == 1; }
  std::map<int, std::optional<bool>> driven;
};

class Adapter : public ::testing::Test {
 protected:
  Adapter() { plug_in(); }
  void plug_in() {
    adapter.bus_reset();
    EXPECT_EQ(adapter.setup({0x00, 9, 1, 0, 0, 0, 0, 0}), Handshake::ack);
    Packet status;
    EXPECT_EQ(adapter.in(0, status), Handshake::ack);
  }
  /// What the driver sends and does not want answered while it probes.
  void probe() {
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(adapter.out(3, std::vector<std::uint8_t>{0x10}), Handshake::stall);
    }
    for (int i = 0; i < 4; ++i) {
      EXPECT_EQ(adapter.out(3, std::vector<std::uint8_t>{0x51}), Handshake::stall);
    }
  }
  Packet ask(const std::vector<std::uint8_t>& command) {
    EXPECT_EQ(adapter.out(3, command), Handshake::ack);
    Packet answer;
    EXPECT_EQ(adapter.in(3, answer), Handshake::ack);
    EXPECT_EQ(answer.size, 64u);
    EXPECT_EQ(answer.bytes[0], command[0]);
    return answer;
  }
  /// The command for one pin: level and direction (1 is input).
  static std::vector<std::uint8_t> set(std::size_t pin, std::uint8_t level, std::uint8_t input) {
    std::vector<std::uint8_t> command(18);
    command[0] = 0x50;
    command[2 + 4 * pin] = 1;
    command[3 + 4 * pin] = level;
    command[4 + 4 * pin] = 1;
    command[5 + 4 * pin] = input;
    return command;
  }

  Wires wires;
  usbip::Mcp2221 adapter{wires};
};

TEST_F(Adapter, all_pins_let_go_of_their_wires_when_it_is_plugged_in) {
  probe();
  ask(set(2, 0, 0));
  EXPECT_EQ(wires.driven[2], std::optional<bool>(false));
  plug_in();
  for (int pin = 0; pin < 4; ++pin) EXPECT_EQ(wires.driven[pin], std::nullopt) << pin;
}

TEST_F(Adapter, an_output_drives_its_wire_and_an_input_reads_it) {
  probe();
  EXPECT_EQ(ask(set(0, 1, 0)).bytes[1], 0);
  EXPECT_EQ(wires.driven[0], std::optional<bool>(true));
  Packet levels = ask({0x51});
  EXPECT_EQ(levels.bytes[1], 0);
  EXPECT_EQ(levels.bytes[2], 1) << "driven high";
  EXPECT_EQ(levels.bytes[4], 1) << "pulled up";
  EXPECT_EQ(levels.bytes[6], 0) << "pulled down";
  ask(set(0, 1, 1));
  EXPECT_EQ(wires.driven[0], std::nullopt) << "an input again";
  EXPECT_EQ(ask({0x51}).bytes[2], 0);
}

TEST_F(Adapter, only_the_fields_that_are_marked_change) {
  probe();
  ask(set(1, 1, 0));
  std::vector<std::uint8_t> direction_only(18);
  direction_only[0] = 0x50;
  direction_only[2 + 4 + 2] = 1;
  direction_only[2 + 4 + 3] = 1;
  ask(direction_only);
  EXPECT_EQ(wires.driven[1], std::nullopt);
  direction_only[2 + 4 + 3] = 0;
  ask(direction_only);
  EXPECT_EQ(wires.driven[1], std::optional<bool>(true)) << "the level is remembered";
}

TEST_F(Adapter, what_it_does_not_have_is_said_to_be_missing) {
  probe();
  EXPECT_EQ(ask({0x90, 1, 0, 0x20}).bytes[1], 1) << "I2C write";
  EXPECT_EQ(ask({0xb0, 0}).bytes[1], 1) << "flash";
  const Packet status = ask({0x10, 0, 0, 0x20, 0x75});
  EXPECT_EQ(status.bytes[1], 0);
  EXPECT_EQ(status.bytes[3], 0x20) << "a new I2C speed is taken";
}

TEST_F(Adapter, commands_wait_until_the_last_answer_was_fetched) {
  probe();
  EXPECT_EQ(adapter.out(3, std::vector<std::uint8_t>{0x51}), Handshake::ack);
  EXPECT_EQ(adapter.out(3, std::vector<std::uint8_t>{0x51}), Handshake::nak);
  Packet answer;
  EXPECT_EQ(adapter.in(3, answer), Handshake::ack);
  EXPECT_EQ(adapter.in(3, answer), Handshake::nak);
}

}  // namespace
}  // namespace umov::test
