// Which file is what, and which fit belongs to which measurement.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/calibrate/calibration.hpp"
#include "host/errors/error.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/report/inputs.hpp"
#include "host/report/report.hpp"
#include "tests/unit/report/synthetic.hpp"

namespace umov::report {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class Files : public ::testing::Test {
 protected:
  Files() {
    folder_ = fs::temp_directory_path() /
              ("umov-report-" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~Files() override { fs::remove_all(folder_); }
  fs::path path(const std::string& name) const { return folder_ / name; }
  fs::path text(const std::string& name, const std::string& content) const {
    std::ofstream(path(name), std::ios::binary) << content;
    return path(name);
  }
  std::string message(const fs::path& file) const {
    try {
      read_input(file);
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  }

 private:
  fs::path folder_;
};

TEST_F(Files, are_known_by_content_and_not_by_name) {
  const Sample sample = synthetic::red_gloss();
  formats::write_brdf_h5(path("a.dat"), sample.brdf->file.table, sample.brdf->file.provenance);
  formats::write_fit(path("b.dat").string(), sample.fit->fit);
  formats::write_scan_h5(path("c.dat"), synthetic::raw_scan().file.table, {});
  EXPECT_TRUE(std::holds_alternative<BrdfInput>(read_input(path("a.dat"))));
  EXPECT_TRUE(std::holds_alternative<FitInput>(read_input(path("b.dat"))));
  EXPECT_TRUE(std::holds_alternative<ScanInput>(read_input(path("c.dat"))));
}

TEST_F(Files, of_another_kind_are_refused_with_their_name) {
  EXPECT_THAT(message(text("notes.txt", "hello")), HasSubstr("notes.txt"));
  EXPECT_THAT(message(text("empty.h5", "")), HasSubstr("empty.h5"));
  EXPECT_THAT(message(text("x.json", "{\"model\": 3}")), HasSubstr("x.json"));
  EXPECT_THAT(message(text("cut.h5", std::string("\x89HDF\r\n\x1a\n", 8) + "rest")),
              HasSubstr("cut.h5"));
  EXPECT_THAT(message(path("missing.h5")), HasSubstr("missing.h5"));
}

TEST_F(Files, a_report_is_written_from_files_in_any_order) {
  const Sample gloss = synthetic::red_gloss(), standard = synthetic::diffuse_standard();
  formats::write_brdf_h5(path("gloss.h5"), gloss.brdf->file.table, {});
  formats::write_brdf_h5(path("standard.h5"), standard.brdf->file.table, {});
  const auto refit = [](const Sample& sample) {
    formats::FitResult fit = sample.fit->fit;
    fit.data_sha256 = formats::content_sha256(sample.brdf->file.table);
    return fit;
  };
  formats::write_fit(path("gloss.json").string(), refit(gloss));
  formats::write_fit(path("standard.json").string(), refit(standard));
  const std::vector<fs::path> files{path("standard.json"), path("gloss.json"), path("gloss.h5"),
                                    path("standard.h5")};
  const Summary summary = write_report(files, path("report.html"), {});
  EXPECT_EQ(summary.samples, 2u);
  EXPECT_EQ(summary.bytes, fs::file_size(path("report.html")));
  EXPECT_THAT(summary.warnings, ::testing::IsEmpty());
}

TEST_F(Files, a_report_that_fails_leaves_the_old_page) {
  text("report.html", "old");
  const std::vector<fs::path> files{text("bad.h5", "nonsense")};
  EXPECT_THROW(write_report(files, path("report.html"), {}), Error);
  std::string kept;
  std::ifstream(path("report.html")) >> kept;
  EXPECT_EQ(kept, "old");
}

TEST(Group, a_fit_goes_to_the_measurement_whose_digest_it_names_whatever_the_order) {
  const Sample gloss = synthetic::red_gloss(), standard = synthetic::diffuse_standard();
  const auto samples = group({*standard.fit, *gloss.brdf, *standard.brdf, *gloss.fit});
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].name, "red gloss");
  EXPECT_EQ(samples[0].fit->fit.model, "li-torrance");
  EXPECT_EQ(samples[1].fit->fit.model, "nef");
  EXPECT_TRUE(samples[0].warnings.empty());
}

TEST(Group, the_digest_of_the_file_serves_as_well) {
  Sample gloss = synthetic::red_gloss();
  const Sample standard = synthetic::diffuse_standard();
  gloss.fit->fit.data_sha256 = gloss.brdf->source.sha256;
  const auto samples = group({*gloss.brdf, *standard.brdf, *gloss.fit});
  EXPECT_TRUE(samples[0].fit.has_value());
  EXPECT_FALSE(samples[1].fit.has_value());
  EXPECT_TRUE(samples[0].warnings.empty());
}

TEST(Group, a_fit_of_unknown_data_goes_to_the_measurement_before_it_with_a_warning) {
  Sample gloss = synthetic::red_gloss();
  const Sample standard = synthetic::diffuse_standard();
  gloss.fit->fit.data_sha256 = std::string(64, '0');
  gloss.fit->fit.data_file = "elsewhere.h5";
  const auto samples = group({*gloss.brdf, *gloss.fit, *standard.brdf});
  ASSERT_TRUE(samples[0].fit.has_value());
  ASSERT_EQ(samples[0].warnings.size(), 1u);
  EXPECT_THAT(samples[0].warnings[0], HasSubstr("other data"));
}

TEST(Group, two_fits_of_one_measurement_make_two_sections_with_names_that_tell_them_apart) {
  const Sample gloss = synthetic::red_gloss();
  FitInput second = *gloss.fit;
  second.fit.model = "he-torrance";
  const auto samples =
      group({*gloss.brdf, *gloss.fit, second, *synthetic::diffuse_standard().brdf});
  ASSERT_EQ(samples.size(), 3u);
  EXPECT_EQ(samples[0].name, "red gloss (li-torrance)");
  EXPECT_EQ(samples[1].name, "red gloss (he-torrance)");
  EXPECT_TRUE(samples[1].brdf.has_value());
  EXPECT_EQ(samples[2].name, "diffuse standard");
}

TEST(Group, a_fit_alone_says_that_its_measurement_is_missing) {
  const auto samples = group({*synthetic::red_gloss().fit});
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_THAT(samples[0].warnings.at(0), HasSubstr("not given"));
}

TEST(Group, scans_and_calibrations_join_the_measurement_they_belong_to) {
  Sample gloss = synthetic::red_gloss();
  const Sample standard = synthetic::diffuse_standard();
  gloss.brdf->file.table.keys.emplace_back("calibration", "results/cal.h5");
  ScanInput white = synthetic::raw_scan();
  white.file.table.set_key("sample", "white tile");
  white.source.name = "white.h5";
  const auto samples =
      group({synthetic::calibration(), synthetic::raw_scan(), white, *gloss.brdf, *standard.brdf});
  ASSERT_EQ(samples.size(), 3u);
  EXPECT_EQ(samples[0].scans.size(), 1u);
  EXPECT_TRUE(samples[0].calibration.has_value());
  EXPECT_FALSE(samples[1].calibration.has_value());
  EXPECT_EQ(samples[2].name, "white tile");
}

}  // namespace
}  // namespace umov::report
