#include "host/formats/table_h5.hpp"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <numeric>

#include "host/brdf/grid_table.hpp"
#include "host/brdf/planes_table.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/h5_kind.hpp"
#include "scratch_folder.hpp"
#include "table_sources.hpp"

namespace umov::formats {
namespace {

using testing::expect_refused;
using testing::m00;
using testing::ScratchFolder;

brdf::GridTable small_grid(int elements) {
  brdf::GridAxes axes{{0, 30, 60}, {0, 20, 40, 80}, {0, 90, 180}, {0.532, 0.633}};
  std::vector<double> values(2 * 3 * 4 * 3 * static_cast<std::size_t>(elements));
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] =
        i % static_cast<std::size_t>(elements) == 0 ? 1.0 + 0.01 * static_cast<double>(i) : 0.0;
  return {axes, values, elements, "a test"};
}

TEST(TableH5, GridsComeBackNumberByNumber) {
  for (const int elements : {1, 16}) {
    const brdf::GridTable grid = small_grid(elements);
    const std::string bytes = write_table_h5(grid, {});
    const auto back =
        std::dynamic_pointer_cast<const brdf::GridTable>(read_table_h5(bytes, "t.h5"));
    ASSERT_NE(back, nullptr);
    EXPECT_EQ(back->elements(), elements);
    EXPECT_EQ(back->axes().phi_r_deg, grid.axes().phi_r_deg);
    EXPECT_EQ(back->axes().wavelength_um, grid.axes().wavelength_um);
    EXPECT_TRUE(std::equal(back->values().begin(), back->values().end(), grid.values().begin(),
                           grid.values().end()));
    EXPECT_EQ(back->origin(), "a test");
    EXPECT_EQ(content_sha256(*back), content_sha256(grid));
  }
}

TEST(TableH5, PlanesComeBackNumberByNumber) {
  brdf::PlanesAtIncidence first{
      20.0, {{-40, 0, 20, 60}, {{1, 2, 3, 4}, {5, 6, 7, 8}}}, {{0, 15}, {{3, 1}, {7, 2}}}};
  brdf::PlanesAtIncidence second{
      50.0, {{-10, 50}, {{1, 2}, {3, 4}}}, {{-5, 0, 5}, {{1, 2, 3}, {4, 5, 6}}}};
  const brdf::PlanesTable planes({0.5, 0.6}, {first, second}, "two planes");
  const auto back = std::dynamic_pointer_cast<const brdf::PlanesTable>(
      read_table_h5(write_table_h5(planes, {}), "t.h5"));
  ASSERT_NE(back, nullptr);
  ASSERT_EQ(back->incidences().size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(back->incidences()[i].in_plane.deg, planes.incidences()[i].in_plane.deg);
    EXPECT_EQ(back->incidences()[i].in_plane.brdf_per_sr,
              planes.incidences()[i].in_plane.brdf_per_sr);
    EXPECT_EQ(back->incidences()[i].across.brdf_per_sr, planes.incidences()[i].across.brdf_per_sr);
  }
  EXPECT_EQ(content_sha256(*back), content_sha256(planes));
}

TEST(TableH5, ModelsAreSampledWithAllMuellerElements) {
  const auto source = testing::model_table("microfacet", {{"slope_rms", 0.3}});
  const TablePtr table = read_table_h5(write_table_h5(source, {}), "t.h5");
  EXPECT_TRUE(table->polarised());
  const brdf::Geometry<double> node{optics::radians(45.0), optics::radians(30.0),
                                    optics::radians(20.0)};
  const auto expected = source.at(0.55, node), found = table->at(0.55, node);
  for (int k = 0; k < 16; ++k)
    EXPECT_NEAR(optics::element(found, k / 4, k % 4), optics::element(expected, k / 4, k % 4),
                1e-12);
  EXPECT_LT(compare_tables(*table, source, {0.55}).median, 2e-3);
}

TEST(TableH5, SaysInWordsWhatItHolds) {
  TableWriting writing;
  writing.program = "umov test";
  writing.command = "umov export …";
  const TableH5 file = parse_table_h5(write_table_h5(small_grid(16), writing), "t.h5");
  const auto value = [&](const std::string& key) {
    for (const auto& [name, text] : file.keys)
      if (name == key) return text;
    return std::string();
  };
  EXPECT_THAT(value("quantity"), ::testing::HasSubstr("not multiplied by cos theta"));
  EXPECT_THAT(value("azimuth"), ::testing::HasSubstr("specular"));
  EXPECT_THAT(value("solid angle"), ::testing::HasSubstr("not for averages"));
  EXPECT_THAT(value("wavelength"), ::testing::HasSubstr("532, 633 nm"));
  EXPECT_THAT(value("polarisation"), ::testing::HasSubstr("Q > 0 is s"));
  EXPECT_EQ(file.provenance.program, "umov test");
}

TEST(TableH5, IsToldFromScansAndBrdfs) {
  const ScratchFolder folder;
  replace_file(folder / "t.h5", write_table_h5(small_grid(1), {}));
  EXPECT_EQ(h5_kind(folder / "t.h5"), H5Kind::table);
  EXPECT_EQ(read_table(folder / "t.h5")->wavelengths_um().size(), 2u);
}

TEST(TableH5, NoticesDamage) {
  const std::string good = write_table_h5(small_grid(1), {});
  std::string flipped = good;
  flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 4);
  expect_refused([&] { read_table_h5(flipped, "t.h5"); }, {"t.h5", "checksum"});
  expect_refused([&] { read_table_h5(good.substr(0, good.size() - 100), "t.h5"); }, {"checksum"});
}

