#include "host/formats/rgl_tensor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>

#include "host/formats/table_h5.hpp"
#include "host/formats/tensor_file.hpp"
#include "table_sources.hpp"

namespace umov::formats {
namespace {

using std::numbers::pi;
using testing::expect_refused;
using testing::m00;
using testing::satin;

/// A small file with random positive numbers everywhere.
RglData random_data(std::size_t wavelengths = 2) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<float> uniform(0.1f, 2.0f);
  const auto fill = [&](std::vector<float>& values, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) values.push_back(uniform(generator));
  };
  RglData d;
  d.description = "random";
  d.phi_i = {0.0f};
  d.theta_i = {0.0f, 0.5f, 1.2f};
  for (std::size_t i = 0; i < wavelengths; ++i)
    d.wavelengths_nm.push_back(500.0f + 100.0f * static_cast<float>(i));
  d.ndf_rows = 2, d.ndf_columns = 5;
  fill(d.ndf, 10);
  d.sigma_rows = 2, d.sigma_columns = 4;
  fill(d.sigma, 8);
  d.vndf_rows = 5, d.vndf_columns = 6;
  fill(d.vndf, 3 * 30);
  d.resolution = 4;
  fill(d.luminance, 3 * 16);
  fill(d.spectra, 3 * d.channels() * 16);
  d.valid.assign(6, 0xff);
  return d;
}

double bilinear(const float* grid, std::size_t rows, std::size_t columns, double x, double y) {
  x *= static_cast<double>(columns - 1);
  y *= static_cast<double>(rows - 1);
  const auto c = std::min(static_cast<std::size_t>(x), columns - 2);
  const auto r = std::min(static_cast<std::size_t>(y), rows - 2);
  const double fx = x - static_cast<double>(c), fy = y - static_cast<double>(r);
  const auto at = [&](std::size_t i, std::size_t j) { return double{grid[i * columns + j]}; };
  return (1 - fy) * ((1 - fx) * at(r, c) + fx * at(r, c + 1)) +
         fy * ((1 - fx) * at(r + 1, c) + fx * at(r + 1, c + 1));
}

/// The definition of the parameterisation, by brute-force integration of the density: half vector
/// to u, u to s through the cumulative distributions, spectra at s times ndf over 4 sigma.
double by_definition(const RglData& d, std::size_t incidence, std::size_t channel, double theta_r,
                     double phi_r) {
  const double theta_i = double{d.theta_i[incidence]};
  const double mx = std::sin(theta_i) + std::sin(theta_r) * std::cos(pi + phi_r);
  const double my = std::sin(theta_r) * std::sin(pi + phi_r);
  const double mz = std::cos(theta_i) + std::cos(theta_r);
  const double ux = std::sqrt(std::acos(mz / std::hypot(mx, my, mz)) * 2 / pi);
  const double uy = (std::atan2(my, mx) + pi) / (2 * pi);
  const float* density = d.vndf.data() + incidence * d.vndf_rows * d.vndf_columns;
  const auto p = [&](double x, double y) {
    return bilinear(density, d.vndf_rows, d.vndf_columns, x, y);
  };
  constexpr int steps = 2000;
  const auto integral = [](double to, auto f) {
    double sum = 0;
    for (int k = 0; k < steps; ++k) sum += f((k + 0.5) * to / steps);
    return sum * to / steps;
  };
  const auto row = [&](double y) {
    // The density is linear in y within a row of cells: sums over a fine grid suffice.
    double sum = 0;
    for (std::size_t c = 0; c < d.vndf_columns; ++c)
      sum += (c == 0 || c + 1 == d.vndf_columns ? 0.5 : 1.0) *
             p(static_cast<double>(c) / static_cast<double>(d.vndf_columns - 1), y);
    return sum / static_cast<double>(d.vndf_columns - 1);
  };
  const double sx = integral(ux, [&](double x) { return p(x, uy); }) / row(uy);
  const double sy = integral(uy, row) / integral(1.0, row);
  const std::size_t image = d.resolution * d.resolution;
  const float* spectra = d.spectra.data() + (incidence * d.channels() + channel) * image;
  const double value = bilinear(spectra, d.resolution, d.resolution, sx, sy);
  const double ndf = bilinear(d.ndf.data(), d.ndf_rows, d.ndf_columns, ux, uy);
  const double sigma =
      bilinear(d.sigma.data(), d.sigma_rows, d.sigma_columns, std::sqrt(theta_i * 2 / pi), 0.5);
  return value * ndf / (4 * sigma) / std::cos(theta_r);
}

