#include "host/formats/mueller_columns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

#include "host/errors/error.hpp"
#include "host/formats/brdf_csv.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/mueller_table.hpp"
#include "host/formats/nist_ptfe.hpp"

namespace umov::formats {
namespace {

using ::testing::HasSubstr;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
const std::string path = std::string(UMOV_TEST_DATA) + "/nist_ptfe/ptfe_532_633.csv";

BrdfTable linear_table() {
  BrdfTable table;
  BrdfTable::Mueller m;
  for (std::size_t n = 0; n < 3; ++n) {
    const double at = static_cast<double>(n);
    m.theta_i_deg.push_back(10 * at);
    m.theta_r_deg.push_back(5);
    m.phi_r_deg.push_back(30);
    m.wavelength_nm.push_back(532);
    for (std::size_t k = 0; k < 9; ++k) {
      m.mueller.push_back(n == 2 && k == 8 ? nan : at + 0.1 * static_cast<double>(k));
      m.mueller_u.push_back(n == 2 && k == 8 ? nan : 0.01);
    }
    for (std::size_t k = 0; k < 45; ++k) m.covariance.push_back(1e-4 * static_cast<double>(k));
    m.condition.push_back(3);
    m.chi2.push_back(4);
    m.dof.push_back(3);
    m.realisable_z.push_back(n == 2 ? nan : 1.5);
  }
  table.mueller = m;
  return table;
}

BrdfTable through_file(const BrdfTable& table) {
  const auto file = std::filesystem::temp_directory_path() / "umov_mueller_round_trip.h5";
  write_brdf_h5(file, table, {});
  BrdfTable again = read_brdf_h5(file).table;
  std::filesystem::remove(file);
  return again;
}

void expect_same(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!std::isnan(a[i]) || !std::isnan(b[i])) {
      EXPECT_EQ(a[i], b[i]) << i;
    }
}

TEST(MuellerColumns, SurviveBrdfH5WithTheirGaps) {
  const BrdfTable table = linear_table(), again = through_file(table);
  ASSERT_TRUE(again.mueller);
  EXPECT_EQ(again.mueller->side, 3);
  for_each_mueller_column(*table.mueller, [&](const MuellerColumn& column, const auto& values) {
    for_each_mueller_column(*again.mueller, [&](const MuellerColumn& other, const auto& read) {
      if (column.path() == other.path()) expect_same(values, read);
    });
  });
  EXPECT_EQ(content_sha256(table), content_sha256(again));
  EXPECT_FALSE(through_file(BrdfTable{}).mueller);
}

TEST(MuellerColumns, CovarianceIsPackedBySymmetry) {
  const BrdfTable table = linear_table();
  const auto& m = *table.mueller;
  EXPECT_EQ(m.covariance_at(0, 0, 0), 0u);
  EXPECT_EQ(m.covariance_at(0, 0, 8), 8u);
  EXPECT_EQ(m.covariance_at(0, 1, 1), 9u);
  EXPECT_EQ(m.covariance_at(0, 8, 8), 44u);
  EXPECT_EQ(m.covariance_at(1, 5, 2), m.covariance_at(1, 2, 5));
  EXPECT_EQ(m.covariance_at(1, 0, 0), 45u);
}

TEST(MuellerColumns, OfWrongLengthOrWithANumberThatIsNoneAreRefused) {
  const auto refusal = [](auto&& change) -> std::string {
    BrdfTable table = linear_table();
    change(*table.mueller);
    try {
      write_brdf_h5("/nonexistent/x.h5", table, {});
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_THAT(refusal([](auto& m) { m.mueller.pop_back(); }), HasSubstr("/mueller/mueller"));
  EXPECT_THAT(refusal([](auto& m) { m.chi2[1] = nan; }), HasSubstr("/mueller/chi2"));
  EXPECT_THAT(refusal([](auto& m) { m.covariance.pop_back(); }), HasSubstr("/mueller/covariance"));
  EXPECT_THAT(refusal([](auto& m) { m.side = 5; }), HasSubstr("neither 3 x 3 nor 4 x 4"));
}

TEST(MuellerColumns, AreWrittenAsCsv) {
  const std::string text = mueller_csv_text(linear_table());
  EXPECT_THAT(text, HasSubstr("theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,m00,m01,m02,m10"));
  EXPECT_THAT(text, HasSubstr("\n10,5,30,532,1,1.1,"));
  EXPECT_THAT(brdf_csv_text(linear_table()), HasSubstr("\nm01,532,10,5,30,,,1.1,0.01,1\n"));
  EXPECT_THROW(mueller_csv_text(BrdfTable{}), Error);
}

TEST(ImportedMatrices, AreKeptWhole) {
  const MuellerTable ptfe = read_nist_ptfe(path);
  const BrdfTable again = through_file(independent_channels(ptfe));
  ASSERT_TRUE(again.mueller);
  EXPECT_EQ(again.mueller->side, 4);
  ASSERT_EQ(again.mueller->size(), ptfe.size());
  const MuellerTable back = mueller_table(again);
  std::size_t unphysical = 0;
  for (std::size_t n = 0; n < ptfe.size(); ++n) {
    EXPECT_EQ(back.mueller[n], ptfe.mueller[n]);
    EXPECT_NEAR(back.m00_relative_u[n], ptfe.m00_relative_u[n], 1e-12);
    EXPECT_NEAR(back.element_relative_u[n], ptfe.element_relative_u[n], 1e-9);
    unphysical += again.mueller->realisable_z[n] < -3 ? 1 : 0;
  }
  EXPECT_EQ(unphysical, 0u) << "PTFE depolarises: far inside of what light can have";
}

TEST(ImportedMatrices, CountAsManyChannelsAsTheyHaveElements) {
  const MuellerTable ptfe = read_nist_ptfe(path);
  const BrdfTable brdf = independent_channels(ptfe);
  ASSERT_EQ(brdf.points.size(), 4 * ptfe.size());
  EXPECT_TRUE(brdf.factors.empty());
  for (std::size_t n : {0UL, 1000UL, 3000UL}) {
    // ½ times a Hadamard matrix: its transpose solves the four channels for the four elements, and
    // equal independent uncertainties stay what they are.
    const std::array<std::size_t, 4> places = {0, 1, 4, 5};
    std::array<double, 4> element{}, variance{};
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t at = 4 * n + i;
      const double in = brdf.points.polarizer_deg[at] == 0 ? -1 : 1;
      const double out = brdf.points.analyzer_deg[at] == 0 ? -1 : 1;
      const std::array<double, 4> row = {0.5, 0.5 * in, 0.5 * out, 0.5 * in * out};
      for (std::size_t k = 0; k < 4; ++k) {
        element[k] += row[k] * brdf.points.brdf_per_sr[at];
        variance[k] += std::pow(row[k] * brdf.points.brdf_u[at], 2);
      }
    }
    const double larger =
        ptfe.mueller[n][0] * std::max(ptfe.m00_relative_u[n], ptfe.element_relative_u[n]);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_NEAR(element[k], ptfe.mueller[n][places[k]], 1e-12);
      EXPECT_NEAR(std::sqrt(variance[k]), larger, 1e-12);
    }
  }
}

}  // namespace
}  // namespace umov::formats