/// A file of another program: no checksums.
std::string foreign(const std::string& layout, std::vector<double> theta_i,
                    const std::vector<double>& values, const std::vector<std::size_t>& shape) {
  Hdf5Builder file("foreign");
  file.attribute("/", "format", "umov table h5");
  file.attribute("/", "layout", layout);
  file.group("/axes");
  file.column("/axes/theta_i_deg", theta_i, "deg");
  file.column("/axes/theta_r_deg", std::vector<double>{0, 45}, "deg");
  file.column("/axes/phi_r_deg", std::vector<double>{0, 180}, "deg");
  file.column("/axes/wavelength_um", std::vector<double>{0.5}, "um");
  file.array("/values", values, shape, "1/sr");
  return file.finish();
}

TEST(TableH5, RefusesWhatDoesNotFitWithItsPath) {
  const auto refuse = [](const std::string& bytes, const std::vector<std::string>& says) {
    expect_refused([&] { read_table_h5(bytes, "t.h5"); }, says);
  };
  std::vector<double> values(8, 0.1);
  EXPECT_NE(read_table_h5(foreign("grid", {0, 50}, values, {1, 2, 2, 2, 1}), "t.h5"), nullptr);
  refuse(foreign("grid", {0, 50, 60}, values, {1, 2, 2, 2, 1}), {"/values", "dimension 2"});
  refuse(foreign("grid", {0, 50}, values, {1, 2, 2, 1, 2}), {"/values", "dimension 4"});
  refuse(foreign("grid", {50, 0}, values, {1, 2, 2, 2, 1}), {"theta_i"});
  refuse(foreign("grid", {0, 91}, values, {1, 2, 2, 2, 1}), {"91"});
  refuse(foreign("cube", {0, 50}, values, {1, 2, 2, 2, 1}), {"/@layout", "cube"});
  values[3] = std::nan("");
  refuse(foreign("grid", {0, 50}, values, {1, 2, 2, 2, 1}), {"t.h5", "nan", "[0][0][1][1]"});
  values[3] = -0.1;
  refuse(foreign("grid", {0, 50}, values, {1, 2, 2, 2, 1}), {"t.h5", "-0.1", "[0][0][1][1]"});
}

}  // namespace
}  // namespace umov::formats