TEST(Rgl, EvaluatesAsThePublishedDefinitionSays) {
  const RglData d = random_data();
  const RglTable table(d, "x");
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int k = 0; k < 60; ++k) {
    const std::size_t incidence = static_cast<std::size_t>(k) % 3;
    const double theta_r = 1.4 * uniform(generator), phi_r = pi * (2 * uniform(generator) - 1);
    const std::size_t channel = static_cast<std::size_t>(k) % 2;
    const double expected = by_definition(d, incidence, channel, theta_r, phi_r);
    const double found = optics::element(
        table.at(table.wavelengths_um()[channel], {double{d.theta_i[incidence]}, theta_r, phi_r}),
        0, 0);
    EXPECT_NEAR(found, expected, 1e-5 * expected);
  }
}

TEST(Rgl, UnwarpingUndoesTheWarp) {
  // Where spectra are s.x and s.y themselves, the table tells where u went.
  RglData d = random_data(2);
  d.jacobian = false;
  for (std::size_t slice = 0; slice < 3; ++slice)
    for (std::size_t i = 0; i < 16; ++i) {
      d.spectra[(slice * 2 + 0) * 16 + i] = static_cast<float>(i % 4) / 3.0f;
      d.spectra[(slice * 2 + 1) * 16 + i] = static_cast<float>(i / 4) / 3.0f;
    }
  const RglTable table(d, "x");
  for (const double x : {0.1, 0.35, 0.6})
    for (const double y : {0.05, 0.3, 0.5, 0.93}) {
      const auto u = table.unwarped(1, {x, y});
      const double theta_m = 0.5 * pi * u.x * u.x, phi_m = (2 * u.y - 1) * pi;
      const double theta_i = double{d.theta_i[1]};
      const double mx = std::sin(theta_m) * std::cos(phi_m),
                   my = std::sin(theta_m) * std::sin(phi_m);
      const double along = mx * std::sin(theta_i) + std::cos(theta_m) * std::cos(theta_i);
      const double ox = 2 * along * mx - std::sin(theta_i), oy = 2 * along * my;
      const double oz = 2 * along * std::cos(theta_m) - std::cos(theta_i);
      if (oz < 0.1) continue;
      const brdf::Geometry<double> g{theta_i, std::acos(oz), std::atan2(-oy, -ox)};
      EXPECT_NEAR(optics::element(table.at(0.5, g), 0, 0) * oz, x, 1e-6);
      EXPECT_NEAR(optics::element(table.at(0.6, g), 0, 0) * oz, y, 1e-6);
    }
}

TEST(Rgl, GivesASatinPaintBackWithinHalfAPercent) {
  const auto source = satin();
  const TablePtr table = read_rgl(write_rgl(source, {}), "x.bsdf");
  const auto difference = compare_tables(*table, source, {0.55});
  EXPECT_LT(difference.median, 1e-3);
  EXPECT_LT(difference.p95, 5e-3);
}

TEST(Rgl, GivesAMirrorLikeGlossBack) {
  const auto source = testing::model_table("microfacet", {{"slope_rms", 0.02}});
  const TablePtr table = read_rgl(write_rgl(source, {}), "x.bsdf");
  for (const double theta_i : {0.0, 22.0, 47.0, 71.0})
    for (const double off : {0.0, 0.5, 2.0}) {
      const double expected = m00(source, 0.55, theta_i, theta_i - off, 0);
      EXPECT_NEAR(m00(*table, 0.55, theta_i, theta_i - off, 0), expected, 0.01 * expected)
          << theta_i << " " << off;
    }
}

TEST(Rgl, SaysInItsDescriptionWhatTheNumbersAre) {
  const auto table = std::dynamic_pointer_cast<const RglTable>(
      read_rgl(write_rgl(testing::model_table("lambertian"), {}), "x.bsdf"));
  for (const char* part :
       {"times cos theta_r", "azimuth: ", "550 nm", "polarisation: ", "differs from its source by"})
    EXPECT_THAT(table->data().description, ::testing::HasSubstr(part));
}

TEST(Rgl, ComesBackByteByByte) {
  for (const std::size_t wavelengths : {1u, 4u}) {
    const std::string bytes = rgl_bytes(random_data(wavelengths));
    const TablePtr table = read_rgl(bytes, "x.bsdf");
    EXPECT_EQ(write_rgl(*table, {}), bytes);
    EXPECT_EQ(write_rgl(*read_table_h5(write_table_h5(*table, {}), "t.h5"), {}), bytes);
  }
}

