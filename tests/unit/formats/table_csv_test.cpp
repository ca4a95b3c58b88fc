#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/brdf/grid_table.hpp"
#include "host/brdf/planes_table.hpp"
#include "host/errors/error.hpp"
#include "host/formats/table_csv.hpp"
#include "host/optics/angles.hpp"

namespace umov::formats {
namespace {

using optics::radians;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string rows_of(const std::string& csv) {
  return csv.substr(csv.find("\ntheta_i_deg") != std::string::npos ? csv.find("\ntheta_i_deg")
                                                                   : csv.find("\nplane,"));
}

brdf::GridTable small_grid() {
  std::vector<double> values;
  for (int n = 0; n < 2 * 2 * 3 * 2; ++n) values.push_back(0.1 + 0.0123456789 * n);
  return {{{0, 45.5}, {0, 30, 89}, {0, 180}, {0.532, 0.6328}}, values, 1, "made for a test"};
}

template <class Reading>
std::string refusal(Reading reading, const std::string& text) {
  try {
    reading(text, "t.csv");
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(GridCsv, ComesBackNumberByNumber) {
  const brdf::GridTable grid = small_grid();
  TableWriting writing;
  writing.program = "umov test";
  const std::string text = write_grid_csv(grid, writing);
  EXPECT_TRUE(is_grid_csv(text));
  EXPECT_FALSE(is_planes_csv(text));
  EXPECT_THAT(text, AllOf(HasSubstr("not multiplied by cos theta"), HasSubstr("532, 632.8 nm"),
                          HasSubstr("azimuth: 0 is the specular")));
  const TablePtr back = read_grid_csv(text, "t.csv");
  const auto& again = dynamic_cast<const brdf::GridTable&>(*back);
  EXPECT_EQ(again.axes().theta_i_deg, grid.axes().theta_i_deg);
  EXPECT_EQ(again.axes().wavelength_um, grid.axes().wavelength_um);
  EXPECT_TRUE(std::equal(again.values().begin(), again.values().end(), grid.values().begin(),
                         grid.values().end()));
  EXPECT_EQ(rows_of(write_grid_csv(*back, {})), rows_of(text));
}

TEST(GridCsv, ThePolarisedModelComesBackAtItsNodes) {
  const ModelTable model(brdf::Model::by_name("microfacet"), {0.55}, {{1.5, 0.2, 0.3, 1.0}},
                         "facets");
  const TablePtr back = read_grid_csv(write_grid_csv(model, {}), "t.csv");
  EXPECT_TRUE(back->polarised());
  for (const double phi_deg : {0.0, 5.0, 90.0, 180.0, -40.0}) {
    const brdf::Geometry<double> g{radians(40), radians(50), radians(phi_deg)};
    const auto a = back->at(0.55, g), b = model.at(0.55, g);
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c)
        EXPECT_NEAR(optics::element(a, r, c), optics::element(b, r, c), 1e-9)
            << phi_deg << " " << r << c;
  }
}

TEST(GridCsv, RowsMayStandInAnyOrderAndInPlaneAnglesMayBeSigned) {
  const std::string header = "theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,m00\n";
  const TablePtr table =
      read_grid_csv("# anything\n" + header +
                        "30,60,0,550,0.4\n30,-20,0,550,0.1\n30,20,0,550,0.2\n30,-60,0,550,0.3\n",
                    "t.csv");
  EXPECT_NEAR(table->at(0.55, {radians(30), radians(20), radians(180)})[0][0], 0.1, 1e-12);
  EXPECT_NEAR(table->at(0.55, {radians(30), radians(60), 0})[0][0], 0.4, 1e-12);
}

TEST(GridCsv, BadFilesAreRefusedWithLineAndColumn) {
  const std::string good = write_grid_csv(small_grid(), {});
  const auto line = std::to_string(
      2 + std::count(good.begin(),
                     good.begin() + static_cast<std::ptrdiff_t>(good.find("\ntheta_i")) + 1, '\n'));
  EXPECT_EQ(refusal(read_grid_csv, good), "");
  EXPECT_THAT(refusal(read_grid_csv, changed(good, "\n0,0,0,532,", "\n0,0,0,532,nan")),
              HasSubstr("t.csv:" + line + ":m00"));
  EXPECT_THAT(refusal(read_grid_csv, changed(good, "\n0,0,0,532,", "\n0,0,0,532,-")),
              HasSubstr("t.csv:" + line + ":m00"));
  EXPECT_THAT(refusal(read_grid_csv, changed(good, "\n0,0,0,532,", "\n90,0,0,532,")),
              HasSubstr("theta_i_deg"));
  EXPECT_THAT(refusal(read_grid_csv, changed(good, "\n0,0,0,532,", "\n0,91,0,532,")),
              HasSubstr("theta_r_deg"));
  EXPECT_THAT(refusal(read_grid_csv, changed(good, "\n0,0,0,532,", "\n0,0,361,532,")),
              HasSubstr("phi_r_deg"));
  EXPECT_THAT(refusal(read_grid_csv, changed(good, "\n0,0,0,532,", "\n0,0,0,0.532,")),
              HasSubstr("wavelength_nm"));
  EXPECT_THAT(refusal(read_grid_csv, changed(good, "\n0,0,0,532,", "\n0,-5,40,532,")),
              HasSubstr("out of the plane"));
  EXPECT_THAT(refusal(read_grid_csv, changed(good, "\n0,0,0,532,", "\n0,1,0,532,")),
              HasSubstr("do not fill the grid"));
  EXPECT_THAT(refusal(read_grid_csv, changed(good, "\n0,0,180,532,", "\n0,0,0,532,")),
              HasSubstr("given twice"));
  EXPECT_THAT(refusal(read_grid_csv, changed(good, "m00\n", "m00,m01\n")), HasSubstr("m02"));
  EXPECT_THAT(refusal(read_grid_csv, good.substr(0, good.find("\n0,0,0,532"))),
              HasSubstr("no records"));
}

TEST(GridCsv, WrongSymmetryIsRefused) {
  const ModelTable model(brdf::Model::by_name("microfacet"), {0.55}, {{1.5, 0.2, 0.3, 1.0}},
                         "facets");
  const std::string good = write_grid_csv(model, {});
  // In plane, m02 of a mirror-symmetric surface is zero; write m01 there as well.
  std::string text;
  std::size_t at = good.find("\n40,50,0,550,") + 1;
  const std::string row = good.substr(at, good.find('\n', at) - at);
  std::vector<std::string> cells(1);
  for (const char c : row) {
    if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  cells[6] = cells[5];
  for (const std::string& cell : cells) text += (text.empty() ? "" : ",") + cell;
  EXPECT_THAT(refusal(read_grid_csv, changed(good, row, text)),
              AllOf(HasSubstr("m02"), HasSubstr("does not vanish")));
  cells[6] = "1e6";
  text.clear();
  for (const std::string& cell : cells) text += (text.empty() ? "" : ",") + cell;
  EXPECT_THAT(refusal(read_grid_csv, changed(good, row, text)), HasSubstr("m02"));
}

TEST(PlanesCsv, ComesBackAsItWas) {
  const brdf::PlanesTable planes(
      {0.45, 0.65},
      {{5,
        {{-80, -20, 5, 60}, {{0.1, 0.2, 0.9, 0.3}, {0.2, 0.3, 1.9, 0.4}}},
        {{0, 20, 80}, {{0.9, 0.3, 0.2}, {1.9, 0.4, 0.3}}}},
       {60,
        {{-80, 60, 85}, {{0.1, 3, 2}, {0.2, 5, 4}}},
        {{-30, 0, 30}, {{0.2, 3, 0.25}, {0.3, 5, 0.35}}}}},
      "made for a test");
  const std::string text = write_planes_csv(planes, {});
  EXPECT_TRUE(is_planes_csv(text));
  const TablePtr back = read_planes_csv(text, "t.csv");
  EXPECT_EQ(rows_of(write_planes_csv(*back, {})), rows_of(text));
  for (const double theta : {5.0, 30.0, 60.0})
    for (const double phi : {0.0, 40.0, -100.0}) {
      const brdf::Geometry<double> g{radians(theta), radians(40), radians(phi)};
      EXPECT_EQ(back->at(0.65, g)[0][0], planes.at(0.65, g)[0][0]);
    }
}

TEST(PlanesCsv, AModelCutAlongItsPlanesIsExactInThem) {
  const ModelTable model(brdf::Model::by_name("microfacet+lambertian"), {0.55},
                         {{1.5, 0.0, 0.2, 1.0, 0.3}}, "paint");
  const TablePtr back = read_planes_csv(write_planes_csv(model, {}), "t.csv");
  for (const double theta_r_deg : {-60.0, 0.0, 45.0, 70.0}) {
    const brdf::Geometry<double> g{radians(45), radians(theta_r_deg), 0};
    EXPECT_NEAR(back->at(0.55, g)[0][0], model.at(0.55, g)[0][0], 1e-3 * model.at(0.55, g)[0][0])
        << theta_r_deg;
  }
  const double beta = radians(20), theta = radians(45);
  const double y = std::sin(beta), x = std::sin(theta) * std::cos(beta),
               z = std::cos(theta) * std::cos(beta);
  const brdf::Geometry<double> across{theta, std::acos(z), std::atan2(y, x)};
  EXPECT_NEAR(back->at(0.55, across)[0][0], model.at(0.55, across)[0][0],
              1e-3 * model.at(0.55, across)[0][0]);
}

TEST(PlanesCsv, BadFilesAreRefusedWithLineAndColumn) {
  const std::string good =
      "plane,theta_i_deg,angle_deg,wavelength_nm,m00\n"
      "in,30,-80,550,0.1\n"
      "in,30,30,550,0.5\n"
      "across,30,0,550,0.5\n"
      "across,30,40,550,0.1\n";
  EXPECT_EQ(refusal(read_planes_csv, good), "");
  EXPECT_THAT(refusal(read_planes_csv, changed(good, "in,30,30", "out,30,30")),
              HasSubstr("t.csv:3:plane"));
  EXPECT_THAT(refusal(read_planes_csv, changed(good, "in,30,30", "in,30,130")),
              HasSubstr("t.csv:3:angle_deg"));
  EXPECT_THAT(refusal(read_planes_csv, changed(good, "in,30,30", "in,95,30")),
              HasSubstr("t.csv:3:theta_i_deg"));
  EXPECT_THAT(refusal(read_planes_csv, changed(good, "550,0.5", "550,inf")),
              HasSubstr("t.csv:3:m00"));
  EXPECT_THAT(refusal(read_planes_csv, changed(good, "in,30,30,550", "in,30,-80,550")),
              HasSubstr("twice"));
  EXPECT_THAT(refusal(read_planes_csv, changed(good, "in,30,30,550", "in,30,30,650")),
              HasSubstr("every wavelength"));
  EXPECT_THAT(refusal(read_planes_csv, good.substr(0, good.find("across"))),
              HasSubstr("one of the two planes"));
}

}  // namespace
}  // namespace umov::formats
