// Tables over a grid, and the model that evaluates them.
#include <ceres/jet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "host/brdf/checks.hpp"
#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"
#include "host/brdf/grid_table.hpp"
#include "host/errors/error.hpp"
#include "tests/unit/brdf/table_source.hpp"

namespace umov::brdf {
namespace {

using optics::element;
using optics::Mueller;
using optics::radians;
using ::testing::HasSubstr;

GridTable sampled_grid(GridAxes axes, int elements) {
  std::vector<double> values;
  for (const double wavelength : axes.wavelength_um) {
    for (const double i : axes.theta_i_deg) {
      for (const double r : axes.theta_r_deg) {
        for (const double p : axes.phi_r_deg) {
          const Mueller<double> m = source(degrees(i, r, p));
          for (int k = 0; k < elements; ++k)
            values.push_back(element(m, k / 4, k % 4) * (wavelength > 0.7 ? 2.0 : 1.0));
        }
      }
    }
  }
  return GridTable(std::move(axes), std::move(values), elements, "sampled");
}

GridTable small_grid(int elements = 16) {
  return sampled_grid({steps(0, 60, 15), steps(0, 85, 5), steps(0, 180, 15), {0.633, 0.833}},
                      elements);
}

/// Hides where a table is smooth, as formats with their own coordinates do.
class Unstructured : public Table {
 public:
  explicit Unstructured(std::shared_ptr<const Table> table) : table_(std::move(table)) {}
  Mueller<double> at(double wavelength_um, const Geometry<double>& g) const override {
    return table_->at(wavelength_um, g);
  }
  const std::vector<double>& wavelengths_um() const override { return table_->wavelengths_um(); }
  bool polarised() const override { return table_->polarised(); }
  std::string description() const override { return table_->description(); }