TEST(Rgl, ReadsColourChannelsAtTheirNominalWavelengths) {
  RglData d = random_data();
  d.wavelengths_nm.clear();
  d.spectra.resize(3 * 3 * 16, 1.0f);
  for (std::size_t slice = 0; slice < 3; ++slice)
    for (std::size_t i = 0; i < 48; ++i)
      d.spectra[slice * 48 + i] = static_cast<float>(1 + i / 16);  // red 1, green 2, blue 3
  const TablePtr table = read_rgl(rgl_bytes(d), "x.bsdf");
  ASSERT_EQ(table->wavelengths_um().size(), 3u);
  const double blue = m00(*table, table->wavelengths_um()[0], 20, 30, 40);
  EXPECT_NEAR(m00(*table, table->wavelengths_um()[1], 20, 30, 40), blue * 2 / 3, 1e-9 * blue);
  EXPECT_NEAR(m00(*table, table->wavelengths_um()[2], 20, 30, 40), blue / 3, 1e-9 * blue);
}

TEST(Rgl, KeepsWavelengthsToTheDigit) {
  const TablePtr table =
      read_rgl(write_rgl(testing::model_table("lambertian", {}, {0.5328, 0.6328}), {}), "x");
  EXPECT_DOUBLE_EQ(table->wavelengths_um()[0], 0.5328);
  EXPECT_DOUBLE_EQ(table->wavelengths_um()[1], 0.6328);
}

TEST(Rgl, IsRefusedWithTheByteWhereItIsWrong) {
  const auto refuse = [](const RglData& d, const std::vector<std::string>& says) {
    expect_refused([&] { read_rgl(rgl_bytes(d), "x.bsdf"); }, says);
  };
  const std::string good = rgl_bytes(random_data());
  const auto vndf_offset = [&] {
    for (const TensorField& field : parse_tensor_file(good, "x"))
      if (field.name == "vndf") return field.offset;
    return std::size_t{0};
  }();
  RglData d = random_data();
  d.vndf[7] = std::numeric_limits<float>::quiet_NaN();
  refuse(d, {"x.bsdf", "byte " + std::to_string(vndf_offset + 28), "`vndf`", "not a finite"});
  d = random_data();
  d.vndf[7] = -1.0f;
  refuse(d, {"`vndf`, entry 7", "negative"});
  d = random_data();
  std::fill(d.vndf.begin() + 30, d.vndf.begin() + 60, 0.0f);
  refuse(d, {"slice 2 is 0 throughout"});
  d = random_data();
  d.theta_i[2] = 0.4f;
  refuse(d, {"`theta_i`, entry 2", "does not rise"});
  d = random_data();
  d.theta_i[2] = 2.0f;
  refuse(d, {"`theta_i`, entry 2", "out of the range"});
  d = random_data();
  d.phi_i = {0.0f, 1.0f, 2.0f};
  for (int copy = 0; copy < 2; ++copy) {
    const RglData one = random_data();
    d.vndf.insert(d.vndf.end(), one.vndf.begin(), one.vndf.end());
    d.luminance.insert(d.luminance.end(), one.luminance.begin(), one.luminance.end());
    d.spectra.insert(d.spectra.end(), one.spectra.begin(), one.spectra.end());
  }
  refuse(d, {"3 azimuths of incidence", "anisotropic"});
  expect_refused([&] { read_rgl(good.substr(0, good.size() - 4), "x"); },
                 {"byte", "beyond the end"});
  expect_refused([&] { read_rgl(good.substr(0, 40), "x"); }, {"ends at byte 40"});
  expect_refused([&] { read_rgl(good + "junk", "x"); },
                 {"byte " + std::to_string(good.size()), "4 bytes follow the last field"});
  expect_refused([&] { read_rgl(good + std::string(8, '\0'), "x"); }, {"follow the last field"});
  EXPECT_NO_THROW(read_rgl(good + std::string(7, '\0'), "x")) << "filled up to the alignment";
}

TEST(TensorFile, ClaimsNoMoreThanTheFileHolds) {
  const std::string good = rgl_bytes(random_data());
  // The first field is `description`; its one length stands behind name, dimensions, type, offset.
  const std::size_t shape = 12 + 2 + 4 + 2 + 11 + 2 + 1 + 8;
  for (const std::uint64_t length :
       {std::uint64_t{1} << 40, ~std::uint64_t{0}, std::uint64_t{99999}}) {
    std::string bytes = good;
    std::memcpy(bytes.data() + shape, &length, sizeof length);
    expect_refused([&] { parse_tensor_file(bytes, "x"); }, {"byte 18", "field 1"});
  }
  std::string version = good;
  version[12] = 2;
  expect_refused([&] { parse_tensor_file(version, "x"); }, {"version 2.0"});
  std::string type = good;
  type[12 + 2 + 4 + 2 + 11 + 2] = 12;
  expect_refused([&] { parse_tensor_file(type, "x"); }, {"unknown type 12"});
}

}  // namespace
}  // namespace umov::formats
