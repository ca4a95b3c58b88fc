// The parts of the inversion one by one: derivatives, coordinates, scale, starts, the fit's file.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "host/brdf/dhr.hpp"
#include "host/errors/error.hpp"
#include "host/invert/dhr_gradient.hpp"
#include "host/invert/invert.hpp"
#include "host/invert/residuals.hpp"
#include "host/invert/starts.hpp"
#include "tests/unit/invert/synthetic_measurement.hpp"

namespace umov::invert {
namespace {

TEST(Derivatives, OfResidualsAgreeWithDifferences) {
  test::Scene scene = test::red_gloss();
  scene.gain_sigma = 0.01;
  const auto made = test::make(scene, 1);
  const Observations data = observations(made.table, 0);
  const brdf::Model model = brdf::Model::by_name(scene.model);
  Options options;
  const Layout layout(model, data.wavelengths_nm(), options);
  std::vector<double> x(layout.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto& free = layout.free()[i];
    x[i] = free.coordinate.to_x(1.1 * scene.truth[free.wavelength.value_or(0)][free.parameter]);
  }
  const std::vector<double> c{0.3, -0.4, 0.5};
  const Weighting weighting{.scale = 1.5, .huber_sigma = 2};
  const Linearisation at = linearise(layout, data, x, c, weighting);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double step = 1e-6 * std::max(std::abs(x[i]), 1e-3);
    auto up = x, down = x;
    up[i] += step;
    down[i] -= step;
    const Eigen::VectorXd slope = (linearise(layout, data, up, c, weighting).r -
                                   linearise(layout, data, down, c, weighting).r) /
                                  (2 * step);
    const auto column = static_cast<Eigen::Index>(i);
    EXPECT_LT((slope - at.by_x.col(column)).norm(), 1e-5 * slope.norm()) << layout.label(i);
  }
  for (std::size_t k = 0; k < c.size(); ++k) {
    auto up = c, down = c;
    up[k] += 1e-5;
    down[k] -= 1e-5;
    const Eigen::VectorXd slope = (linearise(layout, data, x, up, weighting).r -
                                   linearise(layout, data, x, down, weighting).r) /
                                  2e-5;
    EXPECT_LT((slope - at.by_c.col(static_cast<Eigen::Index>(k))).norm(), 1e-6 * slope.norm());
  }
}

TEST(Derivatives, InSeveralPassesAreThoseOfOne) {
  // Seventeen parameters: more than one pass of dual numbers carries.
  const brdf::Model model = brdf::Model::by_name("li-torrance+microfacet+ward");
  const std::vector<double> values = model.initial_values();
  std::vector<int> active(values.size());
  for (std::size_t i = 0; i < active.size(); ++i) active[i] = static_cast<int>(i);
  ASSERT_GT(active.size(), 12U);
  const std::array channels{channel_of(0, 90), channel_of(30, formats::open_axis)};
  const View view{{0.5, 0.6, 0.2}};
  std::vector<double> f(2), all(2 * active.size());
  evaluate_channels(model, values, active, 0.6, view, channels, f, all);
  for (std::size_t a = 0; a < active.size(); ++a) {
    const std::array one{active[a]};
    std::vector<double> g(2), single(2);
    evaluate_channels(model, values, one, 0.6, view, channels, g, single);
    for (std::size_t c = 0; c < 2; ++c) {
      EXPECT_DOUBLE_EQ(single[c], all[c * active.size() + a]) << model.parameters()[a].name;
      EXPECT_DOUBLE_EQ(f[c], g[c]);
    }
  }
}

TEST(Derivatives, OfReflectanceAgreeWithDifferencesToTheUncertaintysNeed) {
  const test::Scene scene = test::red_gloss();
  const brdf::Model model = brdf::Model::by_name(scene.model);
  const Layout layout(model, scene.wavelengths_nm, {});
  std::vector<double> x(layout.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto& free = layout.free()[i];
    x[i] = free.coordinate.to_x(scene.truth[free.wavelength.value_or(0)][free.parameter]);
  }
  for (const double theta_i : {0.0, optics::radians(30), optics::radians(60)}) {
    double value = 0;
    const Eigen::VectorXd gradient = dhr_gradient(layout, x, 1, theta_i, &value);
    const auto reflectance = [&](const std::vector<double>& at) {
      return brdf::dhr(model, layout.values(1, at), 0.633, theta_i).unpolarized;
    };
    EXPECT_NEAR(value, reflectance(x), 0.02 * value);
    for (std::size_t i = 0; i < x.size(); ++i) {
      auto up = x, down = x;
      const double step = 1e-3 * std::max(std::abs(x[i]), 0.01);
      up[i] += step;
      down[i] -= step;
      const double slope = (reflectance(up) - reflectance(down)) / (2 * step);
      EXPECT_NEAR(gradient[static_cast<Eigen::Index>(i)], slope, 0.03 * std::abs(slope) + 2e-3)
          << layout.label(i) << " at " << optics::degrees(theta_i);
    }
  }
}

TEST(Coordinates, MapThereAndBackAndGiveTheirSlope) {
  for (const Scale scale : {Scale::linear, Scale::logarithmic, Scale::square}) {
    const Coordinate k{scale, 0.1, 20};
    for (const double p : {0.1, 0.5, 3.0, 20.0}) {
      const double x = k.to_x(p);
      EXPECT_NEAR(k.to_parameter(x), p, 1e-12 * p);
      const double inside = k.to_x(0.5 * (p + 1));
      EXPECT_NEAR(k.slope(inside),
                  (k.to_parameter(inside + 1e-6) - k.to_parameter(inside - 1e-6)) / 2e-6, 1e-4);
    }
    EXPECT_LE(k.to_parameter(k.lo_x() - 1), 0.1 + 1e-12);
    EXPECT_DOUBLE_EQ(k.to_parameter(k.hi_x() + 1), 20);
  }
}

TEST(ResidualScale, TellsOutliersFromMisfit) {
  Eigen::VectorXd r(1000);
  for (Eigen::Index i = 0; i < r.size(); ++i) r[i] = i % 2 == 0 ? 1 : -1;
  EXPECT_NEAR(residual_scale(r, 4, 0), 1, 1e-9);
  r.head(10).setConstant(500);  // one in a hundred, far off
  EXPECT_NEAR(residual_scale(r, 4, 0), std::sqrt(0.99 / 0.84), 1e-6);
  r.head(200).setConstant(30);  // a fifth of the points: the model does not fit
  EXPECT_GT(residual_scale(r, 4, 0), 7);
}

TEST(HuberRoot, SquaresToHubersLossWithItsSlope) {
  for (const double r : {-9.0, -3.0, 0.5, 5.0}) {
    double slope = 0;
    const double root = huber_root(r, 4, slope);
    EXPECT_NEAR(root * root, std::abs(r) <= 4 ? r * r : 8 * std::abs(r) - 16, 1e-12);
    double ignored = 0;
    EXPECT_NEAR(slope, (huber_root(r + 1e-6, 4, ignored) - huber_root(r - 1e-6, 4, ignored)) / 2e-6,
                1e-6);
  }
}

TEST(StartingValues, LinearCoefficientsAreFoundInAnyModel) {
  const auto made = test::make(test::red_gloss(), 1);
  const Observations data = observations(made.table, 0);
  for (const auto& [name, expected] : {std::pair<std::string, std::vector<std::string>>{
                                           "li-torrance", {"k_dd", "k_udf", "k_uds", "k_fs"}},
                                       {"microfacet+nef", {"1.rho_d1", "1.rho_d2"}},
                                       {"ward+lambertian", {"0.ks", "1.rho"}}}) {
    const brdf::Model model = brdf::Model::by_name(name);
    const Layout layout(model, data.wavelengths_nm(), {});
    const auto linear = linear_parameters(layout, data);
    std::vector<std::string> found;
    for (std::size_t i = 0; i < linear.size(); ++i) {
      if (linear[i]) found.push_back(model.parameters()[i].name);
    }
    EXPECT_EQ(found, expected) << name;
  }
}

TEST(StartingValues, LobeWidthTellsTheSlope) {
  for (const double slope : {0.05, 0.12, 0.20}) {
    test::Scene scene = test::black_paint();
    for (auto& values : scene.truth) values[2] = slope;
    scene.theta_i_deg = {10, 30};
    scene.theta_r_step = 1;
    const Observations data = observations(test::make(scene, 1).table, 0);
    EXPECT_NEAR(lobe_slope(data), slope, 0.25 * slope);
  }
}

TEST(StartingValues, AUsersStartIsKept) {
  const auto made = test::make(test::black_paint(), 1);
  Options options;
  options.model = "microfacet+nef";
  options.start = {{"0.slope_rms", std::nullopt, 0.2}};
  for (const auto& value : starting_values(made.table, options)) {
    if (value.name == "0.slope_rms") {
      EXPECT_NEAR(value.values[0], 0.2, 1e-12);
    } else if (value.name == "0.bias") {
      EXPECT_TRUE(value.fixed);
    }
  }
}

TEST(Thinning, KeepsTheTopOfEveryLobeAndFewPointsElsewhere) {
  test::Scene scene = test::black_paint();
  scene.theta_r_step = 0.5;
  const Observations all = observations(test::make(scene, 1).table, 0);
  const Observations thin = thinned(all, 20, 0.03);
  EXPECT_LE(thin.spectra[0].sites.size(), 2 * 22U);
  EXPECT_GE(thin.spectra[0].sites.size(), 2 * 15U);
  const auto top = [](const Observations& data) {
    double out = 0;
    for (const auto& point : data.spectra[0].points) out = std::max(out, point.brdf_per_sr);
    return out;
  };
  EXPECT_DOUBLE_EQ(top(thin), top(all));
}

TEST(FitFile, KeepsEveryMember) {
  test::Scene scene = test::red_gloss();
  scene.gain_sigma = 0.01;
  Options options;
  options.starts = 2;
  options.dhr_theta_i_deg = {30};
  formats::FitResult fit = invert(test::make(scene, 2).table, options);
  fit.program = "umov test";
  fit.command = "umov invert \"a b\"";
  fit.data_file = "brdf.h5";
  const std::string text = formats::fit_to_json(fit);
  EXPECT_EQ(formats::fit_to_json(formats::fit_from_json(text, "fit.json")), text);
  const auto again = formats::fit_from_json(text, "fit.json");
  EXPECT_EQ(again.values_at(1), fit.values_at(1));
  EXPECT_EQ(again.data_sha256.size(), 64U);
  EXPECT_EQ(again.g2_held_out, fit.g2_held_out);
  const std::string path = testing::TempDir() + "umov_fit_test.json";
  formats::write_fit(path, fit);
  EXPECT_EQ(formats::fit_to_json(formats::read_fit(path)), text);
  std::filesystem::remove(path);
}

TEST(FitFile, CorrelationsAreTriplesAndALimitHasNoStandardError) {
  formats::FitResult fit;
  fit.model = "li-torrance";
  fit.wavelengths_nm = {532, 633};
  formats::FitParameter k;
  k.name = "k_udf";
  k.shared = false;
  k.estimates = {{0.1, 0.0, 0.2, 0.05, "", true}, {0.0, 0.0, 0.3, 0.07, "lower", false}};
  fit.parameters = {k};
  fit.correlations = {{"k_udf", "k_uds", -0.99, 532, 532}, {"sigma_um", "tau_um", 0.98, {}, {}}};
  fit.dhr = {{532, 30, 0.5, 0.49, 0.51, 0.02}};
  const std::string text = formats::fit_to_json(fit);
  std::string bare;
  for (const char c : text)
    if (c != ' ' && c != '\n') bare += c;
  EXPECT_NE(bare.find(R"("correlations":[["k_udf","k_uds",-0.99],["sigma_um","tau_um",0.98]])"),
            std::string::npos);
  EXPECT_NE(bare.find(R"("correlations_wavelength_nm":[[532.0,532.0],[null,null]])"),
            std::string::npos);
  EXPECT_NE(bare.find(R"("standard_error":null)"), std::string::npos);
  const formats::FitResult again = formats::fit_from_json(text, "fit.json");
  EXPECT_EQ(again.correlations.at(0).first_wavelength_nm, 532);
  EXPECT_FALSE(again.correlations.at(1).second_wavelength_nm.has_value());
  EXPECT_EQ(again.parameters.at(0).at(0).standard_error, 0.05);
  EXPECT_EQ(again.parameters.at(0).at(1).standard_error, 0);
  EXPECT_EQ(again.dhr.at(0).mirror, 0.02);
  EXPECT_EQ(formats::fit_to_json(again), text);
}

TEST(FitFile, RefusesWhatIsNotAFit) {
  const auto refusal = [](const std::string& text) {
    try {
      formats::fit_from_json(text, "f.json");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal("{\"model\":\n oops").find("f.json:2"), std::string::npos);
  EXPECT_NE(refusal("[]").find("not a JSON object"), std::string::npos);
  EXPECT_NE(refusal("{\"model\":\"nef\"}").find("wavelengths_nm"), std::string::npos);
  EXPECT_NE(refusal(R"({"model":"nef","wavelengths_nm":[532,633],
      "parameters":{"rho_d1":[{"value":1,"lo":0,"hi":2}]}})")
                .find("1 values for 2 wavelengths"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"model":"nef","wavelengths_nm":[532],
      "parameters":{"rho_d1":{"value":1,"lo":0}}})")
                .find("hi"),
            std::string::npos);
  EXPECT_THROW(formats::read_fit("/nonexistent/fit.json"), Error);
}

}  // namespace
}  // namespace umov::invert
