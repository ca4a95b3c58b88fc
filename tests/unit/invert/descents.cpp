// How surely the fit finds its optimum: from anywhere, from any seed, and idle terms as well.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "host/invert/box_quadratic.hpp"
#include "host/invert/descent.hpp"
#include "host/invert/invert.hpp"
#include "host/invert/starts.hpp"
#include "tests/unit/invert/synthetic_measurement.hpp"

namespace umov::invert {
namespace {

TEST(Descents, FromAnywhereWithinTheLimitsEndAtTheSameOptimum) {
  test::Scene scene = test::red_gloss();
  scene.relative_noise = 0.002;
  const auto made = test::make(scene, 3);
  const Observations data = observations(made.table, 0);
  const brdf::Model model = brdf::Model::by_name(scene.model);
  const Layout layout(model, data.wavelengths_nm(), {});
  const Priors priors;
  const Descent descent({layout, data, priors, {.huber_sigma = 4}});
  std::mt19937_64 engine(7);
  std::uniform_real_distribution<double> uniform;
  constexpr int starts = 20;
  std::vector<double> ends;
  for (int i = 0; i < starts; ++i) {
    std::vector<double> x;
    for (const FreeParameter& free : layout.free()) {
      const Coordinate& k = free.coordinate;
      const double share = uniform(engine);
      // Half of them uniform in the parameter, half in its coordinate: lengths over all decades.
      x.push_back(i % 2 == 0 ? k.to_x(k.lo + share * (k.hi - k.lo))
                             : k.lo_x() + share * (k.hi_x() - k.lo_x()));
    }
    ends.push_back(descent.from(x).objective);
  }
  const double best = *std::min_element(ends.begin(), ends.end());
  EXPECT_NEAR(best, static_cast<double>(data.size()),
              6 * std::sqrt(2.0 * static_cast<double>(data.size())));
  EXPECT_GE(
      std::count_if(ends.begin(), ends.end(), [&](double v) { return v <= best * (1 + 1e-6); }),
      19);
}

TEST(Descents, TheMultiStartEndsAtTheSameOptimumWhateverItsSeed) {
  test::Scene scene = test::red_gloss();
  for (auto& values : scene.truth) values[7] = 0;  // a forward lobe that is not there
  const auto made = test::make(scene, 4);
  Options options;
  options.dhr = options.held_out = false;
  std::vector<double> ends;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    options.seed = seed;
    ends.push_back(invert(made.table, options).objective);
  }
  for (const double end : ends) EXPECT_NEAR(end, ends.front(), 1e-6 * ends.front());
}

TEST(Descents, ATermIsFoundWithTheShapesThatMeanNothingWithoutIt) {
  const auto made = test::make(test::red_gloss(), 1);
  const Observations data = observations(made.table, 0);
  const auto terms_of = [&](const char* name) {
    const brdf::Model model = brdf::Model::by_name(name);
    const Layout layout(model, data.wavelengths_nm(), {});
    std::vector<std::string> out;
    for (const Term& term : terms_with_shapes(layout, data, linear_parameters(layout, data))) {
      std::string text = model.parameters()[term.weight].name + ":";
      for (const std::size_t shape : term.shapes) text += " " + model.parameters()[shape].name;
      out.push_back(text);
    }
    return out;
  };
  EXPECT_EQ(
      terms_of("li-torrance"),
      (std::vector<std::string>{"k_dd: sigma_um tau_um", "k_fs: fs_width_deg fs_polarization"}));
  EXPECT_EQ(terms_of("ward+lambertian"), (std::vector<std::string>{"0.ks: 0.alpha_x 0.alpha_y"}));
}

TEST(Descents, ABoxedQuadraticEndsWhereNoCoordinateCanGain) {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 200; ++trial) {
    constexpr Eigen::Index n = 6;
    Eigen::MatrixXd j(8, n);
    for (double& value : j.reshaped()) value = normal(engine);
    j.col(1) = j.col(0) + 1e-4 * j.col(1);  // nearly the same direction twice
    const Eigen::MatrixXd a = j.transpose() * j;
    Eigen::VectorXd b(n);
    for (double& value : b) value = 3 * normal(engine);
    const Eigen::VectorXd lo = Eigen::VectorXd::Constant(n, -0.5), hi = Eigen::VectorXd::Ones(n);
    const Eigen::VectorXd p = minimum_in_box(a, b, lo, hi, Eigen::VectorXd::Zero(n));
    const Eigen::VectorXd slope = a * p + b;
    for (Eigen::Index i = 0; i < n; ++i) {
      ASSERT_GE(p[i], lo[i]);
      ASSERT_LE(p[i], hi[i]);
      if (p[i] == lo[i]) {
        EXPECT_GE(slope[i], -1e-6);
      } else if (p[i] == hi[i]) {
        EXPECT_LE(slope[i], 1e-6);
      } else {
        EXPECT_NEAR(slope[i], 0, 1e-6);
      }
    }
  }
}

}  // namespace
}  // namespace umov::invert
