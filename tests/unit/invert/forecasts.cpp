// What a fit foretells: directions with intervals, rival models, and further measurements.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/invert/comparison.hpp"
#include "host/invert/directions.hpp"
#include "tests/unit/invert/synthetic_measurement.hpp"

namespace umov::invert {
namespace {

TEST(Forecasts, BrdfAndDolpOffThePlaneAreCoveredByTheirIntervals) {
  test::Scene scene = test::red_gloss();
  scene.gain_sigma = 0.005;
  formats::FitResult known;  // the truth as a fit without uncertainty
  known.model = scene.model;
  known.wavelengths_nm = scene.wavelengths_nm;
  const brdf::Model model = brdf::Model::by_name(scene.model);
  for (std::size_t i = 0; i < model.parameters().size(); ++i) {
    formats::FitParameter parameter;
    parameter.name = model.parameters()[i].name;
    parameter.shared = false;
    for (const auto& values : scene.truth) {
      formats::Estimate e;
      e.value = values[i];
      parameter.estimates.push_back(e);
    }
    known.parameters.push_back(parameter);
  }
  const std::vector<Direction> directions = {{532, 40, 30, 0},   {532, 30, 40, 60},
                                             {633, 30, 20, 90},  {633, 50, 45, 20},
                                             {814, 40, 60, 120}, {814, 20, 65, 0}};
  const auto truth = predict_directions(FittedModel(known), directions, 1);
  EXPECT_EQ(truth[0].brdf.u, 0);
  int brdf = 0, dolp = 0;
  constexpr int seeds = 40;
  for (int seed = 0; seed < seeds; ++seed) {
    const auto fit =
        invert(test::make(scene, 500 + static_cast<std::uint64_t>(seed)).table, test::quick(scene));
    const auto said = predict_directions(FittedModel(fit), directions, 1);
    for (std::size_t i = 0; i < said.size(); ++i) {
      brdf += said[i].brdf.lo <= truth[i].brdf.value && truth[i].brdf.value <= said[i].brdf.hi;
      dolp += said[i].dolp.lo <= truth[i].dolp.value && truth[i].dolp.value <= said[i].dolp.hi;
      EXPECT_GT(said[i].brdf.u, 0.003 * said[i].brdf.value) << "the gain's uncertainty at least";
      EXPECT_LT(said[i].brdf.u, 0.02 * said[i].brdf.value);
    }
  }
  const double all = seeds * static_cast<double>(directions.size());
  std::cout << "BRDF " << brdf / all << ", DOLP " << dolp / all << "\n";
  EXPECT_GT(brdf / all, 0.88);
  EXPECT_LT(brdf / all, 0.995);
  EXPECT_GT(dolp / all, 0.88);
  EXPECT_LT(dolp / all, 0.995);
}

TEST(Forecasts, AFitReadFromItsFileSaysTheSame) {
  test::Scene scene = test::red_gloss();
  for (auto& values : scene.truth) values[1] = 0;  // extinction on its limit
  const auto fit = invert(test::make(scene, 2).table, test::quick(scene));
  const auto again = formats::fit_from_json(formats::fit_to_json(fit), "fit");
  const auto directions = direction_grid("out-of-plane", fit.wavelengths_nm, {30});
  EXPECT_EQ(directions.size(), 3U * 5 * 7);
  EXPECT_EQ(directions_csv(predict_directions(FittedModel(again), directions, 1)),
            directions_csv(predict_directions(FittedModel(fit), directions, 3)));
}

TEST(Forecasts, DirectionsAreReadFromAFileAndBadOnesRefusedWithTheirLine) {
  const std::string path = testing::TempDir() + "umov_directions_test.csv";
  formats::replace_file(path, "theta_i_deg,theta_r_deg,phi_r_deg\n30,20,0\n30,40,90\n");
  const auto read = read_directions(path, {532, 633});
  ASSERT_EQ(read.size(), 4U);
  EXPECT_EQ(read[3].wavelength_nm, 633);
  EXPECT_EQ(read[3].phi_r_deg, 90);
  formats::replace_file(
      path, "wavelength_nm,theta_i_deg,theta_r_deg,phi_r_deg\n532,30,20,0\n532,95,0,0\n");
  try {
    read_directions(path, {532});
    FAIL() << "95 degrees is below the horizon";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(":3:theta_i_deg"), std::string::npos) << error.what();
  }
  std::filesystem::remove(path);
  EXPECT_THROW(direction_grid("everywhere", {532}, {30}), Error);
}

TEST(Comparison, TheModelThatMadeTheDataForetellsThemBest) {
  const test::Scene scene = test::black_paint();
  const auto made = test::make(scene, 5);
  Options options = test::quick(scene);
  const std::vector<std::string> models{"ggx+nef",       "velvet", "microfacet+nef",
                                        "interpolation", "nef",    "ggx+nef"};
  const auto held_out = every_fifth_row(made.table);
  const Comparison one = compare_models(made.table, held_out, models, options);
  ASSERT_EQ(one.contenders.size(), 5U) << "named twice, tried once";
  EXPECT_EQ(one.contenders[0].model, "microfacet+nef");
  EXPECT_NEAR(one.contenders[0].chi2_per_point, 1, 0.4);
  EXPECT_LT(one.contenders[0].median_relative, 0.02);
  ASSERT_TRUE(one.contenders[0].fit);
  EXPECT_EQ(one.contenders[0].parameters, 8U);
  EXPECT_EQ(one.contenders.back().model, "velvet");
  EXPECT_NE(one.contenders.back().failure.find("velvet"), std::string::npos);
  for (std::size_t i = 1; i + 1 < one.contenders.size(); ++i) {
    EXPECT_LT(one.contenders[i].log_density, one.contenders[i - 1].log_density);
    if (one.contenders[i].bic) {
      EXPECT_GT(*one.contenders[i].bic, *one.contenders[0].bic);
    }
  }
  options.threads = 3;
  const Comparison many = compare_models(made.table, held_out, models, options);
  for (std::size_t i = 0; i < one.contenders.size(); ++i) {
    EXPECT_EQ(many.contenders[i].model, one.contenders[i].model);
    EXPECT_EQ(many.contenders[i].log_density, one.contenders[i].log_density);
  }
  EXPECT_THROW(
      compare_models(made.table, std::vector<bool>(held_out.size(), false), models, options),
      Error);
}

TEST(Comparison, TheLibraryHasSumsOfLobesAndNoModelThatWantsAFile) {
  const auto models = library_models();
  const auto has = [&](const char* name) {
    return std::find(models.begin(), models.end(), name) != models.end();
  };
  EXPECT_TRUE(has("li-torrance"));
  EXPECT_TRUE(has("ggx+nef"));
  EXPECT_TRUE(has("microfacet+microfacet+lambertian"));
  EXPECT_FALSE(has("tabulated"));
}

TEST(FurtherData, DoWhatTheLinearisedFitForetells) {
  test::Scene scene = test::red_gloss();
  scene.states = {{formats::open_axis, formats::open_axis}};
  scene.theta_i_deg = {20, 30};
  scene.theta_r_step = 2.5;
  const auto sigma = [](const formats::FitResult& fit, const std::string& name) {
    const auto& names = fit.covariance.names;
    const auto i =
        static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    return std::sqrt(fit.covariance.values.at(i * names.size() + i));
  };
  Options options = test::quick(scene);
  // Only the two diffuse coefficients and the lobe's weight, so that nothing bends in between.
  const brdf::Model model = brdf::Model::by_name(scene.model);
  for (std::size_t i : {0U, 1U, 2U, 3U, 7U, 8U, 9U}) {
    const auto& p = model.parameters()[i];
    for (std::size_t w = 0; w < (p.spectral ? 3U : 1U); ++w) {
      options.fix.push_back({p.name,
                             p.spectral ? std::optional(scene.wavelengths_nm[w]) : std::nullopt,
                             scene.truth[w][i]});
    }
  }
  const auto before = invert(test::make(scene, 1).table, options);
  const auto remedy = std::find_if(before.remedies.begin(), before.remedies.end(),
                                   [](const formats::FitResult::Remedy& r) {
                                     return r.data == "rows at an incidence of 75 degrees" &&
                                            r.parameters.front() == "k_udf 633 nm";
                                   });
  ASSERT_NE(remedy, before.remedies.end());
  EXPECT_LT(*remedy->correlation_now, -0.95);
  EXPECT_GT(*remedy->correlation_then, *remedy->correlation_now);
  EXPECT_TRUE(std::any_of(
      before.identifiability.begin(), before.identifiability.end(), [](const std::string& s) {
        return s.find("by unpolarised data in the plane of incidence") != std::string::npos;
      }));
  // Measure those rows: 75 degrees, from -80 to 80 in steps of 2.5, the same noise.
  test::Scene more = scene;
  more.theta_i_deg = {75};
  more.theta_r_from = -80;
  more.theta_r_to = 80;
  auto table = test::make(scene, 1).table;
  const auto extra = test::make(more, 2).table.points;
  auto& p = table.points;
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(p.theta_i_deg, extra.theta_i_deg);
  append(p.theta_r_deg, extra.theta_r_deg);
  append(p.phi_r_deg, extra.phi_r_deg);
  append(p.wavelength_nm, extra.wavelength_nm);
  append(p.polarizer_deg, extra.polarizer_deg);
  append(p.analyzer_deg, extra.analyzer_deg);
  append(p.brdf_per_sr, extra.brdf_per_sr);
  append(p.brdf_u, extra.brdf_u);
  append(p.used, extra.used);
  const auto after = invert(table, options);
  const double ratio = std::min(sigma(after, "k_udf 633 nm") / sigma(before, "k_udf 633 nm"),
                                sigma(after, "k_uds 633 nm") / sigma(before, "k_uds 633 nm"));
  EXPECT_NEAR(ratio, remedy->sigma_ratio, 0.1 * ratio);
}

}  // namespace
}  // namespace umov::invert
