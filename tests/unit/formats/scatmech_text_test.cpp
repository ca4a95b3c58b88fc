#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "host/brdf/evaluate.hpp"
#include "host/errors/error.hpp"
#include "host/formats/scatmech_text.hpp"
#include "host/optics/angles.hpp"
#include "tests/unit/brdf/reference_table.hpp"

namespace umov::formats {
namespace {

using optics::radians;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// A row's class and parameters as a file of their users.
std::string file_of(const brdf::reference::Row& row) {
  std::string text = row.model + "\n";
  for (const auto& [name, value] : row.parameters) text += name + " = " + value + "\n";
  return text;
}

std::string refusal(const std::string& text) {
  try {
    parse_scatmech(text, "m.txt");
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

std::string refusal_to_write(const std::string& model, std::vector<double> values) {
  try {
    scatmech_text(brdf::Model::by_name(model), values, 0.55, {});
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(Scatmech, FilesGiveTheValuesThatScatmechComputes) {
  std::map<std::string, int> checked;
  for (const auto& row : brdf::reference::read()) {
    if (!row.model.ends_with("_BRDF_Model") || !row.mueller || row.basis != "psps") continue;
    const TablePtr table = read_scatmech(file_of(row), "row " + row.id);
    const brdf::Geometry<double> geometry{radians(row.theta_i_deg), radians(row.theta_r_deg),
                                          radians(row.phi_r_deg)};
    const auto m = table->at(row.number("lambda"), geometry);
    // SCATMECH integrates the body's light numerically, to some 1e-5; the rest is closed formulas.
    const double tolerance = row.model == "Diffuse_Subsurface_BRDF_Model" ? 1e-5 : 2e-8;
    for (int e = 0; e < 16; ++e)
      EXPECT_NEAR(optics::element(m, e / 4, e % 4), (*row.mueller)[static_cast<std::size_t>(e)],
                  tolerance * (*row.mueller)[0])
          << "row " << row.id << " element " << e;
    // Written and read again it is the same model.
    const auto again =
        read_scatmech(write_scatmech(*table, {}), "again")->at(row.number("lambda"), geometry);
    for (int e = 0; e < 16; ++e)
      EXPECT_NEAR(optics::element(again, e / 4, e % 4), optics::element(m, e / 4, e % 4),
                  1e-13 * (*row.mueller)[0]);
    ++checked[row.model];
  }
  EXPECT_GE(checked["Facet_BRDF_Model"], 8);
  EXPECT_GE(checked["Shadowed_Facet_BRDF_Model"], 8);
  EXPECT_GE(checked["Microroughness_BRDF_Model"], 3);
  EXPECT_GE(checked["First_Diffuse_BRDF_Model"], 1);
  EXPECT_GE(checked["Diffuse_Subsurface_BRDF_Model"], 1);
  EXPECT_GE(checked["Lambertian_BRDF_Model"], 1);
}

TEST(Scatmech, ModelsComeBackWithTheirParameters) {
  const std::map<std::string, std::vector<double>> models{
      {"lambertian", {0.7}},
      {"microfacet:shadowing=none", {1.5, 0.1, 0.2, 1.0}},
      {"microfacet:shadowing=vgroove,slopes=exponential", {0.2, 6.7, 0.15, 1.0}},
      {"microfacet", {1.5, 0.0, 0.2, 1.0}},
      {"microfacet:shadowing=maxwell-beard", {1.5, 0.0, 0.2, 1.0, 0.6, 0.3}},
      {"rayleigh-rice", {4.0, 0.05, 0.01, 3.0}},
      {"rayleigh-rice:psd=abc", {4.0, 0.05, 0.001, 20, 2.2}},
      {"subsurface", {1.5, 0.6}},
      {"single-scatter", {1.5, 0.8, 0.3}},
      {"microfacet+lambertian", {1.5, 0.0, 0.2, 0.9, 0.4}},
      {"microfacet+microfacet:shadowing=vgroove+subsurface",
       {1.5, 0.0, 0.2, 0.5, 1.5, 0.0, 0.05, 0.5, 1.5, 0.3}}};
  for (const auto& [name, values] : models) {
    const brdf::Model model = brdf::Model::by_name(name);
    const std::string text =
        scatmech_text(model, values, 0.6328, std::vector<std::string>{"a comment"});
    EXPECT_TRUE(is_scatmech(text)) << text;
    const ScatmechModel back = parse_scatmech(text, name);
    EXPECT_EQ(back.model.name(), model.name());
    EXPECT_EQ(back.wavelength_um, 0.6328);
    ASSERT_EQ(back.values.size(), values.size());
    for (std::size_t n = 0; n < values.size(); ++n)
      EXPECT_NEAR(back.values[n], values[n], 1e-14 + 1e-14 * values[n]) << name << " " << n;
  }
}

TEST(Scatmech, WhatItPrintsOfItselfIsRead) {
  const ScatmechModel m = parse_scatmech(
      "Facet_BRDF_Model\n"
      "lambda = 0.532 (double: Wavelength [um])\n"
      "type = 0 (int: (0) for Forward/Reflection, (1) for Forward/Transmission)\n"
      "substrate = (1.5,0.2) (dielectric_function: Substrate)\n"
      "sdf = Gaussian_Slope_Distribution_Function (Slope_Distribution_Function_Ptr: Slope "
      "distribution function)\n"
      "sdf.s = 0.2 (double: RMS slope)\n"
      "stack = No_StackModel (StackModel_Ptr: Film stack on substrate)\n",
      "m.txt");
  EXPECT_EQ(m.values[m.model.index_of("n")], 1.5);
  EXPECT_EQ(m.values[m.model.index_of("kappa")], 0.2);
  EXPECT_NEAR(m.values[m.model.index_of("slope_rms")], 0.2 / std::sqrt(2), 1e-15);
}

TEST(Scatmech, WhatIsLeftOutHasScatmechsDefaults) {
  const ScatmechModel m = parse_scatmech("Shadowed_Facet_BRDF_Model ; nothing else\n", "m.txt");
  EXPECT_EQ(m.wavelength_um, 0.532);
  EXPECT_EQ(m.values[m.model.index_of("n")], 4.05);
  EXPECT_EQ(m.model.name(),
            brdf::Model::by_name("microfacet:shadowing=vgroove,slopes=exponential").name());
}

TEST(Scatmech, WhatIsLeftOutIsListed) {
  const TablePtr table = read_scatmech(
      "Facet_BRDF_Model\nsubstrate = (1.5,0)\nsdf = Gaussian_Slope_Distribution_Function\n", "m");
  const auto notes = dynamic_cast<const ModelTable&>(*table).notes();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_THAT(notes[0], AllOf(HasSubstr("lambda = 0.532"), HasSubstr("sdf.s = 0.1"),
                              HasSubstr("stack = No_StackModel"), HasSubstr("type = 0")));
  EXPECT_THAT(notes[0], ::testing::Not(HasSubstr("substrate")));
  // A file that this program writes leaves nothing out.
  const TablePtr whole = read_scatmech(write_scatmech(*table, {}), "whole");
  EXPECT_TRUE(dynamic_cast<const ModelTable&>(*whole).notes().empty());
}

TEST(Scatmech, AWavelengthInNanometresIsRefused) {
  EXPECT_THAT(refusal("Facet_BRDF_Model\nlambda = 632.8\n"),
              AllOf(HasSubstr("m.txt:2:lambda"), HasSubstr("um, not nm")));
  EXPECT_EQ(refusal("Facet_BRDF_Model\nlambda = 10.6\n"), "");
}

TEST(Scatmech, FactorsOfASumGoWhereTheyBelong) {
  const std::string sum =
      "Two_Source_BRDF_Model\nsubstrate = (1.5,0)\nfactor1 = 4\nsource1 = "
      "Microroughness_BRDF_Model\n"
      "source1.substrate = (1.5,0)\nsource1.psd = Gaussian_PSD_Function\nsource1.psd.sigma = 0.01\n"
      "factor2 = 0.5\nsource2 = Lambertian_BRDF_Model\nsource2.substrate = "
      "(1.5,0)\nsource2.reflectance.table = 0.6\n";
  const ScatmechModel m = parse_scatmech(sum, "m.txt");
  EXPECT_NEAR(m.values[m.model.index_of("0.sigma_um")], 0.02, 1e-15)
      << "scatter goes with the square of the height";
  EXPECT_NEAR(m.values[m.model.index_of("1.rho")], 0.3, 1e-15);
}

TEST(Scatmech, BadFilesAreRefusedWithLineAndParameter) {
  const std::string good =
      "Facet_BRDF_Model\nlambda = 0.6\nsubstrate = (1.5,0)\nsdf = "
      "Gaussian_Slope_Distribution_Function\nsdf.s = 0.2\n";
  EXPECT_EQ(refusal(good), "");
  EXPECT_THAT(refusal(good + "sdf.s = 0.3\n"), HasSubstr("m.txt:6:sdf.s: is given twice"));
  EXPECT_THAT(refusal(good + "gloss = 3\n"),
              AllOf(HasSubstr("m.txt:6:gloss"), HasSubstr("no parameter of Facet")));
  EXPECT_THAT(refusal("Facet_BRDF_Model\nsdf.s = nan\n"), HasSubstr("m.txt:2:sdf.s"));
  EXPECT_THAT(refusal("Facet_BRDF_Model\nsdf.s = -1\n"), HasSubstr("out of range"));
  EXPECT_THAT(refusal("Facet_BRDF_Model\nsdf.s =\n"), HasSubstr("has no value"));
  EXPECT_THAT(refusal("Facet_BRDF_Model\ntype = 1\n"), HasSubstr("m.txt:2:type"));
  EXPECT_THAT(refusal("Facet_BRDF_Model\nsubstrate = silicon.txt\n"),
              HasSubstr("files are not read"));
  EXPECT_THAT(refusal("Facet_BRDF_Model\nstack = Single_StackModel\n"),
              AllOf(HasSubstr("stack"), HasSubstr("No_StackModel")));
  EXPECT_THAT(refusal("Facet_BRDF_Model\nsdf = Ellipsoid_Slope_Distribution_Function\n"),
              HasSubstr("Gaussian_Slope_Distribution_Function"));
  EXPECT_THAT(
      refusal(
          "Shadowed_Facet_BRDF_Model\nsdf.s=0.2\nshadow = Smith_Shadow_Function\nshadow.w = 0.2\n"),
      HasSubstr("sdf.s/sqrt(2)"));
  EXPECT_THAT(refusal("Double_Interaction_BRDF_Model\n"),
              AllOf(HasSubstr("m.txt:1"), HasSubstr("Microroughness_BRDF_Model")));
  EXPECT_THAT(refusal("Two_Source_BRDF_Model\ncorrelation = 1\n"), HasSubstr("correlation"));
  EXPECT_THAT(refusal("Two_Source_BRDF_Model\nsource1.lambda = 0.4\n"),
              HasSubstr("one wavelength"));
  EXPECT_THAT(refusal("Two_Source_BRDF_Model\nsource1.substrate = (2,0)\n"),
              HasSubstr("same substrate"));
  EXPECT_THAT(refusal("Diffuse_Subsurface_BRDF_Model\nsubstrate=(1.5,0.1)\n"),
              HasSubstr("absorbs"));
  EXPECT_THAT(refusal("Lambertian_BRDF_Model\nreflectance.table = 1.5\n"), HasSubstr("rho"));
  EXPECT_THAT(refusal("lambda = 1\n"), HasSubstr("does not name a class"));
  EXPECT_THAT(refusal("Facet_BRDF_Model\nwhat is this\n"), HasSubstr("m.txt:2"));
  EXPECT_THAT(refusal(""), HasSubstr("does not name a class"));
  std::string nested = "Two_Source_BRDF_Model\nsubstrate=(1.5,0)\n", prefix;
  for (int depth = 0; depth < 8; ++depth) {
    prefix += "source1.";
    nested += prefix.substr(0, prefix.size() - 1) + " = Two_Source_BRDF_Model\n" + prefix +
              "substrate = (1.5,0)\n";
  }
  EXPECT_NE(refusal(nested), "");
}

TEST(Scatmech, ModelsWithoutACounterpartAreNotWritten) {
  for (const char* name :
       {"ggx", "he-torrance", "phong", "ward", "microfacet:shadowing=smith-correlated"})
    EXPECT_THAT(refusal_to_write(name, brdf::Model::by_name(name).initial_values()),
                AllOf(HasSubstr("no exact counterpart"), HasSubstr("rayleigh-rice")))
        << name;
  EXPECT_THAT(refusal_to_write("nef", {0.1, 0.01}), HasSubstr("rho_d2"));
  EXPECT_EQ(refusal_to_write("nef", {0.1, 0.0}), "");
  EXPECT_THAT(refusal_to_write("microfacet", {1.5, 0, 0.2, 1.2}),
              HasSubstr("bias 1.2 outside a sum"));
  EXPECT_THAT(refusal_to_write("microfacet+microfacet", {1.5, 0, 0.2, 1, 1.6, 0, 0.1, 1}),
              HasSubstr("different indices"));
}

}  // namespace
}  // namespace umov::formats
