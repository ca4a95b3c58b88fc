#include "host/formats/merl.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>

#include "host/formats/table_h5.hpp"
#include "table_sources.hpp"

namespace umov::formats {
namespace {

using optics::radians;
using testing::expect_refused;
using testing::m00;
using testing::satin;

constexpr HalfAngleCells small = {6, 5, 8};

std::string file_of(const HalfAngleCells& cells, const std::vector<double>& values) {
  const std::array<std::int32_t, 3> sizes = {static_cast<std::int32_t>(cells.theta_h),
                                             static_cast<std::int32_t>(cells.theta_d),
                                             static_cast<std::int32_t>(cells.phi_d)};
  std::string bytes(sizeof sizes + values.size() * sizeof(double), '\0');
  std::memcpy(bytes.data(), sizes.data(), sizeof sizes);
  std::memcpy(bytes.data() + sizeof sizes, values.data(), values.size() * sizeof(double));
  return bytes;
}

std::vector<double> random_values(std::size_t count) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-100.0, 1000.0);
  std::vector<double> values(count);
  for (double& value : values) value = uniform(generator);
  return values;
}

/// satin() in a file of the real size, made once.
const HalfAngleTable& satin_file() {
  static const auto table = parse_merl(merl_bytes(satin(), {}, merl_cells), "x", merl_cells);
  return *table;
}

TEST(HalfAngles, NameTheSameDirectionsAsTheGeometryDoes) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int i = 0; i < 1000; ++i) {
    const brdf::Geometry<double> g{1.5 * uniform(generator), 1.5 * uniform(generator),
                                   6.0 * uniform(generator) - 3.0};
    const auto back = geometry_of(half_angles(g));
    EXPECT_NEAR(back.theta_i, g.theta_i, 1e-7);
    EXPECT_NEAR(back.theta_r, g.theta_r, 1e-7);
    EXPECT_NEAR(std::remainder(back.phi_r - g.phi_r, 2 * std::numbers::pi), 0.0, 1e-6);
  }
}

TEST(HalfAngles, AreZeroTiltInTheMirrorDirectionAndZeroDifferenceTowardsTheSource) {
  const HalfAngles mirror = half_angles({0.7, 0.7, 0.0});
  EXPECT_NEAR(mirror.theta_h, 0.0, 1e-12);
  EXPECT_NEAR(mirror.theta_d, 0.7, 1e-12);
  const HalfAngles back = half_angles({0.7, 0.7, std::numbers::pi});
  EXPECT_NEAR(back.theta_h, 0.7, 1e-12);
  EXPECT_NEAR(back.theta_d, 0.0, 1e-7);
  // In the plane of incidence the source stands along the tilt of h, or against it.
  const HalfAngles forward = half_angles({0.7, 0.3, 0.0});
  EXPECT_NEAR(std::sin(forward.phi_d), 0.0, 1e-9);
  EXPECT_NEAR(forward.theta_h, 0.2, 1e-12);
  EXPECT_NEAR(forward.theta_d, 0.5, 1e-12);
}

TEST(HalfAngles, TurnByHalfACircleWhenBothBeamsChangePlaces) {
  const HalfAngles there = half_angles({0.9, 0.4, 1.1});
  const HalfAngles back = half_angles({0.4, 0.9, 1.1});
  EXPECT_NEAR(there.theta_h, back.theta_h, 1e-12);
  EXPECT_NEAR(there.theta_d, back.theta_d, 1e-12);
  // The mirror image also turns φd the other way round.
  EXPECT_NEAR(std::abs(std::sin(there.phi_d)), std::abs(std::sin(back.phi_d)), 1e-9);
}

TEST(Merl, ComesBackByteByByte) {
  const std::string bytes = file_of(small, random_values(3 * small.count()));
  const auto table = parse_merl(bytes, "x.binary", small);
  EXPECT_EQ(merl_bytes(*table, {}, small), bytes);
}

TEST(Merl, ComesBackByteByByteThroughATableFile) {
  const std::string bytes = file_of(small, random_values(3 * small.count()));
  const TablePtr stored =
      read_table_h5(write_table_h5(*parse_merl(bytes, "x.binary", small), {}), "table.h5");
  EXPECT_EQ(merl_bytes(*stored, {}, small), bytes);
}

TEST(Merl, DividesEachChannelByItsScale) {
  const auto white = testing::model_table("lambertian", {{"rho", 1.0}});
  const std::string bytes = merl_bytes(white, {}, small);
  std::vector<double> values(3 * small.count());
  ASSERT_EQ(bytes.size(), 12 + values.size() * sizeof(double));
  std::memcpy(values.data(), bytes.data() + 12, values.size() * sizeof(double));
  const double f = std::numbers::inv_pi;
  EXPECT_DOUBLE_EQ(values[0], f * 1500.0);
  EXPECT_DOUBLE_EQ(values[small.count()], f * 1500.0 / 1.15);
  EXPECT_DOUBLE_EQ(values[2 * small.count()], f * 1500.0 / 1.66);
}

