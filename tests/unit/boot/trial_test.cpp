// A newly installed image is on trial: confirmed it stays, given up it makes room for the one
// before it, and a power cut in any of it leaves something that starts.
#include "firmware/boot/trial.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/boot/notes.hpp"
#include "firmware/boot/place_tail.hpp"
#include "firmware/boot/start.hpp"
#include "tests/unit/boot/dfu_bench.hpp"

namespace umov {
namespace {

namespace dfu = protocol::dfu;
using boot_place = firmware::boot::Place;
using firmware::boot::Note;
using firmware::boot::Notes;
using firmware::boot::Reason;
using firmware::boot::Restart;
using firmware::boot::Start;
using firmware::boot::Trial;
using protocol::Fault;
using protocol::RollBackReason;
using test::Bytes;
using test::DfuBench;
using test::Keys;
using test::make_image;
using test::RamFlash;

constexpr std::size_t place_bytes = 32 * 1024;
/// Short: half a place that has been erased need not touch it.
constexpr std::uint32_t program_bytes = 6'004;
constexpr std::uint32_t v1 = protocol::image_version(1, 0, 0),
                        v2 = protocol::image_version(1, 2, 3),
                        v3 = protocol::image_version(1, 3, 0);

class OnTrial : public testing::Test {
 protected:
  void SetUp() override {
    flash_.put(boot_place::running, old_);
    install(flash_, new_);
  }
  void install(RamFlash& flash, const Bytes& image, Reason why = Reason::none) {
    DfuBench bench(flash, trust_, why);
    instrument::dfu_download(bench, image);
  }
  /// The update that is cut off when so many bytes have been written, and the start after it; what
  /// that start says. An erasure clears its last half first, where the trial's marks lie.
  Start install_cut(RamFlash& flash, const Bytes& image, std::size_t cut, Reason why) {
    flash.cut_erases_front = false;
    flash.bytes_left = cut;
    EXPECT_THROW(install(flash, image, why), test::PowerCut);
    flash.bytes_left.reset();
    return start(flash, Restart::power);
  }
  /// Bytes that an update writes, erasures included.
  std::size_t cost_of(RamFlash flash, const Bytes& image, Reason why) {
    flash.written = 0;
    install(flash, image, why);
    return flash.written;
  }
  Start start(RamFlash& flash, Restart why) { return make_runnable(flash, trust_, why).start; }
  void fail_starts(RamFlash& flash, int count, Restart why = Restart::watchdog) {
    for (int i = 0; i < count; ++i) start(flash, why);
  }

