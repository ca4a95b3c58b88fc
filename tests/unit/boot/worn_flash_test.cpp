// Flash that takes no more writing: the controller goes on with what is good, and says what it
// lacks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/boot/notes.hpp"
#include "firmware/boot/start.hpp"
#include "tests/unit/boot/dfu_bench.hpp"

namespace umov {
namespace {

using boot_place = firmware::boot::Place;
using firmware::boot::Note;
using firmware::boot::Notes;
using firmware::boot::Reason;
using firmware::boot::Restart;
using firmware::boot::Start;
using firmware::boot::Trial;
using protocol::Fault;
using test::Bytes;
using test::DfuBench;
using test::Keys;
using test::make_image;
using test::RamFlash;
using testing::HasSubstr;

constexpr std::size_t place_bytes = 32 * 1024;
constexpr std::uint32_t program_bytes = 20'004;
constexpr std::uint32_t v1 = protocol::image_version(1, 0, 0),
                        v2 = protocol::image_version(1, 2, 3);

class WornFlash : public testing::Test {
 protected:
  void SetUp() override {
    flash_.put(boot_place::running, old_);
    // A byte that both images have set bits in.
    stuck_.stuck_byte = 2'000;
    while (old_[*stuck_.stuck_byte] == 0 || new_[*stuck_.stuck_byte] == 0) ++*stuck_.stuck_byte;
  }
  std::string update(RamFlash& flash) {
    DfuBench bench(flash, trust_);
    return instrument::dfu_download(bench, new_);
  }
  Start start(RamFlash& flash, Restart why = Restart::power) {
    return make_runnable(flash, trust_, why).start;
  }

