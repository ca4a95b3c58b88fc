#include "host/optics/refractive_index.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "host/errors/error.hpp"

namespace umov::optics {
namespace {

using ::testing::HasSubstr;

std::string message(const std::string& text) {
  try {
    IndexTable::from_text(text, "glass.yml");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(RefractiveIndex, EmbeddedTablesHaveTheKnownValuesAtSodiumLight) {
  struct Known {
    const char* name;
    double n, kappa, n_within;
  };
  for (const Known& known : {Known{"H2O_Daimon-20.0C", 1.333, 0.0, 1e-3},
                             {"N-BK7_Schott", 1.5167, 0.0, 1e-4},
                             {"SiO2_Malitson", 1.4584, 0.0, 1e-4},
                             {"Ge_Jellison", 5.787, 1.570, 0.01},
                             {"Al_Rakic", 1.207, 7.068, 0.01},
                             {"Al_Cheng", 0.698, 5.655, 0.01},
                             {"PMMA_Sultanova", 1.4906, 0.0, 1e-3},
                             {"TiO2_Devore-o", 2.613, 0.0, 2e-3}}) {
    const IndexTable table = IndexTable::embedded(known.name);
    EXPECT_NEAR(table.n(0.589), known.n, known.n_within) << known.name;
    EXPECT_NEAR(table.kappa(0.589), known.kappa, 0.01) << known.name;
  }
}

TEST(RefractiveIndex, AllEmbeddedTablesParseAndCoverPartOfTheVisible) {
  const auto names = IndexTable::embedded_names();
  EXPECT_GE(names.size(), 12u);
  for (const std::string& name : names) {
    const IndexTable table = IndexTable::embedded(name);
    EXPECT_LT(table.min_wavelength_um(), 0.532) << name;
    EXPECT_GT(table.max_wavelength_um(), 0.814) << name;
    EXPECT_GT(table.n(0.633), 0.0) << name;
    EXPECT_GE(table.kappa(0.633), 0.0) << name;
  }
}

TEST(RefractiveIndex, EmbeddedTextIsTheShippedFile) {
  const IndexTable file =
      IndexTable::from_file(UMOV_SOURCE_DIR "/data/optical_constants/Ge_Jellison.yml");
  const IndexTable embedded = IndexTable::embedded("Ge_Jellison");
  for (const double wavelength : {0.3, 0.532, 0.633, 0.814}) {
    EXPECT_EQ(file.n(wavelength), embedded.n(wavelength));
    EXPECT_EQ(file.kappa(wavelength), embedded.kappa(wavelength));
  }
}

TEST(RefractiveIndex, TablesAreInterpolatedLinearlyAndExactAtTheirRows) {
  const IndexTable table = IndexTable::from_text(
      "DATA:\n  - type: tabulated nk\n    data: |\n        0.5 1.0 0.0\n        0.6 2.0 1.0\n      "
      "  0.8 1.0 3.0\n",
      "x");
  EXPECT_DOUBLE_EQ(table.n(0.6), 2.0);
  EXPECT_DOUBLE_EQ(table.n(0.7), 1.5);
  EXPECT_DOUBLE_EQ(table.kappa(0.7), 2.0);
  EXPECT_DOUBLE_EQ(table.n(0.5), 1.0);
  EXPECT_DOUBLE_EQ(table.n(0.8), 1.0);
}

TEST(RefractiveIndex, FormulasEvaluateAsWritten) {
  const auto n = [](const std::string& formula, const std::string& coefficients) {
    return IndexTable::from_text(
               "DATA:\n  - type: " + formula +
                   "\n    wavelength_range: 0.2 3\n    coefficients: " + coefficients + "\n",
               "x")
        .n(0.5);
  };
  EXPECT_NEAR(n("formula 1", "0 1.25 0.1"), std::sqrt(1.0 + 1.25 * 0.25 / (0.25 - 0.01)), 1e-14);
  EXPECT_NEAR(n("formula 2", "0 1.25 0.01"), std::sqrt(1.0 + 1.25 * 0.25 / (0.25 - 0.01)), 1e-14);
  EXPECT_NEAR(n("formula 3", "2.25 0.01 -2"), std::sqrt(2.25 + 0.01 / 0.25), 1e-14);
  EXPECT_NEAR(n("formula 4", "2.25 0.1 0 0.01 1 0 0 0 0"), std::sqrt(2.25 + 0.1 / (0.25 - 0.01)),
              1e-14);
  EXPECT_NEAR(n("formula 5", "1.5 0.004 -2"), 1.5 + 0.004 / 0.25, 1e-14);
  EXPECT_NEAR(n("formula 6", "0 0.05 200"), 1.0 + 0.05 / (200.0 - 4.0), 1e-14);
}

TEST(RefractiveIndex, RefusesWavelengthsOutsideTheData) {
  const IndexTable table = IndexTable::embedded("Ge_Jellison");
  EXPECT_THROW(table.n(0.9), Error);
  EXPECT_THROW(table.kappa(0.2), Error);
  EXPECT_THROW(table.n(std::nan("")), Error);
}

TEST(RefractiveIndex, RefusesBadTextWithItsLine) {
  const std::string head = "DATA:\n  - type: tabulated nk\n    data: |\n";
  EXPECT_THAT(message(head + "        0.5 1.0 zero\n"), HasSubstr("glass.yml:4"));
  EXPECT_THAT(message(head + "        0.5 1.0\n"), HasSubstr("2 numbers"));
  EXPECT_THAT(message(head + "        0.5 1.0 0\n        0.4 1.0 0\n"), HasSubstr("glass.yml:5"));
  EXPECT_THAT(message("DATA:\n  - type: formula 9\n"), HasSubstr("formula 9"));
  EXPECT_THAT(message("nothing: here\n"), HasSubstr("no refractive index"));
  EXPECT_THAT(message(head), HasSubstr("no refractive index"));
}

TEST(RefractiveIndex, UnknownNamesAreAnsweredWithTheList) {
  try {
    IndexTable::embedded("unobtainium");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("Ge_Jellison"));
  }
  EXPECT_THROW(IndexTable::from_file("/nonexistent/table.yml"), Error);
}

}  // namespace
}  // namespace umov::optics
