// The flash is opened by its keys only, programming clears bits only, erasure is a sector at a
// time, and all of it takes time.
#include "hil/mcu/flash.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "host/errors/error.hpp"

namespace umov::mcu {
namespace {

constexpr std::uint32_t keyr = 0x04, sr = 0x0C, cr = 0x10;
constexpr std::uint32_t word_wide = 2u << 8, program = 1, erase = 2, start = 1u << 16,
                        lock = 1u << 31;
constexpr std::uint32_t place = Flash::base + 0x1'0000;

class FlashTest : public testing::Test {
 protected:
  void open() {
    flash.write(keyr, 0x4567'0123);
    flash.write(keyr, 0xCDEF'89AB);
  }
  std::uint32_t word(std::uint32_t address) const {
    std::uint32_t value = 0;
    for (unsigned i = 0; i < 4; ++i)
      value |= static_cast<std::uint32_t>(contents[address - Flash::base + i]) << 8 * i;
    return value;
  }
  std::vector<std::uint8_t> contents;
  Time stalled = 0;
  Flash flash{contents, [this](Time t) { stalled += t; }};
};

TEST_F(FlashTest, IsLockedUntilBothKeysComeInOrder) {
  EXPECT_NE(flash.read(cr) & lock, 0u);
  flash.write(keyr, 0xCDEF'89AB);
  open();
  EXPECT_NE(flash.read(cr) & lock, 0u) << "a wrong key locks until the next reset";
  std::vector<std::uint8_t> other;
  Flash fresh(other, [](Time) {});
  fresh.write(keyr, 0x4567'0123);
  fresh.write(keyr, 0xCDEF'89AB);
  EXPECT_EQ(fresh.read(cr) & lock, 0u);
  fresh.write(cr, lock);
  EXPECT_NE(fresh.read(cr) & lock, 0u);
}

TEST_F(FlashTest, ProgrammingClearsBitsAndSetsNone) {
  open();
  flash.write(cr, word_wide | program);
  flash.store(place, 4, 0xF0F0'1234);
  EXPECT_EQ(word(place), 0xF0F0'1234u);
  flash.store(place, 4, 0x0FFF'FFFF);
  EXPECT_EQ(word(place), 0x00F0'1234u);
  EXPECT_EQ(flash.read(sr), 0u);
  EXPECT_EQ(stalled, 32 * time_per_us);
}

TEST_F(FlashTest, AStoreThatIsNotProgrammingIsAnErrorAndChangesNothing) {
  flash.store(place, 4, 0);
  EXPECT_EQ(word(place), 0xFFFF'FFFFu);
  EXPECT_NE(flash.read(sr), 0u);
  flash.write(sr, 0xFF);
  EXPECT_EQ(flash.read(sr), 0u);
  open();
  flash.write(cr, word_wide | program);
  flash.store(place, 1, 0);
  EXPECT_EQ(word(place), 0xFFFF'FFFFu) << "of another width than set";
  flash.store(place + 2, 4, 0);
  EXPECT_EQ(word(place), 0xFFFF'FFFFu) << "not aligned";
}

TEST_F(FlashTest, ErasesOneSectorAndNoByteMore) {
  std::uint32_t end = Flash::base;
  for (int i = 0; i < Flash::sector_count; ++i) {
    EXPECT_EQ(Flash::sector(i).begin, end);
    end += Flash::sector(i).size;
  }
  EXPECT_EQ(end - Flash::base, Flash::size);
  std::fill(contents.begin(), contents.end(), std::uint8_t{0});
  open();
  flash.write(cr, word_wide | erase | 4u << 3);
  flash.write(cr, word_wide | erase | 4u << 3 | start);
  for (std::size_t i = 0; i < contents.size(); ++i) {
    const bool inside = i >= 0x1'0000 && i < 0x2'0000;
    ASSERT_EQ(contents[i], inside ? 0xFF : 0) << i;
  }
  EXPECT_EQ(stalled, 550'000 * time_per_us);
}

TEST_F(FlashTest, AProtectedSectorStaysAsItIsAndSaysSo) {
  std::fill(contents.begin(), contents.end(), std::uint8_t{0x77});
  flash.protect(1u << 4);
  open();
  flash.write(cr, word_wide | program);
  flash.store(place, 4, 0);
  EXPECT_EQ(word(place), 0x7777'7777u);
  EXPECT_EQ(flash.read(sr), 1u << 4);
  flash.write(sr, 0xFF);
  flash.store(place - 4, 4, 0);
  EXPECT_EQ(word(place - 4), 0u) << "the sector before";
  EXPECT_EQ(flash.read(sr), 0u);
  flash.write(cr, word_wide | erase | 4u << 3 | start);
  EXPECT_EQ(word(place), 0x7777'7777u);
  EXPECT_EQ(flash.read(sr), 1u << 4);
  flash.protect(0);
  flash.write(cr, word_wide | erase | 4u << 3 | start);
  EXPECT_EQ(word(place), 0xFFFF'FFFFu);
}

TEST_F(FlashTest, SettingsWhileLockedAreRefused) {
  EXPECT_THROW(flash.write(cr, program), Error);
}

}  // namespace
}  // namespace umov::mcu
