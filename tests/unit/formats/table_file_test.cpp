#include "host/formats/table_file.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <string_view>

#include "host/formats/atomic_file.hpp"
#include "scratch_folder.hpp"
#include "table_sources.hpp"

namespace umov::formats {
namespace {

using testing::expect_refused;
using testing::m00;
using testing::model_table;
using testing::ScratchFolder;

TEST(TableFormats, HaveNamesOfTheirOwnAndDoSomething) {
  std::set<std::string_view> names;
  for (const TableFormat& format : table_formats()) {
    EXPECT_TRUE(names.insert(format.name).second) << format.name;
    EXPECT_FALSE(format.title.empty());
    EXPECT_TRUE(format.read != nullptr || format.write != nullptr ||
                format.read_points != nullptr || format.write_points != nullptr)
        << format.name;
  }
}

/// A Lambertian surface of reflectance .5 in every format that is written, made once.
const std::map<std::string_view, std::string>& grey_files() {
  static const auto files = [] {
    std::map<std::string_view, std::string> made;
    const auto source = model_table("lambertian", {{"rho", 0.5}});
    for (const TableFormat& format : table_formats())
      if (format.write != nullptr) made.emplace(format.name, format.write(source, {}));
    return made;
  }();
  return files;
}

TEST(TableFormats, RecogniseTheirOwnFilesAndNoOthers) {
  for (const auto& [name, bytes] : grey_files()) {
    const TableFormat& format = table_format(name);
    if (format.recognises == nullptr) continue;
    for (const TableFormat& other : table_formats()) {
      if (other.recognises == nullptr) continue;
      EXPECT_EQ(other.recognises(bytes), other.name == format.name)
          << format.name << " seen by " << other.name;
    }
    EXPECT_EQ(recognised_format(bytes), &format);
  }
}

TEST(TableFormats, GiveALambertianSurfaceBack) {
  const ScratchFolder folder;
  for (const auto& [name, bytes] : grey_files()) {
    if (table_format(name).read == nullptr) continue;
    replace_file(folder / "file", bytes);
    const TablePtr back = read_table(folder / "file");
    const double um = back->wavelengths_um().front();
    for (const double theta_i : {0.0, 33.0, 60.0})
      for (const double theta_r : {0.0, 17.0, 58.0})
        EXPECT_NEAR(m00(*back, um, theta_i, theta_r, 50.0), 0.5 / optics::pi, 1e-3)
            << name << " " << theta_i << " " << theta_r;
  }
}

TEST(TableFormats, SayInAFileWithCommentsWhatTheNumbersAre) {
  const auto source = model_table("lambertian");
  TableWriting writing;
  writing.program = "umov 9.9";
  for (const char* name : {"rgl", "zemax", "table-csv", "planes-csv", "window"}) {
    const std::string text = table_format(name).write(source, writing);
    for (const char* part : {"quantity: ", "azimuth: ", "solid angle: ", "550 nm",
                             "polarisation: ", "program: umov 9.9"})
      EXPECT_THAT(text, ::testing::HasSubstr(part)) << name;
  }
}

TEST(TableFormats, NameWhatExistsWhereOneIsUnknown) {
  expect_refused([] { table_format("obj"); }, {"'obj'", "merl", "zemax"});
  expect_refused([] { table_format("astm", FormatUse::writing); },
                 {"astm files are not written from tables", "table, merl, rgl"});
  EXPECT_EQ(format_names(FormatUse::writing).find("astm"), std::string::npos);
  EXPECT_EQ(format_names(FormatUse::reading).find("cornell"), std::string::npos);
  EXPECT_NE(format_names(FormatUse::any).find("cornell"), std::string::npos);
  const ScratchFolder folder;
  replace_file(folder / "file", "nothing of the kind\n");
  expect_refused([&] { read_table(folder / "file"); }, {"no table of a known format", "merl"});
}

TEST(Reflectances, ShowAPeakThatFewDirectionsSee) {
  // A mirror-like lobe of a quarter of a degree, and the same surface without it.
  const auto glossy = model_table("microfacet+lambertian", {{"0.slope_rms", 2e-3}, {"1.rho", 0.3}});
  const auto matt = model_table("lambertian", {{"rho", 0.3}});
  EXPECT_LT(compare_tables(matt, glossy, {0.55}).median, 0.01);
  const ReflectanceDifference d = compare_reflectances(matt, 0.55, glossy, 0.55, false);
  EXPECT_NEAR(d.found[0], 0.3, 1e-6);
  EXPECT_NEAR(d.expected[0], 0.34, 2e-3) << "Fresnel reflectance of index 1.5 beside the body";
  EXPECT_GT(d.largest(), 0.1) << "at 70 deg";
  EXPECT_THAT(d.sentence(), ::testing::HasSubstr("DHR at 10, 45, 70 deg: 0.3000, 0.3000, 0.3000"));
}

TEST(TableHeader, KeepsToPrintableAscii) {
  TableHeader header;
  header.description = "θ and a\nline break";
  for (const std::string& line : header.lines())
    for (const char c : line) EXPECT_TRUE(c >= ' ' && c <= '~') << line;
}

TEST(ModelTable, InterpolatesBetweenWavelengthsThatHaveValuesOfTheirOwn) {
  const brdf::Model model = brdf::Model::by_name("lambertian");
  const ModelTable table(model, {0.5, 0.6}, {{0.2}, {0.4}}, "two");
  EXPECT_NEAR(m00(table, 0.525, 10, 20, 30) * optics::pi, 0.25, 1e-12);
  EXPECT_NEAR(m00(table, 0.4, 10, 20, 30) * optics::pi, 0.2, 1e-12);
  EXPECT_NEAR(m00(table, 0.9, 10, 20, 30) * optics::pi, 0.4, 1e-12);
}

TEST(ModelTable, ASingleSetOfValuesServesEveryWavelength) {
  const auto table = model_table("he-torrance", {{"sigma_um", 0.1}}, {0.5});
  EXPECT_TRUE(table.shared());
  EXPECT_NE(m00(table, 0.5, 30, 20, 0), m00(table, 0.7, 30, 20, 0));
  // Its mirror part cannot be in a table, and that is said.
  ASSERT_EQ(table.notes().size(), 1u);
  EXPECT_THAT(table.notes()[0], ::testing::HasSubstr("mirror direction"));
  EXPECT_TRUE(model_table("lambertian").notes().empty());
}

TEST(ModelTable, RefusesWavelengthsThatDoNotAscend) {
  const brdf::Model model = brdf::Model::by_name("lambertian");
  expect_refused([&] { ModelTable(model, {0.6, 0.5}, {{0.2}}, "x"); }, {"do not ascend"});
  expect_refused([&] { ModelTable(model, {0.5, 0.5}, {{0.2}}, "x"); }, {"do not ascend"});
  expect_refused(
      [&] {
        ModelTable(model, {0.5, 0.6, 0.7}, {{0.2}, {0.3}}, "x");
      },
      {"one a wavelength"});
}

}  // namespace
}  // namespace umov::formats
