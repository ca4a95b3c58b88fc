#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/brdf_csv.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/h5_kind.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/formats/scan_h5.hpp"
#include "tests/unit/formats/scratch_folder.hpp"

namespace umov::formats {
namespace {

using ::testing::HasSubstr;
using testing::ScratchFolder;

std::string part_text() {
  return read_whole_file(std::string(UMOV_TEST_DATA) + "/foreign_scans/scan_07_part.csv");
}

Provenance some_provenance() {
  Provenance provenance;
  provenance.program = "umov 0.1.0";
  provenance.command = "umov scan plan.toml -o \"scan é.h5\"";
  provenance.created = "2024-05-01T12:00:00Z";
  provenance.firmware_hash = "00ff";
  provenance.settings = "{}";
  provenance.plan = std::string(100'000, '#') + "\nsample = \"x\"\n";
  return provenance;
}

BrdfTable some_brdf() {
  BrdfTable table;
  table.keys = {{"sample", "tile"}, {"note", ""}};
  for (int n = 0; n < 6000; ++n) {
    table.points.theta_i_deg.push_back(30);
    table.points.theta_r_deg.push_back(-80 + 0.02 * n);
    table.points.phi_r_deg.push_back(0);
    table.points.wavelength_nm.push_back(532);
    table.points.polarizer_deg.push_back(90);
    table.points.analyzer_deg.push_back(n % 3 == 0 ? open_axis : 45.0);
    table.points.brdf_per_sr.push_back(std::sin(n) + 2);
    table.points.brdf_u.push_back(1e-3);
    table.points.used.push_back(n % 7 == 0 ? 0 : 1);
  }
  table.factors = {{"gain 532 nm", std::vector<double>(6000, 0.01)},
                   {"tile", std::vector<double>(6000, -0.02)}};
  table.dolp = {{30}, {30}, {0}, {532}, {0.93}, {0.01}};
  table.dhr = {{532, 633}, {30, 30}, {0.01, 0.47}, {0.001, 0.002}};
  return table;
}

/// Without the syncing of replace_file: these files are made to be broken.
void write_plain(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

template <class Read>
std::string refusal(Read read) {
  try {
    read();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(ScanH5, KeepsEveryValueKeyAndBlock) {
  const ScratchFolder folder;
  const ScanTable table = parse_scan_csv(part_text(), "part");
  write_scan_h5(folder / "scan.h5", table, some_provenance());
  const ScanFile back = read_scan_h5(folder / "scan.h5");
  EXPECT_EQ(scan_csv_text(back.table), part_text());
  EXPECT_EQ(back.content_sha256, content_sha256(table));
  EXPECT_EQ(back.provenance.plan, some_provenance().plan);
  EXPECT_EQ(back.provenance.command, some_provenance().command);
  EXPECT_EQ(back.provenance.device, "gonioreflectometer") << "taken from the header keys";
  EXPECT_EQ(h5_kind(folder / "scan.h5"), H5Kind::scan);
}

TEST(ScanH5, EitherKindOfScanFileIsRecognised) {
  const ScratchFolder folder;
  const ScanTable table = parse_scan_csv(part_text(), "part");
  write_scan_h5(folder / "a", table, {});
  write_scan_csv(table, folder / "b");
  EXPECT_EQ(read_scan(folder / "a").content_sha256, read_scan(folder / "b").content_sha256);
}

TEST(ScanH5, TheChecksumSeesEveryColumn) {
  const ScanTable table = parse_scan_csv(part_text(), "part");
  ScanTable other = table;
  other.monitor_v[17] = std::nextafter(other.monitor_v[17], 2.0);
  EXPECT_NE(content_sha256(other), content_sha256(table));
  other = table;
  other.shutter_open[3] = 0;
  EXPECT_NE(content_sha256(other), content_sha256(table));
  other = table;
  other.blocks[2].settings[0].second = "90";
  EXPECT_NE(content_sha256(other), content_sha256(table));
}

TEST(ScanH5, CutOffFilesAreRefused) {
  const ScratchFolder folder;
  write_scan_h5(folder / "scan.h5", parse_scan_csv(part_text(), "part"), {});
  const std::string whole = read_whole_file(folder / "scan.h5");
  for (std::size_t size = 0; size < whole.size(); size += size < 2000 ? 1 : 997) {
    const std::string message = refusal([&] { parse_scan_h5(whole.substr(0, size), "cut.h5"); });
    ASSERT_THAT(message, HasSubstr("cut.h5")) << size;
  }
}

TEST(ScanH5, FlippedBitsAreRefused) {
  const ScratchFolder folder;
  write_scan_h5(folder / "scan.h5", parse_scan_csv(part_text(), "part"), {});
  const std::string whole = read_whole_file(folder / "scan.h5");
  std::mt19937 random(7);
  for (int trial = 0; trial < 300; ++trial) {
    // The first half of the trials hits the start of the file: user block and superblock.
    const std::size_t range = trial < 150 ? 700 : whole.size();
    const std::size_t at = random() % range;
    if (at >= 48 + 65 && at < 512) continue;  // padding of the user block
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << (random() % 8)));
    EXPECT_THAT(refusal([&] { parse_scan_h5(damaged, "bad.h5"); }), HasSubstr("bad.h5")) << at;
  }
}

TEST(ScanH5, ForeignFilesAreRefusedWithOneMessage) {
  const ScratchFolder folder;
  write_plain(folder / "text.h5", "hello");
  EXPECT_THAT(refusal([&] { read_scan_h5(folder / "text.h5"); }), HasSubstr("not an HDF5 file"));
  write_brdf_h5(folder / "brdf.h5", some_brdf(), {});
  EXPECT_THAT(refusal([&] { read_scan_h5(folder / "brdf.h5"); }), HasSubstr("umov brdf h5"));
  EXPECT_THAT(refusal([&] { read_scan_h5(folder / "none.h5"); }), HasSubstr("cannot open"));
  // HDF5 bytes without our user block: the library itself must refuse what is not whole.
  const std::string image = read_whole_file(folder / "brdf.h5").substr(512);
  write_plain(folder / "half.h5", image.substr(0, image.size() / 2));
  EXPECT_THAT(refusal([&] { read_brdf_h5(folder / "half.h5"); }), HasSubstr("half.h5"));
  write_plain(folder / "bare.h5", image);
  EXPECT_EQ(read_brdf_h5(folder / "bare.h5").table.points.size(), 6000u);
}

TEST(ScanH5, AFailedWriteLeavesTheOlderFileAlone) {
  const ScratchFolder folder;
  ScanTable table = parse_scan_csv(part_text(), "part");
  write_scan_h5(folder / "scan.h5", table, {});
  const std::string before = read_whole_file(folder / "scan.h5");
  table.x_v[3] = NAN;
  EXPECT_THAT(refusal([&] { write_scan_h5(folder / "scan.h5", table, {}); }), HasSubstr("x_v"));
  table = parse_scan_csv(part_text(), "part");
  table.y_v.pop_back();
  EXPECT_THAT(refusal([&] { write_scan_h5(folder / "scan.h5", table, {}); }), HasSubstr("y_v"));
  EXPECT_TRUE(read_whole_file(folder / "scan.h5") == before);
}

TEST(BrdfH5, KeepsEveryGroupAndTheCovariance) {
  const ScratchFolder folder;
  const BrdfTable table = some_brdf();
  write_brdf_h5(folder / "brdf.h5", table, some_provenance());
  const BrdfFile back = read_brdf_h5(folder / "brdf.h5");
  EXPECT_EQ(back.content_sha256, content_sha256(table));
  EXPECT_EQ(back.table.keys, table.keys);
  EXPECT_EQ(back.table.points.brdf_per_sr, table.points.brdf_per_sr);
  EXPECT_EQ(back.table.points.used, table.points.used);
  EXPECT_TRUE(is_open(back.table.points.analyzer_deg[0]));
  EXPECT_EQ(back.table.points.analyzer_deg[1], 45);
  ASSERT_EQ(back.table.factors.size(), 2u);
  EXPECT_EQ(back.table.factors[1].name, "tile");
  EXPECT_EQ(back.table.factors[1].per_point, table.factors[1].per_point);
  EXPECT_EQ(back.table.dolp.dolp, table.dolp.dolp);
  EXPECT_EQ(back.table.dhr.dhr, table.dhr.dhr);
  EXPECT_EQ(h5_kind(folder / "brdf.h5"), H5Kind::brdf);
}

TEST(BrdfH5, AnEmptyTableIsAFileToo) {
  const ScratchFolder folder;
  write_brdf_h5(folder / "empty.h5", BrdfTable{}, {});
  EXPECT_EQ(read_brdf_h5(folder / "empty.h5").table.points.size(), 0u);
}

TEST(BrdfH5, UnequalColumnsAndNumbersThatAreNoneAreRefused) {
  const ScratchFolder folder;
  BrdfTable table = some_brdf();
  table.points.brdf_u[5] = INFINITY;
  EXPECT_THAT(refusal([&] { write_brdf_h5(folder / "b.h5", table, {}); }),
              HasSubstr("/points/brdf_u"));
  table = some_brdf();
  table.factors[0].per_point.pop_back();
  EXPECT_THAT(refusal([&] { write_brdf_h5(folder / "b.h5", table, {}); }),
              HasSubstr("gain 532 nm"));
  table = some_brdf();
  table.dhr.dhr_u.push_back(1);
  EXPECT_THAT(refusal([&] { write_brdf_h5(folder / "b.h5", table, {}); }), HasSubstr("/dhr/dhr_u"));
  EXPECT_FALSE(std::filesystem::exists(folder / "b.h5"));
}

TEST(BrdfH5, ItsTextHasALineForEveryValue) {
  const std::string text = brdf_csv_text(some_brdf());
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 6000 + 1 + 2 + 1 + 3 + 2);
  EXPECT_THAT(text, HasSubstr("\nbrdf,532,30,-80,0,90,open,2,0.001,0\n"));
  EXPECT_THAT(text, HasSubstr("\ndhr,633,30,,,,,0.47,0.002,1\n"));
}

TEST(Hdf5Files, AreReadByH5py) {
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3 with h5py is not installed";
  const ScratchFolder folder;
  write_scan_h5(folder / "scan.h5", parse_scan_csv(part_text(), "part"), some_provenance());
  write_brdf_h5(folder / "brdf.h5", some_brdf(), {});
  std::ofstream(folder / "check.py") << R"(
import sys, h5py
f = h5py.File(sys.argv[1] + '/scan.h5')
assert f.attrs['format'] == 'umov scan h5'
assert f.attrs['sample'] == 'coupon' and f.attrs['device'] == 'gonioreflectometer'
assert f['records'].keys() >= {'index', 'theta_i_deg', 'x_v', 'shutter'}
assert f['records/x_v'].attrs['unit'] == 'V' and f['records/x_v'].shape == (741,)
assert list(f['records/shutter'].attrs['enum']) == ['closed', 'open']
assert f['records/shutter'][324 + 205 + 82] == 0
assert f['blocks/name'][2] == b'flip'
b = h5py.File(sys.argv[1] + '/brdf.h5')
assert b['covariance/per_point'].shape == (2, 6000)
assert b['points/brdf_per_sr'].attrs['unit'] == '1/sr'
assert abs(b['dhr/dhr'][1] - .47) < 1e-12
)";
  const std::string command =
      "/usr/bin/python3 " + (folder / "check.py").string() + " " + folder.path().string();
  EXPECT_EQ(std::system(command.c_str()), 0);
}

}  // namespace
}  // namespace umov::formats