  const Keys keys_{1};
  const firmware::boot::Trust trust_{test::board_name, keys_.key};
  const Bytes old_ = make_image(v1, program_bytes, keys_);
  const Bytes new_ = make_image(v2, program_bytes + 300, keys_);
  RamFlash flash_{place_bytes};
};

TEST_F(OnTrial, AnImageThatFailsThreeStartsMakesRoomForTheOneBeforeItAndANoteSaysWhy) {
  EXPECT_TRUE(Trial(flash_).open());
  EXPECT_EQ(start(flash_, Restart::asked), Start::program) << "the first start";
  for (std::uint32_t failed = 1; failed < Trial::most_failures; ++failed) {
    EXPECT_EQ(start(flash_, Restart::watchdog), Start::program);
    EXPECT_TRUE(flash_.holds(boot_place::running, new_)) << failed;
    EXPECT_EQ(Trial(flash_).failures(), failed);
  }
  EXPECT_FALSE(Notes(flash_).next());
  const auto decision = make_runnable(flash_, trust_, Restart::crash);
  EXPECT_EQ(decision.start, Start::program);
  EXPECT_TRUE(decision.rolled_back);
  EXPECT_TRUE(flash_.holds(boot_place::running, old_));
  EXPECT_FALSE(Trial(flash_).open()) << "that one has proved itself before";
  const auto note = Notes(flash_).next();
  ASSERT_TRUE(note);
  EXPECT_EQ(note->fault, Fault::rolled_back);
  EXPECT_EQ(protocol::roll_back_reason(note->detail), RollBackReason::crash);
  EXPECT_EQ(protocol::roll_back_version(note->detail), v2);
  const auto written = flash_.written;
  fail_starts(flash_, 5);
  EXPECT_TRUE(flash_.holds(boot_place::running, old_)) << "whatever befalls it";
  EXPECT_EQ(flash_.written, written);
}

TEST_F(OnTrial, StartsThatTheSupplyOrAnAgreementEndedSayNothingAboutTheImage) {
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(start(flash_, i % 2 == 0 ? Restart::power : Restart::asked), Start::program);
  }
  EXPECT_EQ(Trial(flash_).failures(), 0u);
  for (const auto& [why, reason] : {std::pair{Restart::button, RollBackReason::button},
                                    {Restart::crash, RollBackReason::crash},
                                    {Restart::watchdog, RollBackReason::watchdog}}) {
    RamFlash flash = flash_;
    start(flash, why);
    EXPECT_EQ(Trial(flash).failures(), 1u);
    EXPECT_EQ(Trial(flash).last_failure(), reason);
  }
}

TEST_F(OnTrial, AConfirmedImageStaysWhateverBefallsIt) {
  fail_starts(flash_, 2);
  ASSERT_TRUE(Trial(flash_).confirm());
  EXPECT_FALSE(Trial(flash_).open());
  const auto written = flash_.written;
  fail_starts(flash_, 9);
  EXPECT_TRUE(flash_.holds(boot_place::running, new_));
  EXPECT_TRUE(Trial(flash_).confirm());
  EXPECT_EQ(flash_.written, written) << "nothing is written to a settled image";
}

TEST_F(OnTrial, APowerCutWithinTheConfirmationLeavesItOnTrialOrConfirmed) {
  int confirmed = 0;
  for (std::size_t cut = 0; cut <= 4; ++cut) {
    RamFlash flash = flash_;
    flash.bytes_left = cut;
    try {
      Trial(flash).confirm();
    } catch (const test::PowerCut&) {
    }
    flash.bytes_left.reset();
    confirmed += Trial(flash).open() ? 0 : 1;
    EXPECT_EQ(start(flash, Restart::power), Start::program);
    EXPECT_TRUE(flash.holds(boot_place::running, new_));
    EXPECT_TRUE(Trial(flash).confirm());
    EXPECT_FALSE(Trial(flash).open()) << cut;
  }
  EXPECT_EQ(confirmed, 5) << "from its first bit on";
}

TEST_F(OnTrial, OnlyAProvenImageIsKeptWhenAnotherComes) {
  const Bytes third = make_image(v3, program_bytes, keys_);
  {
    RamFlash flash = flash_;
    install(flash, third);
    EXPECT_TRUE(flash.holds(boot_place::running, third));
    EXPECT_TRUE(flash.holds(boot_place::previous, old_)) << "not the one that was on trial";
    fail_starts(flash, 3);
    EXPECT_TRUE(flash.holds(boot_place::running, old_));
  }
  Trial(flash_).confirm();
  install(flash_, third);
  EXPECT_TRUE(flash_.holds(boot_place::previous, new_));
}

TEST_F(OnTrial, AfterARollBackAnotherUpdateGoesItsWay) {
  fail_starts(flash_, 3);
  const Bytes third = make_image(v3, program_bytes, keys_);
  install(flash_, third);
  EXPECT_TRUE(Trial(flash_).open());
  EXPECT_EQ(Trial(flash_).failures(), 0u);
  EXPECT_FALSE(Notes(flash_).next()) << "notes are of one update";
  fail_starts(flash_, 3);
  EXPECT_TRUE(flash_.holds(boot_place::running, old_));
  EXPECT_EQ(protocol::roll_back_version(Notes(flash_).next()->detail), v3);
}

TEST_F(OnTrial, WithNothingToGoBackToTheBootLoaderWaitsAndSaysWhy) {
  flash_.at(boot_place::previous)[700] ^= 1;
  fail_starts(flash_, 2);
  EXPECT_EQ(start(flash_, Restart::watchdog), Start::failed_trial);
  EXPECT_EQ(start(flash_, Restart::power), Start::failed_trial) << "and after a power cycle";
  EXPECT_FALSE(Notes(flash_).next()) << "nothing was rolled back";
  {
    DfuBench bench(flash_, trust_, Reason::failed_trial);
    EXPECT_THAT(instrument::dfu_trouble(bench), testing::HasSubstr("failed its trial"));
    EXPECT_FALSE(bench.write(dfu::detach, 0, {}));
    EXPECT_FALSE(bench.write(dfu::abort, 0, {}));
    EXPECT_FALSE(bench.write(dfu::download, 0, std::span(new_).first(64)));
    EXPECT_FALSE(bench.read(dfu::upload, 0, 64).good);
    EXPECT_FALSE(bench.read(77, 0, 64).good);
    EXPECT_FALSE(bench.device.leaving());
    EXPECT_THAT(instrument::dfu_trouble(bench), testing::HasSubstr("failed its trial"))
        << "whatever it was asked for";
    instrument::make_dfu_idle(bench);
    EXPECT_EQ(instrument::dfu_trouble(bench), "") << "an update is under way";
    EXPECT_EQ(instrument::dfu_upload(bench), new_) << "what failed can be looked at";
  }
  {
    RamFlash flash = flash_;
    install(flash, make_image(v1, program_bytes, keys_), Reason::failed_trial);
    EXPECT_TRUE(flash.holds(boot_place::running, old_)) << "older than the one that failed";
    EXPECT_EQ(start(flash, Restart::power), Start::program);
  }
  install(flash_, new_, Reason::failed_trial);
  EXPECT_EQ(Trial(flash_).failures(), 0u) << "the same image gets another trial";
  EXPECT_EQ(start(flash_, Restart::power), Start::program);
}

TEST_F(OnTrial, ABoardWithoutAnImageSaysSo) {
  RamFlash empty(place_bytes);
  EXPECT_EQ(start(empty, Restart::power), Start::no_image);
  DfuBench bench(empty, trust_, Reason::empty);
  EXPECT_EQ(instrument::dfu_trouble(bench), "there is no good image in it");
  EXPECT_EQ(instrument::dfu_download(bench, new_), "");
}

/// The power is cut after every byte of the marks and every 256th byte of the copies, in erasures
/// half-way, front or back first: from the first failed start to the end of the roll-back.
TEST_F(OnTrial, CutAnywhereUntilTheRollBackIsDoneEndsInTheImageBeforeIt) {
  RamFlash whole = flash_;
  whole.written = 0;
  fail_starts(whole, 3);
  const std::size_t total = whole.written;
  ASSERT_GT(total, old_.size() + RamFlash::erase_cost);
  int news = 0, olds = 0;
  for (const bool front : {false, true}) {
    const std::size_t marks = 4 * 3 + 2 * 4 + 4;  // three failures, a note, the header's end
    for (std::size_t cut = 0; cut < total; cut += cut < marks ? 1 : 256) {
      RamFlash flash = flash_;
      flash.cut_erases_front = front;
      flash.bytes_left = cut;
      EXPECT_THROW(fail_starts(flash, 3), test::PowerCut);
      flash.bytes_left.reset();
      ASSERT_EQ(start(flash, Restart::power), Start::program) << "cut at " << cut;
      const bool old = flash.holds(boot_place::running, old_);
      ASSERT_TRUE(old || flash.holds(boot_place::running, new_)) << "cut at " << cut;
      (old ? olds : news) += 1;
      if (!old) {
        ASSERT_TRUE(Trial(flash).open()) << "cut at " << cut;
      }
      fail_starts(flash, 3);
      ASSERT_TRUE(flash.holds(boot_place::running, old_)) << "cut at " << cut;
      Notes notes(flash);
      const auto note = notes.next();
      ASSERT_TRUE(note) << "cut at " << cut;
      EXPECT_EQ(note->fault, Fault::rolled_back);
      EXPECT_EQ(protocol::roll_back_version(note->detail), v2) << "cut at " << cut;
      ASSERT_TRUE(notes.mark_told());
      EXPECT_FALSE(notes.next()) << "told once";
    }
  }
  EXPECT_EQ(news, 2 * 8) << "until the first bit of the third failure";
  EXPECT_GE(olds, 40);
}

/// And the start that ends a roll-back may be cut, again and again.
TEST_F(OnTrial, ARollBackCutOverAndOverStillEnds) {
  fail_starts(flash_, 2);
  for (std::size_t left = 3; left < 9'000; left += 331) {
    flash_.bytes_left = left;
    try {
      EXPECT_EQ(start(flash_, Restart::watchdog), Start::program);
    } catch (const test::PowerCut&) {
    }
  }
  flash_.bytes_left.reset();
  ASSERT_EQ(start(flash_, Restart::power), Start::program);
  EXPECT_TRUE(flash_.holds(boot_place::running, old_));
  EXPECT_TRUE(Notes(flash_).waits(Fault::rolled_back));
}

TEST_F(OnTrial, AnotherUpdateCutAnywhereNeverTakesTheImageOnTrialForAProvenOne) {
  const Bytes third = make_image(v3, program_bytes, keys_);
  fail_starts(flash_, 2);
  int news = 0, thirds = 0;
  const std::size_t total = cost_of(flash_, third, Reason::none);
  for (std::size_t cut = 0; cut < total; cut += 61) {
    RamFlash flash = flash_;
    ASSERT_EQ(install_cut(flash, third, cut, Reason::none), Start::program) << "cut at " << cut;
    const bool come = flash.holds(boot_place::running, third);
    ASSERT_TRUE(come || flash.holds(boot_place::running, new_)) << "cut at " << cut;
    (come ? thirds : news) += 1;
    ASSERT_TRUE(Trial(flash).open()) << "cut at " << cut;
    EXPECT_EQ(Trial(flash).failures(), come ? 0u : 2u) << "cut at " << cut;
    ASSERT_TRUE(flash.holds(boot_place::previous, old_)) << "cut at " << cut;
    fail_starts(flash, 3);
    ASSERT_TRUE(flash.holds(boot_place::running, old_)) << "cut at " << cut;
  }
  EXPECT_GE(news, 40);
  EXPECT_GE(thirds, 40);
}

TEST_F(OnTrial, TheFailedImageSentAgainAndCutAnywhereHasFailedOrIsOnTrialAnew) {
  flash_.at(boot_place::previous)[700] ^= 1;
  fail_starts(flash_, 3);
  int failed = 0, anew = 0;
  const std::size_t total = cost_of(flash_, new_, Reason::failed_trial);
  for (std::size_t cut = 0; cut < total; cut += 61) {
    RamFlash flash = flash_;
    const Start after = install_cut(flash, new_, cut, Reason::failed_trial);
    ASSERT_TRUE(flash.holds(boot_place::running, new_)) << "cut at " << cut;
    ASSERT_TRUE(Trial(flash).open()) << "cut at " << cut;
    const bool again = after == Start::program;
    (again ? anew : failed) += 1;
    EXPECT_EQ(Trial(flash).failures(), again ? 0u : Trial::most_failures) << "cut at " << cut;
    if (!again) {
      EXPECT_EQ(after, Start::failed_trial) << "cut at " << cut;
    }
    fail_starts(flash, 3);
    EXPECT_EQ(start(flash, Restart::power), Start::failed_trial) << "cut at " << cut;
  }
  EXPECT_GE(failed, 40);
  EXPECT_GE(anew, 40);
}

TEST_F(OnTrial, NotesAreToldInTurnOnceEachAndATornOneIsPassedOver) {
  const std::array notes = {Note{Fault::no_fallback, 1}, Note{Fault::rolled_back, 0x301'0203}};
  for (std::size_t cut = 0; cut <= 12; ++cut) {
    RamFlash flash(place_bytes);
    flash.bytes_left = cut;
    try {
      Notes(flash).leave(notes[0]);
    } catch (const test::PowerCut&) {
    }
    flash.bytes_left.reset();
    Notes left(flash);
    const bool there = left.next().has_value();
    EXPECT_EQ(there, cut >= 8) << cut;
    ASSERT_TRUE(left.leave(notes[0])) << "written anew, unless it is there";
    ASSERT_TRUE(left.leave(notes[1]));
    for (const Note& note : notes) {
      EXPECT_EQ(left.next(), note) << cut;
      EXPECT_TRUE(left.mark_told());
    }
    EXPECT_FALSE(left.next());
  }
  RamFlash flash(place_bytes);
  Notes full(flash);
  for (std::uint32_t i = 0; i < Notes::capacity; ++i) {
    ASSERT_TRUE(full.leave(notes[i % 2]));
    ASSERT_TRUE(full.mark_told());
  }
  EXPECT_FALSE(full.leave(notes[0])) << "no room";
}

}  // namespace
}  // namespace umov
