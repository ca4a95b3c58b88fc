// Blocks with a changed set-up, run on the embedded emulator: the change acts on their rows and on
// no others, and an interrupted scan finds its set-up again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "host/cli/emulator/emulated_instrument.hpp"
#include "host/errors/error.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/scan/runner.hpp"
#include "host/scan/scan_part.hpp"

namespace umov {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string plan_text =
    "sample = \"black gloss\"\nwavelengths_nm = [532, 633]\ntheta_i_deg = [30]\n"
    "theta_r_deg = [-20, 20, 26, 30, 34]\nstates = [[\"open\", \"open\"]]\ndwell_ms = 10\n"
    "settle_ms = 2\n";

const std::string all_blocks =
    "[[block]]\nmenu = \"flip\"\n[[block]]\nmenu = \"repeat\"\nrepeats = 1\n"
    "[[block]]\nmenu = \"iris\"\n[[block]]\nmenu = \"long_pass\"\ntheta_r_deg = [-20, 30]\n"
    "[[block]]\nmenu = \"no_sample\"\ntheta_r_deg = [-20, 30]\n"
    "[[block]]\nmenu = \"white_tile\"\ntheta_r_deg = [-20, 20]\n"
    "reference_dhr = { 532 = 0.99, 633 = 0.99 }\n";

class SetUpBlocks : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("umov-set-up-" + std::to_string(getpid()) + "-" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// A bench that lives on from part to part; its sample leans, so that turning it shows.
  void start_bench() {
    emulator::BenchOptions bench;
    bench.sample = "black-gloss";
    bench.settings = {"mount.tilt_in_plane_deg=1"};
    bench.seed = 4;
    bench_ = std::make_shared<emulator::EmulatedInstrument>(bench);
  }

  scan::RunOptions options(const scan::ScanPart& part) {
    scan::RunOptions run;
    run.output = folder_ / part.output;
    run.standing = part.standing;
    run.connect = [this] { return emulator::connect_embedded(bench_); };
    run.arrange = [this](const scan::ArrangementRequest& request) {
      asked_.push_back(request.wanted.text() + (request.present ? "" : " (unsure)"));
      bench_->arrange(request.wanted.settings);
      return true;
    };
    return run;
  }

  formats::ScanTable table(const std::string& file) {
    return formats::read_scan_h5((folder_ / file).string()).table;
  }

  /// Signal over monitor at an angle and wavelength in a block.
  static double ratio(const formats::ScanTable& scan, const std::string& block, double theta_r_deg,
                      double wavelength_nm) {
    for (const auto& b : scan.blocks) {
      if (b.name != block) continue;
      for (std::size_t i = 0; i < scan.size(); ++i)
        if (scan.index[i] >= b.first && scan.index[i] <= b.last &&
            scan.theta_r_deg[i] == theta_r_deg && scan.wavelength_nm[i] == wavelength_nm)
          return scan.x_v[i] / scan.monitor_v[i];
    }
    ADD_FAILURE() << "no such row in " << block;
    return NAN;
  }

  std::filesystem::path folder_;
  std::shared_ptr<emulator::EmulatedInstrument> bench_;
  std::vector<std::string> asked_;
};

TEST_F(SetUpBlocks, EachChangeActsOnItsRowsAndIsUndone) {
  start_bench();
  for (const auto& part :
       scan::scan_parts(scan::parse_plan(plan_text + all_blocks, "p"), "scan.h5"))
    EXPECT_TRUE(scan::run_scan(part.plan, options(part)).complete);
  EXPECT_THAT(asked_, ElementsAre("sample_azimuth_deg=180", "plain", "iris_fraction=0.5",
                                  "filter=long_pass", "sample_removed=1", "plain",
                                  "sample=white-99", "plain"));
  const auto scan = table("scan.h5");
  // Leaning by 1 deg: the mirror direction of 30 deg is 32 deg, and 28 deg once turned.
  EXPECT_GT(ratio(scan, "main", 34, 532), 1.5 * ratio(scan, "main", 26, 532));
  EXPECT_GT(ratio(scan, "flip", 26, 532), 1.5 * ratio(scan, "flip", 34, 532));
  EXPECT_NEAR(ratio(scan, "repeat", 20, 532) / ratio(scan, "main", 20, 532), 1, 0.01)
      << "turned back before the next block";
  EXPECT_NEAR(ratio(scan, "iris", 30, 532) / ratio(scan, "main", 30, 532), 0.25, 0.01);
  EXPECT_NEAR(ratio(scan, "long_pass", 30, 532) / ratio(scan, "main", 30, 532), 0, 0.01);
  EXPECT_NEAR(ratio(scan, "long_pass", 30, 633) / ratio(scan, "main", 30, 633), 1, 0.01);
  EXPECT_NEAR(ratio(scan, "no_sample", 30, 633) / ratio(scan, "main", 30, 633), 0, 0.01);
  const auto white = table("scan-white.h5");
  EXPECT_GT(ratio(white, "main", -20, 532), 20 * ratio(scan, "main", -20, 532));
  EXPECT_EQ(white.key("role"), "white");
  EXPECT_EQ(scan.key("reference"), "scan-white.h5");
  EXPECT_EQ(scan.key("device"), white.key("device"));
}

TEST_F(SetUpBlocks, InterruptedAnywhereEveryRecordIsThereOnceAndInItsSetUp) {
  const auto plan = scan::parse_plan(plan_text + all_blocks, "p");
  const auto part = scan::scan_parts(plan, "scan.h5").front();
  start_bench();
  ASSERT_TRUE(scan::run_scan(part.plan, options(part)).complete);
  std::filesystem::rename(folder_ / "scan.h5", folder_ / "whole.h5");
  const auto whole = table("whole.h5");

  // As after kill -9: a new bench each time, with the sample as it lies in its box.
  int begun = 0;
  std::uint32_t done = 0;
  for (bool complete = false; !complete; ++begun) {
    ASSERT_LT(begun, 40);
    start_bench();
    auto run = options(part);
    run.resume = begun > 0;
    std::uint32_t here = 0;
    run.progress = [&](const scan::RunProgress& now) { here = now.done; };
    run.keep_going = [&] { return here < done + 4; };
    const auto summary = scan::run_scan(part.plan, run);
    complete = summary.complete;
    ASSERT_GT(summary.records, done);
    done = summary.records;
  }
  EXPECT_GT(begun, 4);
  const auto pieced = table("scan.h5");
  ASSERT_EQ(pieced.index, whole.index);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const double expected = whole.x_v[i] / whole.monitor_v[i];
    EXPECT_NEAR(pieced.x_v[i] / pieced.monitor_v[i], expected, 0.02 * std::abs(expected) + 2e-6)
        << "record " << i;
  }
  EXPECT_THAT(asked_, testing::Contains(HasSubstr("(unsure)")));
}

