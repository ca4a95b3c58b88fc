#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <sstream>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/foreign_kind.hpp"
#include "host/formats/scan_csv.hpp"
#include "tests/unit/formats/scratch_folder.hpp"
#include "tests/unit/optional_data.hpp"

namespace umov::formats {
namespace {

using ::testing::HasSubstr;
using testing::ScratchFolder;

const std::string columns =
    "index,time_s,theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,polarizer_deg,analyzer_deg,"
    "direction,gain,x_v,y_v,x_se_v,y_se_v,monitor_v,saturated,shutter\n";

const std::string small =
    "# format: umov scan csv\n"
    "# sample: coupon\n"
    "# solid_angle_sr: 1e-4\n"
    "# colour of the lid: blue: light\n"
    "# block: main 0-1\n"
    "# block: flip 2-2 sample_azimuth_deg=180 note=x\n" +
    columns +
    "0,0.450,30,-80,0,532,0,open,1,100,0.0021820908,-6.2942505e-06,5.958e-06,5.09e-06,1.080726,0,"
    "open\n"
    "1,1.000,30,12.5,0,532,90,0,-1,10,0.1,0,1e-05,1e-05,1,1,closed\n"
    "2,1.550,30,40,150,532,-45,45,1,1,1.5,-0,0,0,0.9,0,open\n";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

Error error_of(const std::string& text) {
  try {
    parse_scan_csv(text, "scan.csv");
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "accepted:\n" << text;
  return Error("nothing thrown", "");
}

TEST(ScanCsv, CanonicalFileComesBackByteByByte) {
  EXPECT_EQ(scan_csv_text(parse_scan_csv(small, "small")), small);
  const std::string part =
      read_whole_file(std::string(UMOV_TEST_DATA) + "/foreign_scans/scan_07_part.csv");
  EXPECT_EQ(scan_csv_text(parse_scan_csv(part, "part")), part);
}

TEST(ScanCsv, TenScansOfAnotherProgramComeBackByteByByte) {
  const auto folder = umov::testing::optional_data("foreign_scans");
  if (!folder) GTEST_SKIP() << "no foreign_scans/: name their folder in UMOV_DATA";
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(*folder)) {
    if (entry.path().extension() != ".csv") continue;
    const std::string text = read_whole_file(entry.path());
    EXPECT_TRUE(scan_csv_text(read_scan_csv(entry.path())) == text) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 10);
}

TEST(ScanCsv, ColumnsKeysAndBlocksAreRead) {
  const ScanTable table = parse_scan_csv(small, "small");
  ASSERT_EQ(table.size(), 3u);
  EXPECT_EQ(table.key("colour of the lid"), "blue: light");
  EXPECT_EQ(table.number("solid_angle_sr"), 1e-4);
  EXPECT_EQ(table.number("adc_step_v"), std::nullopt);
  ASSERT_EQ(table.blocks.size(), 2u);
  EXPECT_EQ(table.blocks[1].name, "flip");
  EXPECT_EQ(table.blocks[1].first, 2);
  EXPECT_EQ(table.blocks[1].settings[0].second, "180");
  EXPECT_TRUE(is_open(table.analyzer_deg[0]));
  EXPECT_EQ(table.theta_r_deg[1], 12.5);
  EXPECT_EQ(table.direction[1], -1);
  EXPECT_EQ(table.saturated[1], 1);
  EXPECT_EQ(table.shutter_open[1], 0);
  EXPECT_EQ(table.phi_r_deg[2], 150);
}

TEST(ScanCsv, HarmlessVariationsGiveTheSameValues) {
  const std::string canonical = scan_csv_text(parse_scan_csv(small, "small"));
  std::string crlf;
  for (const char c : small) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const std::vector<std::string> variants = {
      "\xef\xbb\xbf" + small,
      crlf,
      small + "\n\n  \n",
      small.substr(0, small.size() - 1),
      replaced(small, ",open,1,100,", " , open , +1 ,100,"),
      replaced(small, "# sample: coupon", "#sample:   coupon  "),
      replaced(small, "0.450", "0.45"),
      replaced(small, "0.1,0,1e-05", "1e-1,0,.00001")};
  for (const std::string& variant : variants)
    EXPECT_EQ(scan_csv_text(parse_scan_csv(variant, "variant")), canonical);
}

TEST(ScanCsv, DigitsBeyondTheCanonicalOnesAreNotLost) {
  const std::string text = replaced(replaced(small, "0.0021820908", "0.00218209081234567"),
                                    "1.000,30", "1.0004321,30.00000012");
  const ScanTable table = parse_scan_csv(text, "fine");
  const ScanTable again = parse_scan_csv(scan_csv_text(table), "again");
  EXPECT_EQ(again.x_v, table.x_v);
  EXPECT_EQ(again.time_s, table.time_s);
  EXPECT_EQ(again.theta_i_deg, table.theta_i_deg);
  EXPECT_EQ(table.time_s[1], 1.0004321);
}

TEST(ScanCsv, RoundingMakesATableCanonical) {
  ScanTable table = parse_scan_csv(small, "small");
  table.x_v[0] = 1.0 / 3.0;
  table.time_s[1] = 2.0 / 3.0;
  table.y_v[2] = -0.0;
  round_to_canonical(table);
  const std::string text = scan_csv_text(table);
  EXPECT_THAT(text, HasSubstr(",0.33333333,"));
  EXPECT_THAT(text, HasSubstr("1,0.667,"));
  EXPECT_THAT(text, HasSubstr("1.5,0,0,0,0.9"));
  EXPECT_TRUE(is_open(table.analyzer_deg[0]));
}

TEST(ScanCsv, CommentsThatAreNoKeysAndRepeatedUnknownKeysAreKept) {
  const std::string text =
      replaced(small, "# sample:", "# measured by hand\n# note: a\n# note: b\n# sample:");
  const std::string back = scan_csv_text(parse_scan_csv(text, "text"));
  EXPECT_THAT(back, HasSubstr("measured by hand"));
  EXPECT_THAT(back, HasSubstr("# note: a\n# note: b\n"));
}

struct Fault {
  const char* what;
  const char* by;
  std::size_t line;
  const char* column;
  const char* message;  ///< part of problem or remedy
};

class ScanCsvFault : public ::testing::TestWithParam<Fault> {};

TEST_P(ScanCsvFault, IsRefusedWithLineAndColumn) {
  const Fault& fault = GetParam();
  const Error error = error_of(replaced(small, fault.what, fault.by));
  EXPECT_EQ(error.place().file, "scan.csv");
  EXPECT_EQ(error.place().line, fault.line) << error.what();
  EXPECT_EQ(error.place().column, fault.column) << error.what();
  EXPECT_THAT(std::string(error.what()), HasSubstr(fault.message));
  EXPECT_FALSE(error.remedy().empty());
}

INSTANTIATE_TEST_SUITE_P(
    Columns, ScanCsvFault,
    ::testing::Values(Fault{"y_se_v,", "", 7, "y_se_v", "missing"},
                      Fault{"theta_i_deg", "theta_i_rad", 7, "theta_i_rad",
                            "`theta_i_deg`, in deg"},
                      Fault{"time_s", "time_ms", 7, "time_ms", "`time_s`, in s"},
                      Fault{"x_v", "x_mv", 7, "x_mv", "`x_v`, in V"},
                      Fault{"wavelength_nm", "wavelength_um", 7, "wavelength_um", "in nm"},
                      Fault{"gain", "colour", 7, "colour", "unknown column"},
                      Fault{"gain,", "gain,gain,", 7, "gain", "twice"},
                      Fault{"x_v,y_v", "y_v,x_v", 7, "y_v", "out of order"},
                      Fault{",shutter\n", ",shutter,comment\n", 7, "comment", "unknown column"}));

INSTANTIATE_TEST_SUITE_P(
    Numbers, ScanCsvFault,
    ::testing::Values(Fault{"0.1,0,1e-05", "nan,0,1e-05", 9, "x_v", "finite"},
                      Fault{"0.1,0,1e-05", "0.1,inf,1e-05", 9, "y_v", "finite"},
                      Fault{"0.1,0,1e-05", "0.1V,0,1e-05", 9, "x_v", "not a number"},
                      Fault{"0.1,0,1e-05", ",0,1e-05", 9, "x_v", "empty"},
                      Fault{"0.1,0,1e-05", "0x1p3,0,1e-05", 9, "x_v", "not a number"},
                      Fault{"0.1,0,1e-05", "1e999,0,1e-05", 9, "x_v", "range"},
                      Fault{"0.1,0,1e-05", "0.1,0,-1e-05", 9, "x_se_v", "0 V or more"},
                      Fault{"1,1.000", "1.0,1.000", 9, "index", "integer"},
                      Fault{"1,1.000", "0,1.000", 9, "index", "follows"},
                      Fault{"1,1.000", "-1,1.000", 9, "index", "range"},
                      Fault{"1,1.000", "99999999999999999999,1.0", 9, "index", "64-bit"},
                      Fault{"0,-1,10", "0,0,10", 9, "direction", "1 or -1"},
                      Fault{"1,1,closed", "1,2,closed", 9, "saturated", "range"},
                      Fault{"closed", "shut", 9, "shutter", "`open` or `closed`"},
                      Fault{"90,0,-1", "90,wide,-1", 9, "analyzer_deg", "not a number"},
                      Fault{"-1,10,", "-1,0,", 9, "gain", "amplifier range"}));

INSTANTIATE_TEST_SUITE_P(
    Geometry, ScanCsvFault,
    ::testing::Values(Fault{"1.000,30", "1.000,91", 9, "theta_i_deg", "0 to 90 deg"},
                      Fault{"1.000,30", "1.000,-3", 9, "theta_i_deg", "0 to 90 deg"},
                      Fault{"30,12.5", "30,-95", 9, "theta_r_deg", "-90 to 90 deg"},
                      Fault{"40,150", "40,-180", 10, "phi_r_deg", "above -180"},
                      Fault{"40,150", "40,181", 10, "phi_r_deg", "above -180"},
                      Fault{"40,150", "-40,150", 10, "theta_r_deg", "phi_r_deg + 180"},
                      Fault{"0,532,90", "0,0,90", 9, "wavelength_nm", "nanometres"},
                      Fault{"0,532,90", "0,0.532,90", 9, "wavelength_nm", "micrometres"},
                      Fault{"0,532,90", "0,5.32e-7,90", 9, "wavelength_nm", "micrometres"}));

INSTANTIATE_TEST_SUITE_P(
    Structure, ScanCsvFault,
    ::testing::Values(Fault{"1,closed\n", "1\n", 9, "", "16 fields"},
                      Fault{"1,closed\n", "1,closed,7\n", 9, "", "18 fields"},
                      Fault{"1,closed\n", "1,closed\n\n", 10, "", "blank line"},
                      Fault{"flip 2-2", "flip 2-3", 6, "", "rows 2-3"},
                      Fault{"flip 2-2", "flip 2-1", 6, "", "range"},
                      Fault{"flip 2-2", "flip two", 6, "", "row range"},
                      Fault{"note=x", "note", 6, "", "setting"},
                      Fault{"umov scan csv", "umov scan v2", 1, "", "umov scan csv"},
                      Fault{"solid_angle_sr: 1e-4", "solid_angle_sr: small", 3, "", "not a number"},
                      Fault{"solid_angle_sr: 1e-4", "solid_angle_sr: nan", 3, "", "finite"},
                      Fault{"# sample: coupon\n", "# sample: a\n# sample: b\n", 3, "", "twice"}));

TEST(ScanCsv, FilesWithoutHeaderLineOrRecordsAreRefused) {
  EXPECT_THAT(error_of("").what(), HasSubstr("no header line"));
  EXPECT_THAT(error_of("# sample: x\n").what(), HasSubstr("no header line"));
  EXPECT_THAT(error_of("# sample: x\n" + columns).what(), HasSubstr("no records"));
}

TEST(ScanCsv, EveryCutOffFileIsReadWholeOrRefused) {
  for (std::size_t size = 0; size < small.size(); ++size) {
    try {
      const ScanTable table = parse_scan_csv(small.substr(0, size), "cut");
      // Only a cut inside the last word or number, or right behind a block's rows, can go unseen.
      EXPECT_EQ(table.size(), 3u) << size;
    } catch (const Error& error) {
      EXPECT_EQ(error.place().file, "cut");
    }
  }
}

TEST(ScanCsv, MissingFilesAndFoldersAreNamed) {
  EXPECT_THROW(read_scan_csv("/no/such/scan.csv"), Error);
  const ScratchFolder folder;
  EXPECT_THROW(read_scan_csv(folder.path()), Error);
}

TEST(ScanCsv, AFailedWriteLeavesTheOlderFileAlone) {
  const ScratchFolder folder;
  ScanTable table = parse_scan_csv(small, "small");
  write_scan_csv(table, folder / "scan.csv");
  table.theta_i_deg[1] = 120;
  EXPECT_THROW(write_scan_csv(table, folder / "scan.csv"), Error);
  EXPECT_EQ(read_whole_file(folder / "scan.csv"), small);
  EXPECT_THROW(write_scan_csv(parse_scan_csv(small, "s"), folder / "no" / "scan.csv"), Error);
  int files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path()))
    ++files;
  EXPECT_EQ(files, 1) << "no temporary files stay";
}

TEST(ScanCsv, StreamsReadAndWriteToo) {
  std::istringstream in(small);
  std::ostringstream out;
  write_scan_csv(read_scan_csv(in, "stream"), out);
  EXPECT_EQ(out.str(), small);
}

TEST(ForeignKind, IsToldByTheHeaderLine) {
  EXPECT_EQ(foreign_kind(small), ForeignKind::scan_csv);
  EXPECT_EQ(foreign_kind(replaced(small, "theta_i_deg", "theta_i_rad")), ForeignKind::scan_csv);
  EXPECT_EQ(foreign_kind("material,theta_r_deg,theta_i_deg,radiance_w_m2_sr\n"), ForeignKind::jsss);
  EXPECT_EQ(foreign_kind("lambda,thetai,phi,thetar,phir,f_r11\n"), ForeignKind::nist_ptfe);
  EXPECT_EQ(foreign_kind("a,b\n1,2\n"), ForeignKind::unknown);
  EXPECT_EQ(foreign_kind(""), ForeignKind::unknown);
}

}  // namespace
}  // namespace umov::formats
