// Files that are not whole, go on too far, or have no end.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "host/formats/astm.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/cornell_brdf.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/formats/scatmech_text.hpp"
#include "host/formats/table_csv.hpp"
#include "scratch_folder.hpp"
#include "table_sources.hpp"

namespace umov::formats {
namespace {

using testing::expect_refused;
using testing::ScratchFolder;

/// Cut by one to `most` bytes, a text is refused as one that ends within a line.
template <class Read>
void expect_cuts_refused(Read read, const std::string& text, std::size_t most) {
  read(text);
  for (std::size_t cut = 1; cut <= most; ++cut) {
    SCOPED_TRACE(cut);
    expect_refused([&] { read(text.substr(0, text.size() - cut)); },
                   {"the file ends within a line", "cut off"});
  }
}

TEST(CutOffText, GridsOfDirectionsAreRefusedWhereTheLastValueLostItsDigits) {
  expect_cuts_refused([](const std::string& text) { read_grid_csv(text, "t.csv"); },
                      "theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,m00\n"
                      "0,0,0,550,0.1\n0,30,0,550,0.125\n",
                      5);
}

TEST(CutOffText, PlanesAreRefused) {
  expect_cuts_refused([](const std::string& text) { read_planes_csv(text, "t.csv"); },
                      "plane,theta_i_deg,angle_deg,wavelength_nm,m00\nin,30,30,550,0.5\n"
                      "across,30,0,550,0.5\nacross,30,40,550,0.125\n",
                      5);
}

TEST(CutOffText, AstmPointsAreRefused) {
  expect_cuts_refused([](const std::string& text) { read_astm(text, "x.astm"); },
                      "ASTM E2387\nWAVELENGTH 633 nm\nANGLE_UNITS DEGREES\n"
                      "VARS theta_i,theta_s,BRDF\n30,40,0.1\n30,50,0.125\n",
                      11);
}

TEST(CutOffText, CornellRecordsAreRefused) {
  expect_cuts_refused([](const std::string& text) { read_cornell_brdf(text, "x.brdf"); },
                      "# a\n2\n450\n650\n0.698132 0 0.698132 3.141593 0.125 0.375\n", 10);
}

TEST(CutOffText, ScatmechParametersAreRefused) {
  expect_cuts_refused([](const std::string& text) { parse_scatmech(text, "m.txt"); },
                      "Facet_BRDF_Model\nlambda = 0.6328\nsubstrate = (1.5,0)\nsdf.s = 0.25\n", 12);
}

TEST(CutOffText, ScansEndWithAWordThatCannotBeCut) {
  const std::string text =
      "index,time_s,theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,polarizer_deg,analyzer_deg,"
      "direction,gain,x_v,y_v,x_se_v,y_se_v,monitor_v,saturated,shutter\n"
      "0,0.450,30,0,0,532,0,0,1,100,0.01,0,1e-05,1e-05,1,0,open\n";
  EXPECT_EQ(parse_scan_csv(text, "s.csv").size(), 1u);
  EXPECT_EQ(parse_scan_csv(text.substr(0, text.size() - 1), "s.csv").size(), 1u)
      << "nothing is lost with the line end";
  for (std::size_t cut = 2; cut < 20; ++cut)
    expect_refused([&] { parse_scan_csv(text.substr(0, text.size() - cut), "s.csv"); },
                   {"s.csv:2"});
}

TEST(WrittenText, EndsWithALineEnd) {
  const auto source = testing::model_table("lambertian", {{"rho", 0.5}});
  for (const char* name : {"table-csv", "planes-csv", "scatmech", "zemax", "window"})
    EXPECT_TRUE(table_format(name).write(source, {}).ends_with('\n')) << name;
}

TEST(ReadingFiles, DevicesAndFilesWithoutEndAreRefused) {
  expect_refused([] { read_whole_file("/dev/zero"); }, {"/dev/zero", "device"});
  const ScratchFolder folder;
  const auto sparse = folder / "sparse";
  replace_file(sparse, "");
  std::filesystem::resize_file(sparse, largest_file_bytes + 1);
  expect_refused([&] { read_whole_file(sparse); }, {"sparse", "larger than 2147 MB"});
  replace_file(sparse, std::string(1000, 'x'));
  EXPECT_EQ(read_whole_file(sparse, 1000).size(), 1000u);
  expect_refused([&] { read_whole_file(sparse, 999); }, {"larger than"});
}

TEST(ReadingFiles, PipesAreReadToTheirEndAndNoFurtherThanTheLimit) {
  const ScratchFolder folder;
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const std::string text(100'000, 'y');
  const auto writing = [&] { return std::thread([&] { std::ofstream(pipe) << text; }); };
  std::thread writer = writing();
  EXPECT_EQ(read_whole_file(pipe), text);
  writer.join();
  writer = writing();
  expect_refused([&] { read_whole_file(pipe, 50'000); }, {"larger than"});
  writer.join();
}

}  // namespace
}  // namespace umov::formats
