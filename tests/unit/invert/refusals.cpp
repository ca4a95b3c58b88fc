// Every refusal says what is wrong and what to do.
#include <gtest/gtest.h>

#include "host/errors/error.hpp"
#include "host/invert/invert.hpp"
#include "host/invert/prediction.hpp"
#include "tests/unit/invert/synthetic_measurement.hpp"

namespace umov::invert {
namespace {

test::Made small() {
  return test::make(test::black_paint(), 1);
}

std::string refusal(const formats::BrdfTable& table, const Options& options) {
  try {
    invert(table, options);
  } catch (const Error& error) {
    EXPECT_FALSE(error.remedy().empty());
    return error.what();
  }
  return "";
}

Options options_for(const char* model) {
  Options options;
  options.model = model;
  return options;
}

TEST(InversionRefuses, ATableWithoutUsedPoints) {
  auto made = small();
  std::fill(made.table.points.used.begin(), made.table.points.used.end(), 0);
  EXPECT_NE(refusal(made.table, options_for("nef")).find("no point"), std::string::npos);
  EXPECT_NE(refusal({}, options_for("nef")).find("no points"), std::string::npos);
}

TEST(InversionRefuses, AnUnknownModelOrParameter) {
  const auto made = small();
  EXPECT_NE(refusal(made.table, options_for("velvet")).find("velvet"), std::string::npos);
  Options options = options_for("nef");
  options.fix = {{"sigma_um", std::nullopt, 1}};
  const std::string text = refusal(made.table, options);
  EXPECT_NE(text.find("no parameter \"sigma_um\""), std::string::npos);
  EXPECT_NE(text.find("rho_d1"), std::string::npos) << "it lists what exists";
}

TEST(InversionRefuses, AnUncertaintyThatIsNotPositive) {
  auto made = small();
  made.table.points.brdf_u[17] = 0;
  const std::string text = refusal(made.table, options_for("nef"));
  EXPECT_NE(text.find("17"), std::string::npos);
  EXPECT_NE(text.find("brdf_u"), std::string::npos);
}

TEST(InversionRefuses, ContradictingSettings) {
  const auto made = small();
  Options options = options_for("nef");
  options.share = {"rho_d1"};
  options.spectral = {"rho_d1"};
  EXPECT_NE(refusal(made.table, options).find("both"), std::string::npos);
  options = options_for("nef");
  options.start = {{"rho_d1", std::nullopt, -1}};
  EXPECT_NE(refusal(made.table, options).find("outside"), std::string::npos);
  options = options_for("nef");
  options.bound = {{"rho_d1", std::nullopt, 1, 0}};
  EXPECT_NE(refusal(made.table, options).find("bounds"), std::string::npos);
  options = options_for("nef");
  options.fix = {{"rho_d1", 700, 0.1}};
  EXPECT_NE(refusal(made.table, options).find("700 nm"), std::string::npos);
  options = options_for("microfacet");
  options.fix = {{"n", 532, 1.5}};
  EXPECT_NE(refusal(made.table, options).find("shared"), std::string::npos);
}

TEST(InversionRefuses, MoreParametersThanPointsAndNoParameterAtAll) {
  auto made = small();
  Options options = options_for("nef");
  options.fix = {{"rho_d1", std::nullopt, 0.1}, {"rho_d2", std::nullopt, 0.1}};
  EXPECT_NE(refusal(made.table, options).find("fixed"), std::string::npos);
  auto& used = made.table.points.used;
  std::fill(used.begin() + 3, used.end(), 0);
  EXPECT_NE(refusal(made.table, options_for("microfacet+nef")).find("3 used points"),
            std::string::npos);
}

TEST(InversionRefuses, ToPredictAWavelengthThatWasNotFitted) {
  const auto made = small();
  Options options = options_for("nef");
  options.dhr = options.held_out = false;
  const auto fit = invert(made.table, options);
  try {
    hemisphere(fit, 700, 30);
    FAIL() << "700 nm was not measured";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("532"), std::string::npos);
  }
  EXPECT_THROW(hemisphere(fit, 532, 95), Error);
}

}  // namespace
}  // namespace umov::invert
