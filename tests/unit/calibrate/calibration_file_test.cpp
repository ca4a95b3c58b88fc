#include "host/calibrate/calibration_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "host/calibrate/reduce.hpp"
#include "host/calibrate/reference_file.hpp"
#include "host/calibrate/standard_file.hpp"
#include "host/errors/error.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/formats/scan_h5.hpp"
#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

using namespace test;

class CalibrationFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        std::filesystem::temp_directory_path() / (std::string("umov_calibrate_") + test->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  std::string problem_of(const std::string& name) const {
    try {
      read_reference_table(folder_ / name);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

Calibration rich_calibration() {
  Instrument instrument;
  instrument.bias = 0.05;
  instrument.instrument_function = [](double t) { return 1 + 0.1 * std::pow(t / 85, 4); };
  Plan plan;
  plan.wavelengths = {532, 633};
  plan.step = 2;
  plan.states = {{0, 0}, {0, 90}, {0, open_axis}, {90, 90}, {90, 0}};
  auto white = make_white(instrument, 0.99, plan, 4, 0.005);
  add_closed(white, instrument, {100}, 10, 4);
  white.set_key("device", "bench");
  const StandardScan standard{white, ReferenceStandard::from_keys(white), "SRS-99", "abc"};
  return calibrate(std::span(&standard, 1));
}

TEST_F(CalibrationFile, ReducesExactlyAsTheCalibrationThatWasWritten) {
  const Calibration before = rich_calibration();
  ASSERT_TRUE(before.wavelengths[0].bias_active);
  write_calibration(folder_ / "cal.h5", before, {});
  const Calibration after = read_calibration(folder_ / "cal.h5");
  Plan plan;
  plan.wavelengths = {532, 633};
  plan.states = {{0, 0}, {0, 90}, {0, open_axis}};
  const auto scan = make_scan(Instrument{}, lambertian(0.3), plan, 9);
  const auto a = reduce(scan, before).table, b = reduce(scan, after).table;
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i)
    EXPECT_NEAR(a.points.brdf_per_sr[i] / b.points.brdf_per_sr[i], 1, 1e-12);
  EXPECT_EQ(before.ranges.covariance, after.ranges.covariance);
  EXPECT_GT(after.ranges.covariance.rows(), 0);
  EXPECT_EQ(before.wavelengths[0].gain_bias_lever, after.wavelengths[0].gain_bias_lever);
  ASSERT_EQ(a.factors.size(), b.factors.size());
  for (std::size_t k = 0; k < a.factors.size(); ++k) {
    EXPECT_EQ(a.factors[k].name, b.factors[k].name);
    for (std::size_t i = 0; i < a.points.size(); ++i)
      EXPECT_NEAR(a.factors[k].per_point[i], b.factors[k].per_point[i], 1e-12);
  }
  EXPECT_EQ(after.inputs.at(0).sha256, "abc");
  EXPECT_EQ(after.checks.size(), before.checks.size());
  EXPECT_EQ(after.notes, before.notes);
  EXPECT_EQ(after.keys, before.keys);
}

TEST_F(CalibrationFile, DamagedTruncatedAndForeignFilesAreRefused) {
  write_calibration(folder_ / "cal.h5", rich_calibration(), {});
  std::ifstream in(folder_ / "cal.h5", std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  std::string damaged = bytes;
  damaged[damaged.size() / 2] ^= 1;
  write("damaged.h5", damaged);
  write("short.h5", bytes.substr(0, bytes.size() - 100));
  write("text.h5", "gain = 600\n");
  for (const char* name : {"damaged.h5", "short.h5", "text.h5", "absent.h5"})
    EXPECT_THROW(read_calibration(folder_ / name), Error) << name;
  const auto table =
      reduce(make_scan(Instrument{}, lambertian(0.3), Plan{}, 9), rich_calibration()).table;
  formats::write_brdf_h5(folder_ / "brdf.h5", table, {});
  EXPECT_THROW(read_calibration(folder_ / "brdf.h5"), Error);
}

TEST_F(CalibrationFile, StandardsAreReadWithTheirKeysOrTheirTable) {
  Plan plan;
  auto white = make_white(Instrument{}, 0.99, plan, 1, 0.004);
  white.set_key("format", "umov scan csv");
  formats::write_scan_csv(white, folder_ / "white.csv");
  const StandardScan by_keys = read_standard(folder_ / "white.csv");
  EXPECT_EQ(by_keys.name, "synthetic");
  EXPECT_EQ(by_keys.sha256.size(), 64U);
  EXPECT_FALSE(by_keys.reference.tabulated());

  write(
      "tile.csv",
      "# a tile\ntheta_i_deg,theta_r_deg,wavelength_nm,brdf_per_sr\n0,-85,500,0.30\n0,0,500,0.33\n"
      "0,85,500,0.30\n0,-85,600,0.30\n0,0,600,0.33\n0,85,600,0.30\n");
  white.set_key("reference_brdf", "tile.csv");
  formats::write_scan_csv(white, folder_ / "white.csv");
  const StandardScan by_table = read_standard(folder_ / "white.csv");
  EXPECT_TRUE(by_table.reference.tabulated());
  EXPECT_NEAR(*by_table.reference.brdf(0, 42.5, 0, 532, open_axis, open_axis), 0.315, 1e-12);

  white.set_key("role", "sample");
  formats::write_scan_csv(white, folder_ / "white.csv");
  EXPECT_THROW(read_standard(folder_ / "white.csv"), Error);
}

TEST_F(CalibrationFile, BadReferenceTablesAreRefusedWithTheirPlace) {
  write("column.csv", "theta_i_deg,theta_r_deg,brdf_per_sr\n0,0,0.3\n");
  EXPECT_NE(problem_of("column.csv").find("wavelength_nm"), std::string::npos);
  write("number.csv",
        "theta_i_deg,theta_r_deg,wavelength_nm,brdf_per_sr\n0,0,532,0.3\n0,x,532,0.3\n");
  EXPECT_NE(problem_of("number.csv").find("number.csv:3:theta_r_deg"), std::string::npos);
  write("nan.csv", "theta_i_deg,theta_r_deg,wavelength_nm,brdf_per_sr\n0,0,532,nan\n");
  EXPECT_NE(problem_of("nan.csv").find(":2:"), std::string::npos);
  write("short.csv", "theta_i_deg,theta_r_deg,wavelength_nm,brdf_per_sr\n0,0,532\n");
  EXPECT_FALSE(problem_of("short.csv").empty());
  write("empty.csv", "theta_i_deg,theta_r_deg,wavelength_nm,brdf_per_sr\n");
  EXPECT_FALSE(problem_of("empty.csv").empty());
  EXPECT_FALSE(problem_of("absent.csv").empty());
}

}  // namespace
}  // namespace umov::calibrate