TEST_F(SetUpBlocks, CalledOffAtTheQuestionTheScanCanBeResumed) {
  const auto plan = scan::parse_plan(plan_text + "[[block]]\nmenu = \"flip\"\n", "p");
  const auto part = scan::scan_parts(plan, "scan.h5").front();
  start_bench();
  auto run = options(part);
  run.arrange = [](const scan::ArrangementRequest&) { return false; };
  const auto summary = scan::run_scan(part.plan, run);
  EXPECT_FALSE(summary.complete);
  EXPECT_EQ(summary.records, 10u) << "the main block is there";
  run = options(part);
  run.resume = true;
  EXPECT_TRUE(scan::run_scan(part.plan, run).complete);
  EXPECT_THAT(asked_, ElementsAre("sample_azimuth_deg=180 (unsure)", "plain"));
}

TEST_F(SetUpBlocks, WithNobodyToArrangeNothingIsMeasured) {
  const auto plan = scan::parse_plan(plan_text + "[[block]]\nmenu = \"iris\"\n", "p");
  const auto part = scan::scan_parts(plan, "scan.h5").front();
  start_bench();
  auto run = options(part);
  run.arrange = {};
  EXPECT_THROW(scan::run_scan(part.plan, run), Error);
  EXPECT_FALSE(std::filesystem::exists(run.output));
  EXPECT_FALSE(std::filesystem::exists(scan::journal_path(run.output)));
}

TEST(EmulatedInstrument, RefusesToBeArrangedInWaysItDoesNotKnow) {
  emulator::BenchOptions options;
  options.sample = "white-99";
  emulator::EmulatedInstrument bench(options);
  for (const auto& [key, value] :
       std::vector<std::pair<std::string, std::string>>{{"filter", "blue"},
                                                        {"iris_fraction", "2"},
                                                        {"iris_fraction", "x"},
                                                        {"colour", "1"},
                                                        {"sample", "no-such-sample"}})
    EXPECT_THROW(bench.arrange({{key, value}}), Error) << key << "=" << value;
}

}  // namespace
}  // namespace umov
