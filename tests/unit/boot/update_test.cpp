// Updates by DFU from end to end: taken, refused, uploaded, and cut anywhere.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/boot/start.hpp"
#include "host/instrument/firmware_image.hpp"
#include "protocol/dfu.hpp"
#include "tests/unit/boot/dfu_bench.hpp"

namespace umov {
namespace {

using boot_place = firmware::boot::Place;
using instrument::UpdateRefused;
using test::Bytes;
using test::DfuBench;
using test::Keys;
using test::make_image;
using test::RamFlash;
using testing::HasSubstr;
namespace dfu = protocol::dfu;

constexpr std::size_t place_bytes = 32 * 1024;
constexpr std::uint32_t program_bytes = 20'004;
constexpr std::uint32_t v1 = protocol::image_version(1, 0, 0),
                        v2 = protocol::image_version(1, 2, 3);

class Update : public testing::Test {
 protected:
  void SetUp() override { flash_.put(boot_place::running, old_); }
  /// What a start makes of it: whether there is a program to run.
  bool starts(RamFlash& flash) const {
    using namespace firmware::boot;
    return make_runnable(flash, trust_, Restart::power).start == Start::program;
  }
  std::string refusal_of(const Bytes& image, std::uint8_t setting = dfu::setting_newer) {
    DfuBench bench(flash_, trust_);
    bench.control(0x01, 11, setting, 0, {});  // SET_INTERFACE
    try {
      instrument::dfu_download(bench, image);
    } catch (const UpdateRefused& refused) {
      EXPECT_TRUE(flash_.holds(boot_place::running, old_)) << "what runs is untouched";
      EXPECT_TRUE(starts(flash_));
      EXPECT_TRUE(flash_.holds(boot_place::running, old_));
      return refused.what();
    }
    return "taken";
  }

