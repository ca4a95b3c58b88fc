// Settings that survive: the two pages in flash with the power cut at every word, damage, and what
// the controller makes of it.
#include <gtest/gtest.h>

#include <optional>

#include "firmware/core/config/settings_pages.hpp"
#include "tests/unit/firmware/bench.hpp"

namespace umov {
namespace {

using test::Bench;
using test::SmallWorld;
namespace fw = firmware;
namespace pr = protocol;
using Loaded = fw::SettingsStore::Loaded;

struct PowerCut {};

/// Programming only clears bits; the power can be cut within the n-th word or erasure from now.
class FakePages final : public fw::FlashPages {
 public:
  explicit FakePages(std::uint32_t words) { contents.fill(std::vector(words, 0xFFFF'FFFFu)); }
  std::uint32_t words_per_page() const override {
    return static_cast<std::uint32_t>(contents[0].size());
  }
  std::uint32_t read(int page, std::uint32_t word) const override { return at(page)[word]; }
  bool program(int page, std::uint32_t word, std::span<const std::uint32_t> words) override {
    for (const std::uint32_t value : words) {
      std::uint32_t& cell = at(page)[word++];
      if (cut_after && (*cut_after)-- == 0) {
        cell &= value | 0xA5A5'A5A5u;  // some bits were quicker
        throw PowerCut{};
      }
      EXPECT_EQ(cell, 0xFFFF'FFFFu) << "a word is programmed once";
      cell &= value;
    }
    return true;
  }
  bool erase(int page) override {
    if (worn_out) return false;
    ++erasures;
    auto& words = at(page);
    if (cut_after && (*cut_after)-- == 0) {
      // About a third, and not by whole slots.
      const auto part = static_cast<std::ptrdiff_t>(words.size() / 3);
      std::fill_n(cut_erases_front ? words.begin() : words.end() - part, part, 0xFFFF'FFFFu);
      throw PowerCut{};
    }
    std::fill(words.begin(), words.end(), 0xFFFF'FFFFu);
    return true;
  }
  std::vector<std::uint32_t>& at(int page) { return contents[static_cast<std::size_t>(page)]; }
  const std::vector<std::uint32_t>& at(int page) const {
    return contents[static_cast<std::size_t>(page)];
  }

  std::array<std::vector<std::uint32_t>, 2> contents;
  std::optional<int> cut_after;
  int erasures = 0;
  bool cut_erases_front = true;
  bool worn_out = false;  ///< cannot be erased
};

constexpr std::uint16_t layout = 7;
using Value = std::array<std::uint8_t, 20>;

Value value_of(int number) {
  Value value;
  for (std::size_t i = 0; i < value.size(); ++i)
    value[i] = static_cast<std::uint8_t>(number + 13 * static_cast<int>(i));
  return value;
}

/// What a start finds; -1: nothing saved, -2: damage.
int number_found(FakePages& flash) {
  fw::SettingsPages pages(flash);
  pages.begin();
  Value value{};
  switch (pages.load(layout, value)) {
    case Loaded::none:
      return -1;
    case Loaded::good:
      EXPECT_EQ(value, value_of(value[0]));
      return value[0];
    default:
      return -2;
  }
}

TEST(SettingsPages, KeepTheLastOfManySavingsOverRestartsAndEraseOnlyAtStarts) {
  FakePages flash(4 * fw::SettingsPages::slot_words);
  int saved = 0;
  for (int start = 0; start < 30; ++start) {
    fw::SettingsPages pages(flash);
    pages.begin();
    const int erased_at_start = flash.erasures;
    for (int i = 0; i < start % 4; ++i) ASSERT_TRUE(pages.save(layout, value_of(++saved)));
    EXPECT_EQ(flash.erasures, erased_at_start);
    EXPECT_EQ(number_found(flash), saved == 0 ? -1 : saved);
  }
}

TEST(SettingsPages, AreSavedWithoutEndWhileRunningByErasingAPageThatHoldsOlderOnesOnly) {
  FakePages flash(4 * fw::SettingsPages::slot_words);
  fw::SettingsPages pages(flash);
  pages.begin();
  for (int saved = 1; saved <= 100; ++saved) {
    const bool slow = pages.next_save_is_slow();
    const int erasures = flash.erasures;
    ASSERT_TRUE(pages.save(layout, value_of(saved)));
    ASSERT_EQ(flash.erasures > erasures, slow) << saved;
    FakePages now = flash;
    ASSERT_EQ(number_found(now), saved) << "a start at this moment";
  }
  EXPECT_EQ(flash.erasures, 100 / 4 - 1) << "no page more often than it is filled";
}

TEST(SettingsPages, AreRefusedWhileRunningWhereThePageCannotBeErasedAndTheOldOnesStay) {
  FakePages flash(4 * fw::SettingsPages::slot_words);
  fw::SettingsPages pages(flash);
  pages.begin();
  flash.worn_out = true;
  int saved = 0;
  while (pages.save(layout, value_of(saved + 1))) ++saved;
  EXPECT_EQ(saved, 4 + 3) << "the last slot stays free as long as the other page is not blank";
  EXPECT_EQ(number_found(flash), saved);
  flash.worn_out = false;
  EXPECT_TRUE(pages.save(layout, value_of(99)));
  EXPECT_EQ(number_found(flash), 99);
}

/// How the flash came to hold what it holds when the power is cut.
struct Past {
  const char* description;
  bool restarts;          ///< after each saving
  bool cut_erases_front;  ///< what an erasure has done when it is cut
};

class SettingsCutShort : public testing::TestWithParam<Past> {};

TEST_P(SettingsCutShort, AtAnyWordOrErasureAreTheOldOrTheNew) {
  int olds = 0, news = 0, erasures_cut = 0;
  for (int before = 0; before < 13; ++before) {
    for (int cut = 0; cut < 2 + 64; ++cut) {
      FakePages flash(4 * fw::SettingsPages::slot_words);
      flash.cut_erases_front = GetParam().cut_erases_front;
      auto pages = std::make_unique<fw::SettingsPages>(flash);
      const auto restart = [&] {
        pages = std::make_unique<fw::SettingsPages>(flash);
        pages->begin();
      };
      restart();
      for (int i = 1; i <= before; ++i) {
        ASSERT_TRUE(pages->save(layout, value_of(i)));
        if (GetParam().restarts && i < before) restart();
      }
      flash.cut_after = cut;
      const int erasures = flash.erasures;
      bool was_cut = false;
      try {
        if (GetParam().restarts) restart();
        pages->save(layout, value_of(before + 1));
      } catch (const PowerCut&) {
        was_cut = true;
      }
      if (was_cut && cut == 0 && flash.erasures > erasures) ++erasures_cut;
      flash.cut_after.reset();
      const int found = number_found(flash);
      if (found == before + 1) {
        ++news;
      } else {
        ASSERT_EQ(found, before == 0 ? -1 : before) << "cut at " << cut;
        ++olds;
      }
      restart();
      ASSERT_TRUE(pages->save(layout, value_of(200)));
      ASSERT_EQ(number_found(flash), 200) << "it goes on after that";
    }
  }
  EXPECT_GT(olds, 700);
  EXPECT_GT(news, 12);
  EXPECT_GE(erasures_cut, 2);
}

INSTANTIATE_TEST_SUITE_P(Settings, SettingsCutShort,
                         testing::Values(Past{"AfterRestartsFrontErased", true, true},
                                         Past{"AfterRestartsBackErased", true, false},
                                         Past{"WhileRunningFrontErased", false, true},
                                         Past{"WhileRunningBackErased", false, false}),
                         [](const auto& one) { return std::string(one.param.description); });

TEST(SettingsPages, DamageToTheLastSavedIsFoundAndTheNextSavingEndsIt) {
  for (int saved = 1; saved <= 5; ++saved) {
    for (const std::uint32_t word : {1u, 3u, 62u}) {
      FakePages flash(4 * fw::SettingsPages::slot_words);
      fw::SettingsPages pages(flash);
      pages.begin();
      for (int i = 1; i <= saved; ++i) ASSERT_TRUE(pages.save(layout, value_of(i)));
      const int page = saved == 5 ? 1 : 0;
      const auto slot = static_cast<std::uint32_t>(saved - 1) % 4;
      flash.at(page)[slot * fw::SettingsPages::slot_words + word] &= ~0x10u;
      flash.at(page)[slot * fw::SettingsPages::slot_words + word] ^= 0x8000'0000u;
      EXPECT_EQ(number_found(flash), -2);
      EXPECT_EQ(number_found(flash), -2) << "also at the start after that";
      fw::SettingsPages again(flash);
      again.begin();
      ASSERT_TRUE(again.save(layout, value_of(77)));
      EXPECT_EQ(number_found(flash), 77);
    }
  }
}

TEST(SettingsPages, FlashThatHeldSomethingElseTakesSettingsAfterTheNextStart) {
  FakePages flash(8 * fw::SettingsPages::slot_words);
  for (auto& page : flash.contents)
    for (std::size_t i = 0; i < page.size(); ++i)
      page[i] = 0x1234'5678u + static_cast<std::uint32_t>(i);
  std::array<std::uint8_t, 5> bytes{1, 2, 3, 4, 5};
  {
    fw::SettingsPages pages(flash);
    pages.begin();
    EXPECT_TRUE(pages.save(7, bytes));
  }
  fw::SettingsPages pages(flash);
  pages.begin();
  std::array<std::uint8_t, 5> read{};
  EXPECT_EQ(pages.load(7, read), Loaded::good);
  EXPECT_EQ(read, bytes);
  EXPECT_TRUE(pages.save(7, bytes));
}

TEST(SettingsPages, SettingsOfAnotherLayoutAreNotTaken) {
  FakePages flash(4 * fw::SettingsPages::slot_words);
  fw::SettingsPages pages(flash);
  pages.begin();
  ASSERT_TRUE(pages.save(layout, value_of(1)));
  Value value{};
  EXPECT_EQ(pages.load(layout + 1, value), Loaded::other_layout);
  std::array<std::uint8_t, 21> longer{};
  EXPECT_EQ(pages.load(layout, longer), Loaded::other_layout);
}

class SavedSettingsOfTheController : public testing::Test {
 protected:
  std::unique_ptr<Bench> start() {
    boards::native::NativeBoardOptions options;
    options.boot_id = ++starts_;
    options.settings = store_;
    auto bench = std::make_unique<Bench>(world_, options);
    bench->ask(pr::Hello{
        .version = pr::protocol_version, .schema_hash = pr::schema_hash, .host_name = {}});
    return bench;
  }

  SmallWorld world_;
  std::shared_ptr<boards::native::RamSettings> store_ =
      std::make_shared<boards::native::RamSettings>();
  std::uint32_t starts_ = 0;
};

constexpr pr::SetAxis slow_detector{.axis = 1,
                                    .min_udeg = -30'000'000,
                                    .max_udeg = 40'000'000,
                                    .speed_mdeg_s = 5'000,
                                    .acceleration_mdeg_s2 = 100'000,
                                    .jerk_mdeg_s3 = 1'000'000,
                                    .take_up_udeg = 100'000};
constexpr pr::SetLockin low_frequency{
    .reference_mhz = 370'000, .harmonic = 3, .phase_udeg = -5, .settle_ms = 50, .blocks = 8};

TEST_F(SavedSettingsOfTheController, AreInForceAfterARestartOnlyWhenSaved) {
  {
    auto bench = start();
    bench->ask(slow_detector);
    bench->ask(low_frequency);
  }
  EXPECT_EQ(start()->ask(pr::GetAxis{1})->speed_mdeg_s, 40'000u) << "nobody saved it";
  {
    auto bench = start();
    bench->ask(slow_detector);
    bench->ask(low_frequency);
    ASSERT_TRUE(bench->ask(pr::SaveSettings{0}));
  }
  auto bench = start();
  const auto axis = bench->ask(pr::GetAxis{1});
  EXPECT_EQ(axis->min_udeg, -30'000'000);
  EXPECT_EQ(axis->speed_mdeg_s, 5'000u);
  EXPECT_EQ(axis->take_up_udeg, 100'000u);
  const auto lockin = bench->ask(pr::GetLockin{});
  EXPECT_EQ(lockin->reference_mhz, 370'000u);
  EXPECT_EQ(lockin->phase_udeg, -5);
  EXPECT_EQ(bench->ask(pr::GetStatus{})->fault, 0);
  ASSERT_TRUE(bench->ask(pr::SaveSettings{1})) << "back to the built-in ones";
  EXPECT_EQ(bench->ask(pr::GetAxis{1})->speed_mdeg_s, 40'000u);
  EXPECT_EQ(start()->ask(pr::GetAxis{1})->speed_mdeg_s, 40'000u);
}

TEST_F(SavedSettingsOfTheController, ThatCannotBeAreOneFaultAndTheBuiltInOnesHold) {
  auto impossible = fw::settings_to_bytes({});
  store_->save(fw::settings_layout, impossible);
  auto bench = start();
  EXPECT_EQ(bench->ask(pr::GetStatus{})->fault,
            static_cast<std::uint8_t>(pr::Fault::settings_corrupt));
  EXPECT_EQ(bench->ask(pr::GetAxis{0})->speed_mdeg_s, 40'000u);
  ASSERT_TRUE(bench->ask(pr::SaveSettings{0})) << "repairs it";
  ASSERT_TRUE(bench->ask(pr::ClearFault{static_cast<std::uint8_t>(pr::Fault::settings_corrupt)}));
  EXPECT_EQ(start()->ask(pr::GetStatus{})->fault, 0);
}

TEST_F(SavedSettingsOfTheController, AreNotWrittenWhileAxesMove) {
  auto bench = start();
  bench->ask(pr::Home{1});
  EXPECT_FALSE(bench->ask(pr::SaveSettings{0}));
}

TEST_F(SavedSettingsOfTheController, StayInForceWhenSavingTheBuiltInOnesIsRefused) {
  auto bench = start();
  bench->ask(slow_detector);
  bench->ask(low_frequency);
  ASSERT_TRUE(bench->ask(pr::SaveSettings{0}));
  store_->refuses = true;
  EXPECT_FALSE(bench->ask(pr::SaveSettings{1}));
  EXPECT_EQ(bench->ask(pr::GetAxis{1})->speed_mdeg_s, 5'000u);
  EXPECT_EQ(bench->ask(pr::GetLockin{})->reference_mhz, 370'000u);
  store_->refuses = false;
  EXPECT_EQ(start()->ask(pr::GetAxis{1})->speed_mdeg_s, 5'000u);
}

TEST_F(SavedSettingsOfTheController, AreNotWrittenWhileTheSupplyIsLow) {
  auto bench = start();
  bench->ask(slow_detector);
  world_.low_supply = true;
  EXPECT_FALSE(bench->ask(pr::SaveSettings{0}));
  EXPECT_FALSE(bench->ask(pr::SaveSettings{1}));
  EXPECT_EQ(bench->ask(pr::GetAxis{1})->speed_mdeg_s, 5'000u);
  world_.low_supply = false;
  EXPECT_EQ(start()->ask(pr::GetAxis{1})->speed_mdeg_s, 40'000u) << "nothing was saved";
}

}  // namespace
}  // namespace umov