  const Keys keys_{1};
  const firmware::boot::Trust trust_{test::board_name, keys_.key};
  const Bytes older_ = make_image(v1 - 1, program_bytes, keys_);
  const Bytes old_ = make_image(v1, program_bytes, keys_);
  const Bytes new_ = make_image(v2, program_bytes + 3'000, keys_);
  RamFlash flash_{place_bytes};
  const RamFlash::Wear unerasable_{.refuses_erasure = true, .stuck_byte = {}};
  RamFlash::Wear stuck_{};
};

TEST_F(WornFlash, WhereTheImageBeforeShouldBeKeptTheUpdateGoesOnAndSaysThatThereIsNoWayBack) {
  for (const auto& wear : {unerasable_, stuck_}) {
    RamFlash flash = flash_;
    flash.wear_of(boot_place::previous) = wear;
    EXPECT_THAT(update(flash), HasSubstr("could not be kept"));
    EXPECT_TRUE(flash.holds(boot_place::running, new_));
    EXPECT_EQ(Notes(flash).next(), (Note{Fault::no_fallback, protocol::none_to_fall_back_to}));
    const auto erasures = flash.erasures;
    const auto written = flash.written;
    for (int i = 0; i < 3; ++i) EXPECT_EQ(start(flash), Start::program);
    EXPECT_EQ(flash.erasures, erasures) << "no start tries again what cannot be";
    EXPECT_EQ(flash.written, written);
    for (int i = 0; i < 2; ++i) EXPECT_EQ(start(flash, Restart::watchdog), Start::program);
    EXPECT_EQ(start(flash, Restart::watchdog), Start::failed_trial);
    DfuBench bench(flash, trust_, Reason::failed_trial);
    EXPECT_THAT(instrument::dfu_download(bench, make_image(v2 + 1, program_bytes, keys_)), "")
        << "one that failed is not worth keeping";
    EXPECT_EQ(start(flash), Start::program);
  }
}

TEST_F(WornFlash, AnOlderImageThatStandsInTheWornPlaceIsBetterThanNone) {
  flash_.put(boot_place::previous, older_);
  flash_.wear_of(boot_place::previous) = unerasable_;
  EXPECT_THAT(update(flash_), HasSubstr("could not be kept"));
  EXPECT_EQ(Notes(flash_).next(), (Note{Fault::no_fallback, protocol::only_an_older_one}));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(start(flash_, Restart::crash), Start::program);
  EXPECT_TRUE(flash_.holds(boot_place::running, older_));
}

TEST_F(WornFlash, APowerCutInAnUpdateThatCannotKeepTheOldImageLeavesTheOldOrTheNew) {
  for (const auto& wear : {unerasable_, stuck_}) {
    RamFlash worn = flash_;
    worn.wear_of(boot_place::previous) = wear;
    RamFlash whole = worn;
    update(whole);
    int olds = 0, news = 0;
    for (std::size_t cut = 0; cut < whole.written; cut += 256) {
      RamFlash flash = worn;
      flash.bytes_left = cut;
      EXPECT_THROW(update(flash), test::PowerCut);
      flash.bytes_left.reset();
      ASSERT_EQ(start(flash), Start::program) << cut;
      const bool is_new = flash.holds(boot_place::running, new_);
      ASSERT_TRUE(is_new || flash.holds(boot_place::running, old_)) << cut;
      if (is_new) {
        EXPECT_TRUE(Notes(flash).waits(Fault::no_fallback)) << cut;
      }
      (is_new ? news : olds) += 1;
    }
    EXPECT_GT(olds, 80);
    EXPECT_GT(news, 80);
  }
}

TEST_F(WornFlash, WhereTheProgramRunsLeavesABootLoaderThatSaysSo) {
  for (const auto& wear : {unerasable_, stuck_}) {
    RamFlash flash = flash_;
    flash.wear_of(boot_place::running) = wear;
    EXPECT_THROW(update(flash), instrument::UpdateRefused);
    const bool old_is_left = flash.holds(boot_place::running, old_);
    EXPECT_EQ(start(flash), old_is_left ? Start::program : Start::flash_fails);
    EXPECT_EQ(start(flash), old_is_left ? Start::program : Start::flash_fails) << "every time";
  }
  DfuBench bench(flash_, trust_, Reason::worn_out);
  EXPECT_THAT(instrument::dfu_trouble(bench), HasSubstr("flash memory fails where the image"));
}

TEST_F(WornFlash, AFailedStartThatCannotBeNotedEndsInTheBootLoaderUntilThePowerIsCycled) {
  update(flash_);
  // The word of the first failure reads 0 in one byte of what is written there.
  flash_.fails_at = flash_.written;
  EXPECT_EQ(start(flash_, Restart::watchdog), Start::flash_fails);
  flash_.fails_at.reset();
  EXPECT_EQ(start(flash_, Restart::power), Start::program);
}

TEST_F(WornFlash, AnUpdateThatCannotBeMarkedAsCarriedOutIsCalledOffBeforeARollBack) {
  // Installed and marked as ordered for ever: a roll-back must not be undone by the next start.
  update(flash_);
  auto mark = flash_.at(boot_place::staged).end() - 4;
  std::copy_n("INST", 4, mark);
  struct Stubborn final : firmware::boot::Flash {
    explicit Stubborn(RamFlash& inside) : flash(&inside) {}
    std::span<const std::uint8_t> contents(boot_place place) const override {
      return flash->contents(place);
    }
    bool erase(boot_place place) override { return flash->erase(place); }
    bool program(boot_place place, std::uint32_t offset,
                 std::span<const std::uint8_t> bytes) override {
      const bool is_mark = place == boot_place::staged && offset == place_bytes - 4;
      return !is_mark && flash->program(place, offset, bytes);
    }
    RamFlash* flash;
  } stubborn(flash_);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(make_runnable(stubborn, trust_, Restart::watchdog).start, Start::program);
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(flash_.holds(boot_place::running, old_));
    EXPECT_EQ(make_runnable(stubborn, trust_, Restart::power).start, Start::program);
  }
}

}  // namespace
}  // namespace umov