TEST(Merl, HoldsANegativeNumberWhereTheWholeCellLiesBelowTheHorizon) {
  const HalfAngleTable& table = satin_file();
  std::size_t unknown = 0;
  for (std::size_t h = 0; h < 90; ++h)
    for (std::size_t d = 0; d < 90; ++d)
      for (std::size_t p = 0; p < 180; ++p) {
        const double value = table.stored()[(h * 90 + d) * 180 + p];
        const auto g = geometry_of(merl_cells.middle(h, d, p));
        const bool above = std::cos(g.theta_i) > 0 && std::cos(g.theta_r) > 0;
        ASSERT_TRUE(value >= 0.0 || !above) << h << " " << d << " " << p;
        unknown += value < 0.0 ? 1 : 0;
      }
  EXPECT_GT(unknown, 100'000u);
}

TEST(Merl, GivesASatinPaintBackWithinTheCells) {
  const auto difference = compare_tables(satin_file(), satin(), {HalfAngleTable::channel_um[1]});
  EXPECT_LT(difference.median, 3e-4);
  EXPECT_LT(difference.p95, 2e-3);
  EXPECT_LT(difference.worst, 0.03);
}

TEST(Merl, StandsForTheMiddlesOfCells) {
  const auto table = parse_merl(file_of(small, random_values(3 * small.count())), "x", small);
  for (std::size_t h = 0; h < small.theta_h; ++h)
    for (std::size_t p = 0; p < small.phi_d; ++p) {
      const double stored = table->stored()[(h * small.theta_d + 1) * small.phi_d + p];
      const auto g = geometry_of(small.middle(h, 1, p));
      if (stored < 0 || g.theta_i > 1.5 || g.theta_r > 1.5) continue;
      const double value = optics::element(table->at(HalfAngleTable::channel_um[2], g), 0, 0);
      EXPECT_NEAR(value, stored / 1500.0, 1e-9 * stored);
    }
}

TEST(Merl, LeavesUnknownCellsOut) {
  std::vector<double> values(3 * small.count(), 300.0);
  for (std::size_t i = 0; i < values.size(); i += 2) values[i] = -1.0;
  const auto table = parse_merl(file_of(small, values), "x", small);
  for (const double theta_r : {0.0, 20.0, 50.0, 80.0})
    EXPECT_NEAR(m00(*table, 0.611, 40.0, theta_r, 60.0), 0.2, 1e-12);
  const HalfAngleTable empty(small, std::vector<double>(3 * small.count(), -1.0), "x");
  EXPECT_EQ(m00(empty, 0.55, 40.0, 20.0, 60.0), 0.0);
}

TEST(Merl, TakesWavelengthsForItsChannelsInOrder) {
  const auto source = testing::model_table("he-torrance", {{"sigma_um", 0.1}});
  TableWriting writing;
  writing.wavelengths_um = {0.45, 0.55, 0.65};
  const auto table = parse_merl(merl_bytes(source, writing, small), "x", small);
  const auto g = geometry_of(small.middle(3, 1, 2));
  for (int channel = 0; channel < 3; ++channel) {
    const double expected = optics::element(
        source.at(writing.wavelengths_um[static_cast<std::size_t>(channel)], g), 0, 0);
    const double found = optics::element(
        table->at(HalfAngleTable::channel_um[static_cast<std::size_t>(channel)], g), 0, 0);
    EXPECT_NEAR(found, expected, 1e-9 * expected);
  }
  writing.wavelengths_um = {0.45, 0.55};
  expect_refused([&] { merl_bytes(source, writing, small); }, {"three channels", "2 wavelengths"});
}

TEST(Merl, IsRefusedWithTheByteWhereItIsWrong) {
  const std::string good = file_of(small, random_values(3 * small.count()));
  const auto parse = [](const std::string& bytes) { parse_merl(bytes, "x.binary", small); };
  expect_refused([&] { parse(good.substr(0, 6)); }, {"x.binary", "byte 6"});
  std::string sizes = good;
  sizes[4] = 7;
  expect_refused([&] { parse(sizes); }, {"byte 4", "7, not 5"});
  expect_refused([&] { parse(good.substr(0, 100)); }, {"cut off at byte 100"});
  expect_refused([&] { parse(good + "x"); }, {"goes on at byte"});
  std::string nan = good;
  const double bad = std::numeric_limits<double>::quiet_NaN();
  std::memcpy(nan.data() + 12 + 5 * sizeof bad, &bad, sizeof bad);
  expect_refused([&] { parse(nan); }, {"byte 52", "not a finite number"});
}

TEST(Merl, WithoutAKnownValueOrWithAbsurdOnesIsRefused) {
  const auto parse = [](const std::vector<double>& values) {
    parse_merl(file_of(small, values), "x.binary", small);
  };
  expect_refused([&] { parse(std::vector<double>(3 * small.count(), -1.0)); },
                 {"x.binary", "no value is known", "red"});
  std::vector<double> values = random_values(3 * small.count());
  std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(small.count()), small.count(), -1.0);
  expect_refused([&] { parse(values); }, {"no value is known", "green"});
  values = random_values(3 * small.count());
  values[7] = 1e300;
  expect_refused([&] { parse(values); }, {"byte 68", "1e+300 is no BRDF"});
}

TEST(Merl, IsToldByItsSizes) {
  EXPECT_FALSE(looks_like_merl(file_of(small, random_values(3 * small.count()))));
  EXPECT_TRUE(looks_like_merl(file_of(merl_cells, {1.0, 2.0})));
  EXPECT_FALSE(looks_like_merl("short"));
}

}  // namespace
}  // namespace umov::formats
