// Derivatives carried by dual numbers against differences, and their finiteness where frames
// degenerate.
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/brdf/evaluate.hpp"
#include "host/brdf/gradient.hpp"
#include "tests/unit/brdf/variants.hpp"

namespace umov::brdf {
namespace {

using Jet = ceres::Jet<double, 12>;
using optics::element;
using optics::Mueller;
using optics::radians;

const Geometry<double> geometries[] = {{0.0, 0.0, 0.0},  {0.0, 0.4, 1.0}, {0.6, 0.6, 0.0},
                                       {0.6, -0.6, 0.0}, {0.6, 0.0, 0.5}, {0.5, 0.8, 0.3},
                                       {1.2, -0.3, 0.0}, {0.7, 0.9, 2.5}, {1.45, 1.4, 0.1}};

std::vector<Jet> jets(const std::vector<double>& values) {
  std::vector<Jet> out;
  for (std::size_t i = 0; i < values.size(); ++i) out.emplace_back(values[i], static_cast<int>(i));
  return out;
}

Geometry<Jet> constant(const Geometry<double>& g) {
  return {Jet(g.theta_i), Jet(g.theta_r), Jet(g.phi_r)};
}

TEST(Gradients, AgreeWithDifferencesInEveryElement) {
  for (const Variant& v : all_variants()) {
    const Model model = Model::by_name(v.name);
    const std::vector<Jet> dual = jets(v.values);
    for (const Geometry<double>& g : geometries) {
      const Mueller<Jet> m = evaluate<Jet>(model, dual, 0.633, g);
      for (std::size_t k = 0; k < v.values.size(); ++k) {
        const double h = 1e-5 * v.values[k];
        std::vector<double> up = v.values, down = v.values;
        up[k] += h;
        down[k] -= h;
        const Mueller<double> a = evaluate<double>(model, up, 0.633, g);
        const Mueller<double> b = evaluate<double>(model, down, 0.633, g);
        for (int i = 0; i < 16; ++i) {
          const double difference =
              (element(a, i / 4, i % 4) - element(b, i / 4, i % 4)) / (2.0 * h);
          const double scale = element(m, 0, 0).a / v.values[k];
          // Logarithmic slopes of some hundred occur far out on narrow lobes; their curvature
          // limits differences.
          EXPECT_NEAR(element(m, i / 4, i % 4).v[static_cast<Eigen::Index>(k)], difference,
                      1e-6 * scale + 1e-6 * std::abs(difference))
              << v.name << " " << model.parameters()[k].name << " element " << i / 4 << i % 4
              << " at " << g.theta_i << " " << g.theta_r << " " << g.phi_r;
        }
      }
    }
  }
}

TEST(Gradients, OfTheMirrorPartAgreeWithDifferences) {
  const Model model = Model::by_name("li-torrance");
  const std::vector<double> values{1.5, 0.05, 0.05, 1.0, 0.9, 0.02, 0.4, 0.1, 12.0, 0.6};
  for (const double theta : {0.0, 0.5, 1.4}) {
    const Mueller<Jet> m = mirror_reflectance<Jet>(model, jets(values), 0.633, theta);
    EXPECT_GT(element(m, 0, 0).a, 0.0);
    for (std::size_t k = 0; k < 5; ++k) {
      const double h = 1e-5 * values[k];
      std::vector<double> up = values, down = values;
      up[k] += h;
      down[k] -= h;
      const double difference =
          (element(mirror_reflectance<double>(model, up, 0.633, theta), 0, 0) -
           element(mirror_reflectance<double>(model, down, 0.633, theta), 0, 0)) /
          (2.0 * h);
      EXPECT_NEAR(element(m, 0, 0).v[static_cast<Eigen::Index>(k)], difference,
                  1e-7 * element(m, 0, 0).a / values[k]);
    }
  }
}

TEST(Gradients, StayFiniteAndTheSameWhenTheAnglesAreDualNumbersToo) {
  for (const Variant& v : all_variants()) {
    const Model model = Model::by_name(v.name);
    const std::vector<Jet> dual = jets(v.values);
    for (const Geometry<double>& g : geometries) {
      const Mueller<Jet> fixed = evaluate<Jet>(model, dual, 0.633, g);
      const Mueller<Jet> free = evaluate<Jet>(model, dual, 0.633, constant(g));
      for (int i = 0; i < 16; ++i) {
        const Jet& x = element(fixed, i / 4, i % 4);
        const Jet& y = element(free, i / 4, i % 4);
        const double scale = element(fixed, 0, 0).a;
        ASSERT_NEAR(x.a, y.a, 1e-10 * scale) << v.name;
        for (Eigen::Index k = 0; k < 12; ++k) {
          ASSERT_TRUE(std::isfinite(y.v[k])) << v.name << " " << i << " " << k;
          ASSERT_NEAR(x.v[k], y.v[k], 1e-9 * (std::abs(x.v[k]) + scale)) << v.name;
        }
      }
    }
  }
}

TEST(Gradients, AreFiniteForATransparentMaterial) {
  // κ = 0 exactly, where a square root of a complex number could divide by zero.
  for (const char* name : {"microfacet", "ggx", "he-torrance", "li-torrance"}) {
    const Model model = Model::by_name(name);
    const std::vector<Jet> dual = jets(model.initial_values());
    for (const Geometry<double>& g : geometries) {
      const Mueller<Jet> m = evaluate<Jet>(model, dual, 0.633, g);
      for (int i = 0; i < 16; ++i) {
        for (Eigen::Index k = 0; k < 12; ++k)
          ASSERT_TRUE(std::isfinite(element(m, i / 4, i % 4).v[k])) << name;
      }
    }
  }
}

TEST(Gradients, WithRespectToAnglesAgreeWithDifferences) {
  for (const Variant& v : all_variants()) {
    const Model model = Model::by_name(v.name);
    const std::vector<Jet> dual(v.values.begin(), v.values.end());
    const double angles[3] = {0.5, 0.8, 0.3};
    const Geometry<Jet> g{Jet(angles[0], 0), Jet(angles[1], 1), Jet(angles[2], 2)};
    const Mueller<Jet> m = evaluate<Jet>(model, dual, 0.633, g);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = [&](double change) {
        double a[3] = {angles[0], angles[1], angles[2]};
        a[k] += change;
        return evaluate<double>(model, v.values, 0.633, Geometry<double>{a[0], a[1], a[2]});
      };
      const double h = 1e-6;
      const Mueller<double> up = at(h), down = at(-h);
      for (int i = 0; i < 16; ++i) {
        const double difference =
            (element(up, i / 4, i % 4) - element(down, i / 4, i % 4)) / (2.0 * h);
        EXPECT_NEAR(element(m, i / 4, i % 4).v[static_cast<Eigen::Index>(k)], difference,
                    1e-6 * (element(m, 0, 0).a + std::abs(difference)))
            << v.name << " angle " << k << " element " << i / 4 << i % 4;
      }
    }
  }
}

TEST(Gradients, AnyDualNumberWithValueAndGradientServes) {
  using Small = Gradient<2>;
  const optics::FresnelReflection<Small> r =
      optics::fresnel_reflection(Small(1.5, 0), Small(0.1, 1), Small(0.7));
  const optics::FresnelReflection<ceres::Jet<double, 2>> s = optics::fresnel_reflection(
      ceres::Jet<double, 2>(1.5, 0), ceres::Jet<double, 2>(0.1, 1), ceres::Jet<double, 2>(0.7));
  EXPECT_DOUBLE_EQ(r.mean.a, s.mean.a);
  EXPECT_NEAR(r.mean.v[0], s.mean.v[0], 1e-15);
  EXPECT_NEAR(r.mean.v[1], s.mean.v[1], 1e-15);
}

}  // namespace
}  // namespace umov::brdf