  const Keys keys_{1};
  const firmware::boot::Trust trust_{test::board_name, keys_.key};
  const Bytes old_ = make_image(v1, program_bytes, keys_);
  const Bytes new_ = make_image(v2, program_bytes + 3'000, keys_);
  RamFlash flash_{place_bytes};
};

TEST_F(Update, IsInstalledAndTheOldImageKept) {
  DfuBench bench(flash_, trust_);
  std::size_t sent = 0, polls = 0;
  instrument::dfu_download(bench, new_, [&](auto phase, std::size_t done, std::size_t) {
    (phase == instrument::UpdatePhase::sending ? sent : polls) = done;
  });
  EXPECT_EQ(sent, new_.size());
  EXPECT_GT(polls, 0u) << "status is polled to the end";
  EXPECT_TRUE(flash_.holds(boot_place::running, new_));
  EXPECT_TRUE(flash_.holds(boot_place::previous, old_));
  EXPECT_FALSE(bench.device.leaving());
  EXPECT_EQ(instrument::dfu_upload(bench), new_);
  instrument::dfu_leave(bench);
  EXPECT_TRUE(bench.device.leaving());
  const auto written = flash_.written;
  EXPECT_TRUE(starts(flash_));
  EXPECT_EQ(flash_.written, written) << "nothing is left to be done";
}

TEST_F(Update, GoesIntoAnEmptyControllerAndOverTheSameImage) {
  RamFlash empty(place_bytes);
  EXPECT_FALSE(starts(empty));
  {
    DfuBench bench(empty, trust_);
    EXPECT_TRUE(instrument::dfu_upload(bench).empty());
    instrument::dfu_download(bench, new_);
    instrument::dfu_download(bench, new_);
  }
  EXPECT_TRUE(starts(empty));
  EXPECT_TRUE(empty.holds(boot_place::running, new_));
}

TEST_F(Update, OfAnotherBoardIsRefused) {
  EXPECT_THAT(refusal_of(make_image(v2, program_bytes, keys_, "some other board")),
              HasSubstr("another board"));
}

TEST_F(Update, OfAnOlderVersionIsRefusedUnlessForced) {
  const Bytes older = make_image(v1 - 1, program_bytes, keys_);
  EXPECT_THAT(refusal_of(older), HasSubstr("older"));
  EXPECT_EQ(refusal_of(older, dfu::setting_older_too), "taken");
  EXPECT_TRUE(flash_.holds(boot_place::running, older));
}

TEST_F(Update, SignedWithAnotherKeyOrChangedAfterwardsIsRefused) {
  EXPECT_THAT(refusal_of(make_image(v2, program_bytes, Keys(2))), HasSubstr("not signed"));
  Bytes changed = new_;
  changed[3'000] ^= 1;
  EXPECT_THAT(refusal_of(changed), HasSubstr("damaged"));
  // With a CRC that fits the change, too.
  protocol::ImageHeader header;
  ASSERT_TRUE(protocol::read_image_header(changed, header));
  header.program_crc = protocol::crc32c(
      std::span<const std::uint8_t>(changed).subspan(protocol::ImageHeader::bytes));
  protocol::write_image_header(header, changed);
  EXPECT_THAT(refusal_of(changed), HasSubstr("not signed"));
  // A version made younger than the signed one.
  Bytes younger = old_;
  ASSERT_TRUE(protocol::read_image_header(younger, header));
  header.version = v2;
  protocol::write_image_header(header, younger);
  EXPECT_THAT(refusal_of(younger), HasSubstr("not signed"));
}

TEST_F(Update, ThatIsNoImageOrNotAllOfOneIsRefused) {
  EXPECT_THAT(refusal_of(Bytes(5'000, 0x55)), HasSubstr("no image"));
  EXPECT_THAT(refusal_of(Bytes(new_.begin(), new_.begin() + 9'000)), HasSubstr("not all of it"));
  Bytes longer = new_;
  longer.resize(longer.size() + 4, 0);
  EXPECT_THAT(refusal_of(longer), HasSubstr("no image"));
  EXPECT_THAT(refusal_of(make_image(v2, place_bytes, keys_)), HasSubstr("no image")) << "too long";
}

TEST_F(Update, WithAFlashThatFailsIsToldAndTheOldImageRuns) {
  flash_.fails_at = 6'000;
  EXPECT_THAT(refusal_of(new_), HasSubstr("flash memory fails"));
}

TEST_F(Update, RequestsOutOfTurnAreStalledAndTheNextUpdateWorks) {
  DfuBench bench(flash_, trust_);
  EXPECT_FALSE(bench.write(dfu::download, 0, {})) << "an end without a beginning";
  EXPECT_FALSE(bench.write(dfu::abort, 0, {})) << "an error must be cleared";
  EXPECT_TRUE(bench.write(dfu::clear_status, 0, {}));
  EXPECT_TRUE(bench.write(dfu::download, 0, std::span(new_).first(1024)));
  EXPECT_FALSE(bench.write(dfu::download, 1, std::span(new_).subspan(1024, 1024)))
      << "before the status was asked for";
  EXPECT_FALSE(bench.write(77, 0, {}));
  EXPECT_FALSE(bench.read(dfu::upload, 0, 1024).good);
  instrument::dfu_download(bench, new_);
  EXPECT_TRUE(flash_.holds(boot_place::running, new_));
}

TEST_F(Update, ThatFailsLeavesTheBootLoaderSoThatTheProgramRunsAgain) {
  {
    DfuBench bench(flash_, trust_);
    EXPECT_THROW(instrument::dfu_work_and_leave(
                     bench, [&] { instrument::dfu_download(bench, Bytes(5'000, 0x55)); }),
                 UpdateRefused);
    EXPECT_TRUE(bench.device.leaving()) << "refused";
  }
  {
    DfuBench bench(flash_, trust_);
    EXPECT_THROW(instrument::dfu_work_and_leave(bench,
                                                [&] {
                                                  bench.write(dfu::download, 0,
                                                              std::span(new_).first(1024));
                                                  throw std::runtime_error("disk full");
                                                }),
                 std::runtime_error);
    EXPECT_TRUE(bench.device.leaving()) << "in the middle of a download";
  }
  DfuBench bench(flash_, trust_);
  instrument::dfu_work_and_leave(bench, [&] { instrument::dfu_download(bench, new_); });
  EXPECT_TRUE(bench.device.leaving());
  EXPECT_TRUE(flash_.holds(boot_place::running, new_));
}

TEST_F(Update, NoRequestStopsWhatIsBeingWrittenOrInstalled) {
  const auto told_to = [](std::uint8_t request, Bytes bytes = {}) {
    return [=](DfuBench& bench) { return bench.write(request, 0, bytes); };
  };
  const auto asked_for = [](std::uint8_t request) {
    return [=](DfuBench& bench) { return bench.read(request, 0, 64).good; };
  };
  const std::vector<std::pair<const char*, std::function<bool(DfuBench&)>>> requests = {
      {"abort", told_to(dfu::abort)},
      {"detach", told_to(dfu::detach)},
      {"clear status", told_to(dfu::clear_status)},
      {"a block", told_to(dfu::download, Bytes(64, 1))},
      {"a block too long", told_to(dfu::download, Bytes(4'096, 1))},
      {"the end", told_to(dfu::download)},
      {"upload", asked_for(dfu::upload)},
      {"a request that there is none of", told_to(77)},
      {"a question that there is none of", asked_for(77)},
      {"abort with data", told_to(dfu::abort, Bytes(4, 0))},
  };
  for (const auto& [name, request] : requests) {
    RamFlash flash = flash_;
    DfuBench bench(flash, trust_);
    int pieces = 0;
    bench.between_pieces = [&, &act = request] {
      ++pieces;
      EXPECT_FALSE(act(bench));
    };
    ASSERT_NO_THROW(instrument::dfu_download(bench, new_)) << name;
    EXPECT_TRUE(flash.holds(boot_place::running, new_)) << name;
    EXPECT_TRUE(flash.holds(boot_place::previous, old_)) << name;
    EXPECT_GT(pieces, 2 * 24 + 20) << "blocks stored, pieces copied twice";
    EXPECT_FALSE(bench.device.leaving()) << name;
  }
}

TEST_F(Update, AResetOnTheBusEndsDfuModeOnceTheDeviceWasInUse) {
  DfuBench bench(flash_, trust_);
  EXPECT_FALSE(bench.device.leaving()) << "a host resets the device that it meets";
  bench.port.bus_reset();
  EXPECT_TRUE(bench.device.leaving());
}

// The power is cut after every 256th byte of the whole update (erasures included, which are cut
// half-way); the controller then starts with the old image or the new one, whole, and an update
// after that works. Nothing of this may fail to end in a program that runs.
TEST_F(Update, CutAtEvery256thByteLeavesTheOldOrTheNewImageRunning) {
  RamFlash whole = flash_;
  {
    DfuBench bench(whole, trust_);
    instrument::dfu_download(bench, new_);
  }
  const std::size_t total = whole.written;
  ASSERT_GT(total, 3 * old_.size());
  int olds = 0, news = 0;
  for (std::size_t cut = 0; cut < total; cut += 256) {
    RamFlash flash = flash_;
    flash.bytes_left = cut;
    EXPECT_THROW(
        {
          DfuBench bench(flash, trust_);
          instrument::dfu_download(bench, new_);
        },
        test::PowerCut);
    flash.bytes_left.reset();
    ASSERT_TRUE(starts(flash)) << "cut at " << cut;
    const bool is_new = flash.holds(boot_place::running, new_);
    ASSERT_TRUE(is_new || flash.holds(boot_place::running, old_)) << "cut at " << cut;
    EXPECT_EQ(firmware::boot::Trial(flash).open(), is_new)
        << "a new one is on trial, cut at " << cut;
    (is_new ? news : olds) += 1;
  }
  EXPECT_GT(olds, 80);
  EXPECT_GT(news, 160);
}

// And the start that ends such an update may be cut, again and again.
TEST_F(Update, CutOverAndOverWhileItIsEndedStillEnds) {
  RamFlash flash = flash_;
  flash.bytes_left = new_.size() + 2 * RamFlash::erase_cost + 3'000;  // while the old one is kept
  EXPECT_THROW(
      {
        DfuBench bench(flash, trust_);
        instrument::dfu_download(bench, new_);
      },
      test::PowerCut);
  for (std::size_t left = 100; left < 60'000; left += 977) {
    flash.bytes_left = left;
    try {
      EXPECT_TRUE(starts(flash));
    } catch (const test::PowerCut&) {
    }
  }
  flash.bytes_left.reset();
  ASSERT_TRUE(starts(flash));
  EXPECT_TRUE(flash.holds(boot_place::running, new_));
  EXPECT_TRUE(flash.holds(boot_place::previous, old_));
}

TEST_F(Update, ThePreviousImageIsPutBackWhereTheRunningOneIsDamaged) {
  {
    DfuBench bench(flash_, trust_);
    instrument::dfu_download(bench, new_);
  }
  for (const std::size_t where : {0u, 70u, 600u, 20'000u}) {
    flash_.put(boot_place::running, new_);
    flash_.at(boot_place::running)[where] ^= 2;
    ASSERT_TRUE(starts(flash_)) << where;
    EXPECT_TRUE(flash_.holds(boot_place::running, old_));
  }
  flash_.at(boot_place::running)[600] ^= 2;
  flash_.at(boot_place::previous)[600] ^= 2;
  EXPECT_FALSE(starts(flash_)) << "DFU mode is left";
}

}  // namespace
}  // namespace umov