 private:
  std::shared_ptr<const Table> table_;
};

void expect_equal(const Mueller<double>& a, const Mueller<double>& b, const std::string& where) {
  for (int k = 0; k < 16; ++k)
    EXPECT_NEAR(element(a, k / 4, k % 4), element(b, k / 4, k % 4), 1e-12) << where << " " << k;
}

TEST(GridTable, GivesItsEntriesOnBothSidesOfThePlaneOfIncidence) {
  const GridTable table = small_grid();
  for (const double i : {0.0, 15.0, 60.0}) {
    for (const double r : {5.0, 45.0, 85.0}) {
      for (const double p : {0.0, 30.0, 180.0, -30.0, -165.0}) {
        expect_equal(table.at(0.633, degrees(i, r, p)), source(degrees(i, r, p)), "entry");
      }
      expect_equal(table.at(0.633, degrees(i, -r, 0)), source(degrees(i, -r, 0)), "retro side");
    }
  }
}

TEST(GridTable, InterpolatesLinearlyInEveryCoordinate) {
  const GridTable table = small_grid();
  const auto m00 = [&](double i, double r, double p, double w) {
    return element(table.at(w, degrees(i, r, p)), 0, 0);
  };
  EXPECT_NEAR(m00(7.5, 30, 0, .633), 0.5 * (m00(0, 30, 0, .633) + m00(15, 30, 0, .633)), 1e-12);
  EXPECT_NEAR(m00(15, 32, 0, .633), 0.6 * m00(15, 30, 0, .633) + 0.4 * m00(15, 35, 0, .633), 1e-12);
  EXPECT_NEAR(m00(15, 30, 6, .633), 0.6 * m00(15, 30, 0, .633) + 0.4 * m00(15, 30, 15, .633),
              1e-12);
  EXPECT_NEAR(m00(15, 30, 0, .733), 1.5 * m00(15, 30, 0, .633), 1e-12);
}

TEST(GridTable, KeepsTheNearestValueBeyondItsEntriesAndNothingBelowTheHorizon) {
  const GridTable table = small_grid();
  expect_equal(table.at(0.633, degrees(80, 89, 40)), table.at(0.633, degrees(60, 85, 40)),
               "angles");
  expect_equal(table.at(2.0, degrees(15, 30, 40)), table.at(0.833, degrees(15, 30, 40)), "red");
  EXPECT_EQ(element(table.at(0.633, degrees(15, 91, 0)), 0, 0), 0.0);
  EXPECT_EQ(element(table.at(0.633, degrees(91, 15, 0)), 0, 0), 0.0);
}

TEST(GridTable, ClosesAFullCircleOfAzimuths) {
  GridAxes axes{{30}, {40}, steps(-180, 170, 10), {0.633}};
  std::vector<double> values;
  for (const double p : axes.phi_r_deg) values.push_back(2.0 + std::sin(radians(p)));
  const GridTable table(axes, values, 1, "circle");
  const auto at = [&](double p) { return element(table.at(0.633, degrees(30, 40, p)), 0, 0); };
  EXPECT_NEAR(at(-30), 1.5, 1e-12);
  EXPECT_NEAR(at(30), 2.5, 1e-12);
  EXPECT_NEAR(at(175), 0.5 * (at(170) + at(-180)), 1e-12);
  EXPECT_NEAR(at(180), 2.0, 1e-12);
}

TEST(GridTable, RefusesWhatIsNotAGridOfBrdfValuesWithThePlace) {
  const GridAxes axes{{0, 30}, {0, 45}, {0, 180}, {0.633}};
  const auto refusal = [&](const std::function<void(GridAxes&, std::vector<double>&)>& spoil) {
    GridAxes a = axes;
    std::vector<double> v(8, 0.1);
    spoil(a, v);
    return message([&] { GridTable(a, v, 1, "file.h5"); });
  };
  EXPECT_EQ(refusal([](auto&, auto&) {}), "no error");
  EXPECT_THAT(refusal([](auto&, auto& v) { v.pop_back(); }), HasSubstr("7 values for a grid of 8"));
  EXPECT_THAT(refusal([](auto&, auto& v) { v[5] = std::nan(""); }), HasSubstr("[0][1][0][1]"));
  EXPECT_THAT(refusal([](auto&, auto& v) { v[5] = -1e-9; }), HasSubstr("not negative"));
  EXPECT_THAT(refusal([](auto& a, auto&) {
                a.theta_r_deg = {45, 0};
              }),
              HasSubstr("file.h5:theta_r_deg[1]"));
  EXPECT_THAT(refusal([](auto& a, auto&) {
                a.theta_i_deg = {0, 90};
              }),
              HasSubstr("theta_i_deg[1]"));
  EXPECT_THAT(refusal([](auto& a, auto&) { a.phi_r_deg = {0, 270}; }), HasSubstr("phi_r_deg[1]"));
  EXPECT_THAT(refusal([](auto& a, auto&) { a.wavelength_um = {std::nan("")}; }),
              HasSubstr("wavelength_um[0]"));
  EXPECT_THAT(refusal([](auto& a, auto& v) {
                a.theta_i_deg.clear();
                v.clear();
              }),
              HasSubstr("empty"));
  EXPECT_THROW(GridTable(axes, std::vector<double>(16, 0.1), 2, "file.h5"), Error);
}

TEST(Tabulated, SaysHowToGiveTheTableItLacks) {
  const Model model = Model::by_name("lambertian+tabulated");
  ASSERT_EQ(model.table_slots().size(), 1u);
  EXPECT_EQ(model.table_slots()[0].name, "1.file");
  EXPECT_TRUE(model.needs_table());
  const std::vector<double> values{0.2};
  EXPECT_THAT(message([&] { evaluate<double>(model, values, 0.633, degrees(10, 20, 0)); }),
              HasSubstr("--set 1.file=PATH"));
  EXPECT_THROW(dhr(model, values, 0.633, 0.1), Error);
  const auto table = std::make_shared<GridTable>(small_grid());
  EXPECT_THAT(message([&] { model.with_table(table); }), HasSubstr("those that take one: 1"));
  EXPECT_THROW(model.with_table(nullptr, 1), Error);
  EXPECT_THAT(message([&] { model.index_of("file"); }), HasSubstr("1.file"));
}

TEST(Tabulated, AddsToOtherModels) {
  const auto table = std::make_shared<GridTable>(small_grid());
  const Model model = Model::by_name("tabulated+lambertian").with_table(table, 0);
  EXPECT_FALSE(model.needs_table());
  EXPECT_EQ(model.name(), "tabulated+lambertian");
  const Geometry<double> g = degrees(20, 33, 71);
  Mueller<double> expected = table->at(0.7, g);
  expected[0][0] += 0.4 / optics::pi;
  expect_equal(evaluate<double>(model, std::vector{0.4}, 0.7, g), expected, "sum");
  EXPECT_NEAR(
      dhr(model, std::vector{0.4}, 0.7, radians(20)).unpolarized,
      0.4 + dhr(Model::by_name("tabulated").with_table(table), {}, 0.7, radians(20)).unpolarized,
      1e-9);
  const Model with_lobe = Model::by_name("microfacet+tabulated").with_table(table, 1);
  const std::vector<double> facets{1.5, 0.0, 0.1, 1.0};
  const Dhr both = dhr(with_lobe, facets, 0.633, 0.6);
  const Dhr one = dhr(Model::by_name("microfacet"), facets, 0.633, 0.6);
  const Dhr other = dhr(Model::by_name("tabulated").with_table(table), {}, 0.633, 0.6);
  EXPECT_NEAR(both.unpolarized, one.unpolarized + other.unpolarized, 1e-8);
  EXPECT_NEAR(both.s, one.s + other.s, 1e-8);
  EXPECT_GT(other.s, other.p);
}

TEST(Tabulated, HasDerivativesByAnglesEvenAtNormalIncidenceAndTheHorizon) {
  using Jet = ceres::Jet<double, 3>;
  const auto table = std::make_shared<GridTable>(small_grid());
  const Model model = Model::by_name("tabulated").with_table(table);
  const std::vector<Jet> none;
  const Geometry<double> g = degrees(20, 33, 71);
  const Mueller<Jet> m = evaluate<Jet>(model, none, 0.633,
                                       Geometry<Jet>{{g.theta_i, 0}, {g.theta_r, 1}, {g.phi_r, 2}});
  for (int angle = 0; angle < 3; ++angle) {
    const auto at = [&](double change) {
      Geometry<double> moved = g;
      (angle == 0 ? moved.theta_i : angle == 1 ? moved.theta_r : moved.phi_r) += change;
      return table->at(0.633, moved);
    };
    const Mueller<double> difference = (at(1e-3) - at(-1e-3)) * 500.0;
    for (int k = 0; k < 16; ++k) {
      EXPECT_NEAR(element(m, k / 4, k % 4).v[angle], element(difference, k / 4, k % 4), 1e-8);
      EXPECT_EQ(element(m, k / 4, k % 4).a, element(table->at(0.633, g), k / 4, k % 4));
    }
  }
  for (const Geometry<double>& edge : {degrees(0, 20, 0), degrees(30, 89.9999, 10)}) {
    const Mueller<Jet> at_edge = evaluate<Jet>(
        model, none, 0.633, Geometry<Jet>{{edge.theta_i, 0}, {edge.theta_r, 1}, {edge.phi_r, 2}});
    for (int angle = 0; angle < 3; ++angle)
      EXPECT_LT(std::abs(element(at_edge, 0, 0).v[angle]), 100.0);
  }
}

TEST(TableDhr, OfALambertianGridIsItsReflectance) {
  const GridTable table({{0}, {0}, {0}, {0.5}}, {0.8 / optics::pi}, 1, "white");
  const Model model = Model::by_name("tabulated").with_table(std::make_shared<GridTable>(table));
  const Dhr d = dhr(model, {}, 0.5, radians(50));
  EXPECT_NEAR(d.unpolarized, 0.8, 1e-9);
  EXPECT_LT(d.accuracy, 1e-5);
}

TEST(TableDhr, OfAFineGridApproachesItsSource) {
  GridAxes axes{{40}, steps(0, 90, 0.5), steps(0, 180, 1.5), {0.633}};
  const Model model =
      Model::by_name("tabulated")
          .with_table(std::make_shared<GridTable>(sampled_grid(std::move(axes), 16)));
  const Dhr table = dhr(model, {}, 0.633, radians(40));
  const Dhr truth = dhr(source_model, source_values, 0.633, radians(40));
  EXPECT_NEAR(table.unpolarized, truth.unpolarized, 2e-4);
  EXPECT_NEAR(table.s, truth.s, 2e-4);
  EXPECT_NEAR(table.p, truth.p, 2e-4);
}

TEST(TableDhr, IsTheSameWithoutKnowingWhereTheTableHasKinksToTheAccuracyItStates) {
  const auto grid = std::make_shared<GridTable>(small_grid());
  const Model exact = Model::by_name("tabulated").with_table(grid);
  const Model blind = Model::by_name("tabulated").with_table(std::make_shared<Unstructured>(grid));
  for (const double theta : {0.0, 37.0, 75.0}) {
    const Dhr a = dhr(exact, {}, 0.633, radians(theta));
    const Dhr b = dhr(blind, {}, 0.633, radians(theta));
    EXPECT_LT(b.accuracy, 3e-5) << theta;
    EXPECT_NEAR(a.unpolarized, b.unpolarized, b.accuracy) << theta;
    EXPECT_NEAR(a.s, b.s, 2.0 * b.accuracy) << theta;
  }
}

}  // namespace
}  // namespace umov::brdf
