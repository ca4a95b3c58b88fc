#include "host/brdf/model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "host/errors/error.hpp"
#include "tests/unit/failure.hpp"

namespace umov::brdf {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> parameter_names(const Model& model) {
  std::vector<std::string> names;
  for (const Parameter& p : model.parameters()) names.push_back(p.name);
  return names;
}

TEST(Model, EveryModelHasSensibleParameters) {
  for (const std::string& name : Model::names()) {
    const Model model = Model::by_name(name);
    EXPECT_EQ(model.name(), name);
    EXPECT_FALSE(Model::description(name).empty());
    EXPECT_FALSE(model.parameters().empty() && model.table_slots().empty());
    for (const Parameter& p : model.parameters()) {
      EXPECT_LE(p.min, p.initial) << name << " " << p.name;
      EXPECT_LE(p.initial, p.max) << name << " " << p.name;
      EXPECT_LT(p.min, p.max) << name << " " << p.name;
      EXPECT_FALSE(p.unit.empty() || p.meaning.empty() || p.source.empty())
          << name << " " << p.name;
    }
    EXPECT_NO_THROW(model.check(model.initial_values()));
  }
}

TEST(Model, ParametersHaveTheirContractNames) {
  EXPECT_THAT(parameter_names(Model::by_name("nef")), ElementsAre("rho_d1", "rho_d2"));
  EXPECT_THAT(parameter_names(Model::by_name("microfacet")),
              ElementsAre("n", "kappa", "slope_rms", "bias"));
  EXPECT_THAT(parameter_names(Model::by_name("microfacet:shadowing=maxwell-beard")),
              ElementsAre("n", "kappa", "slope_rms", "bias", "omega", "tau"));
  EXPECT_THAT(parameter_names(Model::by_name("li-torrance")),
              ElementsAre("n", "kappa", "sigma_um", "tau_um", "k_dd", "k_udf", "k_uds", "k_fs",
                          "fs_width_deg", "fs_polarization"));
}

TEST(Model, NewModelsHaveTheirContractNamesToo) {
  EXPECT_THAT(parameter_names(Model::by_name("rayleigh-rice")),
              ElementsAre("n", "kappa", "sigma_um", "correlation_um"));
  EXPECT_THAT(parameter_names(Model::by_name("rayleigh-rice:psd=abc")),
              ElementsAre("n", "kappa", "abc_a", "abc_b", "abc_c"));
  EXPECT_THAT(parameter_names(Model::by_name("beard-maxwell")),
              ElementsAre("n", "kappa", "slope_rms", "bias", "omega", "tau", "rho_d", "rho_v"));
  EXPECT_THAT(parameter_names(Model::by_name("beard-maxwell:shadowing=smith")),
              ElementsAre("n", "kappa", "slope_rms", "bias", "rho_d", "rho_v"));
  EXPECT_TRUE(parameter_names(Model::by_name("tabulated")).empty());
}

TEST(Model, NamesThatUsersBringLeadToTheModelTheyMean) {
  for (const Alias& alias : Model::aliases()) {
    EXPECT_EQ(Model::by_name(alias.name).name(), Model::by_name(alias.model).name());
    EXPECT_FALSE(alias.meaning.empty());
    for (const std::string& name : Model::names()) EXPECT_NE(alias.name, name);
  }
  EXPECT_EQ(Model::by_name("torrance-sparrow:slopes=exponential+nef").name(),
            "microfacet:shadowing=vgroove,slopes=exponential+nef");
}

TEST(Model, EveryModelSaysWhereItsFormulaIsAndWhatItsLimitsAre) {
  for (const std::string& name : Model::names()) {
    EXPECT_FALSE(Model::formula(name).empty()) << name;
    EXPECT_FALSE(Model::remarks(name).empty()) << name;
  }
}

TEST(Model, SumsPrefixParametersByPosition) {
  const Model model = Model::by_name("microfacet+microfacet:shadowing=vgroove+nef");
  EXPECT_EQ(model.parameters().size(), 10u);
  EXPECT_EQ(model.index_of("1.n"), 4u);
  EXPECT_EQ(model.index_of("2.rho_d2"), 9u);
  EXPECT_EQ(model.name(), "microfacet+microfacet:shadowing=vgroove+nef");
}

TEST(Model, ChoicesCanBeMadeInTheNameOrLater) {
  const Model named = Model::by_name("microfacet:slopes=exponential,shadowing=maxwell-beard");
  const Model later = Model::by_name("microfacet")
                          .with_choice("shadowing", "maxwell-beard")
                          .with_choice("slopes", "exponential");
  EXPECT_EQ(named.name(), later.name());
  EXPECT_EQ(Model::by_name(named.name()).name(), named.name());
  const Model sum = Model::by_name("nef+microfacet").with_choice("1.shadowing", "none");
  EXPECT_EQ(sum.name(), "nef+microfacet:shadowing=none");
  EXPECT_EQ(Model::by_name("microfacet:shadowing=smith").name(), "microfacet");
}

TEST(Model, UnknownNamesAreAnsweredWithWhatExists) {
  EXPECT_THAT(failure_of([] { Model::by_name("oren-nayar"); }), HasSubstr("he-torrance"));
  EXPECT_THAT(failure_of([] { Model::by_name("nef+"); }), HasSubstr("no model ''"));
  EXPECT_THAT(failure_of([] { Model::by_name("nef").index_of("rho"); }),
              HasSubstr("rho_d1, rho_d2"));
  EXPECT_THAT(failure_of([] { Model::by_name("microfacet:shadowing=deep"); }),
              HasSubstr("vgroove"));
  EXPECT_THAT(failure_of([] { Model::by_name("microfacet:shadowing"); }), HasSubstr("vgroove"));
  EXPECT_THAT(failure_of([] { Model::by_name("ggx:shadowing=maxwell-beard"); }),
              HasSubstr("smith"));
  EXPECT_THAT(failure_of([] { Model::by_name("microfacet+nef").with_choice("shadowing", "none"); }),
              HasSubstr("0.shadowing"));
}

TEST(Model, ValuesOutsideTheirRangeAreRefusedWithTheRange) {
  const Model model = Model::by_name("lambertian");
  EXPECT_THAT(failure_of([&] { model.check(std::vector{1.5}); }), HasSubstr("0 to 1"));
  EXPECT_THAT(
      failure_of([&] { model.check(std::vector{std::numeric_limits<double>::quiet_NaN()}); }),
      HasSubstr("rho"));
  EXPECT_THAT(failure_of([&] { model.check(std::vector{0.1, 0.2}); }), HasSubstr("2 values"));
}

}  // namespace
}  // namespace umov::brdf
