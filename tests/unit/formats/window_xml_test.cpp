#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <numbers>

#include "host/brdf/evaluate.hpp"
#include "host/errors/error.hpp"
#include "host/formats/klems_means.hpp"
#include "host/formats/klems_table.hpp"
#include "host/formats/window_xml.hpp"
#include "host/optics/angles.hpp"
#include "table_sources.hpp"

namespace umov::formats {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
constexpr double pi = std::numbers::pi;

/// A small file: the quarter basis (41 patches), a Lambertian surface of 30 %.
WindowElement small_element() {
  const KlemsBasis basis = *KlemsBasis::by_name("LBNL/Klems Quarter");
  KlemsMatrix matrix{basis, basis, std::vector<double>(basis.size() * basis.size(), 0.3 / pi)};
  matrix.at(7, 3) = 0.125;
  return {"a < b & \"c\" 'd'", "maker", {{"Visible", "Integral", "Reflection Front", matrix}}, 0};
}

const std::string& small_text() {
  static const std::string text =
      window_xml_text(small_element(), std::vector<std::string>{"note -- one"});
  return text;
}

std::string refusal(const std::string& text) {
  try {
    parse_window_xml(text, "sample.xml");
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

std::string with(const std::string& from, const std::string& to) {
  std::string text = small_text();
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(WindowXml, ComesBackAsItWasWritten) {
  const WindowElement element = small_element();
  const WindowElement back = parse_window_xml(small_text(), "x");
  EXPECT_EQ(back.name, element.name);
  EXPECT_EQ(back.manufacturer, element.manufacturer);
  ASSERT_EQ(back.blocks.size(), 1u);
  EXPECT_EQ(back.blocks[0].band, "Visible");
  EXPECT_EQ(back.blocks[0].matrix.values, element.blocks[0].matrix.values);
  EXPECT_EQ(back.blocks[0].matrix.at(7, 3), 0.125);
  EXPECT_EQ(window_xml_text(back, std::vector<std::string>{"note -- one"}), small_text());
}

TEST(WindowXml, AModelComesBackWithinTheStatedAccuracy) {
  const brdf::Model model = brdf::Model::by_name("microfacet+lambertian");
  const ModelTable source(model, {0.55}, {{1.5, 0.0, 0.1, 1.0, 0.4}}, "red gloss");
  TableWriting writing;
  writing.program = "umov test";
  writing.command = "umov export --model x";
  const std::string text = write_window_table(source, writing);
  EXPECT_TRUE(is_window_xml(text));
  EXPECT_THAT(text, AllOf(HasSubstr("not multiplied by cos theta"), HasSubstr("diagonal"),
                          HasSubstr("red gloss"),
                          HasSubstr("weighted with cos theta_i cos theta_r"), HasSubstr("550 nm"),
                          HasSubstr("directional-hemispherical reflectance by incident ring"),
                          HasSubstr("Reflection Front"), HasSubstr("Reflection Back")));
  const TablePtr table = read_window_table(text, "red.xml");
  EXPECT_THAT(table->description(), HasSubstr("145 x 145"));
  EXPECT_FALSE(table->polarised());
  // Far from the lobe a patch mean is the BRDF in its middle.
  const brdf::Geometry<double> middle{optics::radians(40), optics::radians(20), pi};
  EXPECT_NEAR(table->at(0.55, middle)[0][0], source.at(0.55, middle)[0][0],
              0.02 * source.at(0.55, middle)[0][0]);
  // In the lobe it is lower than the peak and still far above the base.
  const brdf::Geometry<double> mirror{optics::radians(40), optics::radians(40), 0};
  EXPECT_LT(table->at(0.55, mirror)[0][0], source.at(0.55, mirror)[0][0]);
  EXPECT_GT(table->at(0.55, mirror)[0][0], 2 * table->at(0.55, middle)[0][0]);
  // Written again it is the same file, header apart.
  const std::string again = write_window_table(*table, {});
  const auto data = [](const std::string& xml) { return xml.substr(xml.find("<DataDefinition>")); };
  EXPECT_EQ(data(again), data(text));
}

TEST(WindowXml, SeveralWavelengthsBecomeTheVisibleMean) {
  const ModelTable source(brdf::Model::by_name("lambertian"), {0.45, 0.65}, {{0.2}, {0.8}}, "red");
  const std::string text = write_window_table(source, {});
  const TablePtr table = read_window_table(text, "red.xml");
  const double rho = pi * table->at(0.55, {0.3, 0.4, 1.0})[0][0];
  EXPECT_GT(rho, 0.45);
  EXPECT_LT(rho, 0.6);
  EXPECT_THAT(text, HasSubstr("weighted with D65"));
}

TEST(WindowXml, AModelThatCreatesLightIsNotWritten) {
  const ModelTable source(brdf::Model::by_name("microfacet:shadowing=none"), {0.55},
                          {{1.5, 7.0, 0.3, 1.0}}, "metal");
  try {
    write_window_table(source, {});
    FAIL() << "unshadowed facets reflect more than they receive";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("would reflect"), HasSubstr("shadowing")));
  }
}

TEST(WindowXml, RowsOfIncidentPatchesAreTurned) {
  const WindowElement rows = parse_window_xml(with(">Columns<", ">Rows<"), "x");
  EXPECT_EQ(rows.blocks[0].matrix.at(3, 7), 0.125);
  EXPECT_EQ(rows.blocks[0].matrix.at(7, 3), 0.3 / pi);
}

TEST(WindowXml, TransmissionIsLeftOutAndCounted) {
  WindowElement element = small_element();
  element.blocks.push_back(element.blocks[0]);
  element.blocks[1].direction = "Transmission Front";
  const WindowElement back = parse_window_xml(window_xml_text(element, {}), "x");
  EXPECT_EQ(back.blocks.size(), 1u);
  EXPECT_EQ(back.transmission_blocks, 1u);
}

TEST(WindowXml, FilesOfOtherProgramsMayNameTheBasisOnlyAndUseCommas) {
  std::string text = small_text();
  const auto from = text.find("<AngleBasisBlock>");
  text.erase(from, text.find("</AngleBasis>") - from);
  EXPECT_EQ(refusal(text), "");
  const auto data = text.find("0.125");
  text.replace(data, 6, "0.125,\n");
  EXPECT_EQ(parse_window_xml(text, "x").blocks[0].matrix.at(7, 3), 0.125);
}

TEST(WindowXml, BadFilesAreRefusedWithTheLine) {
  EXPECT_EQ(refusal(small_text()), "");
  EXPECT_THAT(refusal(""), HasSubstr("sample.xml:1: is not well-formed XML"));
  EXPECT_THAT(refusal("<a></a>"), HasSubstr("no WindowElement"));
  EXPECT_THAT(refusal(small_text().substr(0, small_text().size() / 2)),
              HasSubstr("not well-formed"));
  const auto line_of = [](const std::string& what) {
    const auto at = small_text().find(what);
    return "sample.xml:" +
           std::to_string(1 + std::count(small_text().begin(),
                                         small_text().begin() + static_cast<std::ptrdiff_t>(at),
                                         '\n'));
  };
  EXPECT_THAT(refusal(with("0.125", "nan")),
              AllOf(HasSubstr(line_of("0.125")), HasSubstr("ScatteringData")));
  EXPECT_THAT(refusal(with("0.125", "-0.1")),
              AllOf(HasSubstr(line_of("0.125")), HasSubstr("negative")));
  EXPECT_THAT(refusal(with("0.125", "0.125 0.125")), HasSubstr("more than the 1681 values"));
  EXPECT_THAT(refusal(with("0.125", "")), HasSubstr("1680 values, not 1681"));
  EXPECT_THAT(refusal(with("0.125", "1e300")), HasSubstr("reflects"));
  EXPECT_THAT(refusal(with(">Columns<", ">TensorTree4<")),
              AllOf(HasSubstr("tensor tree"), HasSubstr("bsdf2klems")));
  EXPECT_THAT(refusal(with("<nPhis>8", "<nPhis>8000000000")), HasSubstr("nPhis"));
  EXPECT_THAT(refusal(with("<nPhis>8", "<nPhis>2.5")), HasSubstr("nPhis"));
  EXPECT_THAT(refusal(with("<UpperTheta>90", "<UpperTheta>95")), HasSubstr("ends at 95"));
  EXPECT_THAT(refusal(with("<LowerTheta>27", "<LowerTheta>28")), HasSubstr("begins at 28"));
  EXPECT_THAT(refusal(with("Reflection Front", "Sideways")), HasSubstr("WavelengthDataDirection"));
  EXPECT_THAT(refusal(with("<ColumnAngleBasis>LBNL/Klems Quarter", "<ColumnAngleBasis>mine")),
              HasSubstr("not defined"));
  EXPECT_THAT(refusal(with("<ScatteringData>", "<Data>")), HasSubstr("not well-formed"));
}

TEST(WindowXml, NothingMayFollowTheElement) {
  EXPECT_EQ(refusal(small_text() + "\n <!-- end -->\n"), "");
  const std::string last =
      std::to_string(1 + std::count(small_text().begin(), small_text().end(), '\n'));
  for (const char* junk : {"junk", "<a/>", "0.1 0.2", "<WindowElement></WindowElement>"})
    EXPECT_THAT(refusal(small_text() + junk),
                AllOf(HasSubstr("sample.xml:" + last), HasSubstr("goes on after WindowElement")))
        << junk;
}

/// A model written and read again against its own means over the patches. `worst` bounds the
/// reference's own noise, which is largest where a lobe fills little of a patch.
void expect_patch_means(const ModelTable& source, double worst) {
  const TablePtr back = read_window_table(write_window_table(source, {}), "m.xml");
  const KlemsMeans means(source, *KlemsBasis::by_name("LBNL/Klems Full"), {0.55}, 16384);
  const TableDifference difference = compare_tables(*back, means, {0.555});
  std::cout << source.description() << ": " << difference.sentence() << "\n";
  EXPECT_LT(difference.median, 5e-4);
  EXPECT_LT(difference.p95, 2e-3);
  EXPECT_LT(difference.worst, worst);
  EXPECT_LT(compare_reflectances(*back, 0.555, means, 0.55, true).largest(), 2e-4);
}

TEST(WindowXml, PatchesHoldTheMeansOfTheirSource) {
  expect_patch_means(testing::satin(), 0.01);
  expect_patch_means(testing::model_table("rayleigh-rice", {{"sigma_um", 0.005}}), 0.01);
}

TEST(WindowXml, PatchesHoldTheMeansOfALobeMuchNarrowerThanThey) {
  expect_patch_means(testing::model_table("microfacet", {{"slope_rms", 0.03}}), 0.1);
}

TEST(WindowXml, TheMirrorPartIsInItsPatches) {
  const auto source = testing::model_table("rayleigh-rice", {{"sigma_um", 0.005}});
  ASSERT_TRUE(source.has_mirror());
  const TablePtr back = read_window_table(write_window_table(source, {}), "m.xml");
  const auto* klems = dynamic_cast<const KlemsTable*>(back.get());
  ASSERT_NE(klems, nullptr);
  EXPECT_GT(compare_tables(*back, source, {0.555}).worst, 10.0);
  EXPECT_TRUE(klems->in_mirror_patch({0.7, 0.7, 0.0}));
  EXPECT_FALSE(klems->in_mirror_patch({0.7, 0.7, 0.5}));
  EXPECT_FALSE(klems->in_mirror_patch({0.7, 0.2, 0.0}));
  // The power that the mirror reflects is in the file.
  EXPECT_GT(compare_reflectances(*back, 0.555, source, 0.55, false).largest(), 0.1);
  EXPECT_TRUE(source.notes(true).empty());
  EXPECT_EQ(source.notes(false).size(), 1u);
}

TEST(WindowXml, AMatrixTimesCosineIsNotTakenForABrdf) {
  // A white surface whose values were not divided by the cosine and the solid angle.
  std::string text = small_text();
  const KlemsBasis basis = *KlemsBasis::by_name("LBNL/Klems Quarter");
  WindowElement element = small_element();
  for (double& value : element.blocks[0].matrix.values) value = 1.0;
  EXPECT_THROW(window_xml_text(element, {}), Error);
}

}  // namespace
}  // namespace umov::formats
