// Samplers: do directions follow the density that is claimed, do weights add up to the reflectance,
// and do they stay bounded?
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"
#include "host/brdf/sampler.hpp"
#include "host/errors/error.hpp"
#include "tests/unit/brdf/sampling_statistics.hpp"
#include "tests/unit/brdf/variants.hpp"

namespace umov::brdf {
namespace {

using optics::element;
using optics::radians;
using statistics::Bins;
using statistics::chi_square;
using statistics::Fit;
using statistics::uniform;

struct Case {
  std::string name;
  std::vector<double> values;
  bool narrow = false;  ///< too narrow for bins of 5°
};

constexpr double wavelength_um = 0.633;

/// A table of what a plain Phong lobe and a base give, so that there is a measured-like model.
class CoarseTable : public Table {
 public:
  optics::Mueller<double> at(double, const Geometry<double>& g) const override {
    optics::Mueller<double> m(0.0);
    if (!(std::cos(g.theta_i) > 0.0) || !(std::cos(g.theta_r) > 0.0)) return m;
    // Steps of 5° in θr: a piecewise constant table, as hard on a sampler as any.
    const double step = radians(5.0);
    const double theta_r = (std::floor(g.theta_r / step) + 0.5) * step;
    const FacetFrame<double> f = facet_frame(Geometry<double>{g.theta_i, theta_r, g.phi_r});
    m[0][0] = 0.1 + std::exp(-4.0 * f.chord2);
    return m;
  }
  const std::vector<double>& wavelengths_um() const override { return wavelengths_; }
  bool polarised() const override { return false; }
  std::string description() const override { return "steps of 5 degrees"; }

 private:
  std::vector<double> wavelengths_{0.633};
};

Model model_of(const Case& c) {
  const Model model = Model::by_name(c.name);
  return model.needs_table() ? model.with_table(std::make_shared<CoarseTable>()) : model;
}

/// The variants every model test uses, and some more: smooth and rough.
std::vector<Case> cases() {
  std::vector<Case> list;
  for (const Variant& v : all_variants()) list.push_back({v.name, v.values, false});
  const std::vector<Case> more{
      {"microfacet", {1.5, 0.0, 0.01, 1.0}, true},
      {"microfacet", {0.05, 100.0, 0.8, 1.0}},
      {"microfacet:slopes=exponential", {0.05, 100.0, 0.2, 1.0}},
      {"microfacet:shadowing=vgroove,slopes=exponential", {0.05, 100.0, 0.2, 1.0}},
      {"ggx", {0.05, 100.0, 0.02}, true},
      {"ggx:shadowing=vgroove", {0.05, 100.0, 0.5}},
      {"he-torrance", {0.05, 100.0, 0.1, 200.0}, true},
      {"he-torrance", {0.05, 100.0, 0.4, 0.6}},
      {"li-torrance", {1.5, 0.05, 0.02, 20.0, 1.0, 0.0, 0.1, 0.4, 60.0, 0.6}, true},
      {"rayleigh-rice", {0.05, 100.0, 0.004, 0.1}},
      {"phong", {0.5, 2e4}, true},
      {"phong", {0.5, 0.5}},
      {"ward", {0.5, 0.05, 0.5}, true},
      {"tabulated", {}},
      {"tabulated+lambertian", {0.2}},
  };
  list.insert(list.end(), more.begin(), more.end());
  return list;
}

/// Prepared once for all tests.
const std::vector<std::pair<Case, Sampler>>& samplers() {
  static const std::vector<std::pair<Case, Sampler>> prepared = [] {
    std::vector<std::pair<Case, Sampler>> list;
    for (const Case& c : cases())
      list.emplace_back(c, Sampler(model_of(c), c.values, wavelength_um));
    return list;
  }();
  return prepared;
}

const double incidences[] = {0.0, 60.0, 85.0};

TEST(Sampler, DrawsDirectionsWithTheDensityItClaims) {
  const std::size_t comparisons = 2 * std::size(incidences) * samplers().size();
  const double least_p = 0.01 / static_cast<double>(comparisons);
  std::uint64_t seed = 1;
  for (const auto& [c, sampler] : samplers()) {
    for (const double degrees : incidences) {
      const double theta_i = radians(degrees);
      for (const Bins bins : {Bins::polar, Bins::about_mirror}) {
        if (bins == Bins::polar && (c.narrow || degrees != 60.0)) continue;
        const Fit fit = chi_square(
            sampler, [&](const Geometry<double>& g) { return sampler.pdf(g); },
            sampler.mirror_probability(theta_i), theta_i, bins, 20000, ++seed);
        EXPECT_GT(fit.p, least_p) << c.name << " at " << degrees << "°: chi2 " << fit.chi2
                                  << " over " << fit.bins << " bins";
        const double mirror = sampler.mirror_probability(theta_i);
        EXPECT_LE(fit.integral + mirror, 1.0 + 4e-3) << c.name << " at " << degrees;
        EXPECT_NEAR(fit.integral + mirror + fit.nothing, 1.0, 0.012) << c.name << " at " << degrees;
      }
    }
  }
}

TEST(Sampler, AWrongDensityFailsTheSameTest) {
  const Sampler sampler(Model::by_name("microfacet"), {1.5, 0.0, 0.2, 1.0}, wavelength_um);
  const Sampler wider(Model::by_name("microfacet"), {1.5, 0.0, 0.21, 1.0}, wavelength_um);
  const double theta_i = radians(60.0);
  for (const Bins bins : {Bins::polar, Bins::about_mirror}) {
    const auto claimed = [&](const Geometry<double>& g) { return sampler.pdf(g); };
    const auto p = [&](const statistics::Density& density) {
      return chi_square(sampler, density, 0.0, theta_i, bins, 20000, 7).p;
    };
    EXPECT_GT(p(claimed), 1e-4);
    EXPECT_LT(p([&](const Geometry<double>& g) { return wider.pdf(g); }), 1e-6);
    EXPECT_LT(p([&](const Geometry<double>& g) { return 1.03 * sampler.pdf(g); }), 1e-6);
    EXPECT_LT(p([&](const Geometry<double>& g) {
                return sampler.pdf({g.theta_i, g.theta_r, g.phi_r + radians(2.0)});
              }),
              1e-6);
  }
}

struct Moments {
  double mean, standard_error, greatest;
};

Moments moments(const Sampler& sampler, double theta_i, int count, std::uint64_t seed,
                std::size_t wavelength = 0) {
  double sum = 0.0, squares = 0.0, greatest = 0.0;
  for (int i = 0; i < count; ++i) {
    const auto u = uniform(seed, static_cast<std::uint64_t>(i));
    const auto sample = sampler.sample(theta_i, u[0], u[1], u[2], wavelength);
    if (!sample) continue;
    const double w = element(sample->weight, 0, 0);
    sum += w;
    squares += w * w;
    greatest = std::max(greatest, w);
  }
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean) / count), greatest};
}

TEST(Sampler, WeightsAverageToTheReflectance) {
  std::uint64_t seed = 500;
  for (const auto& [c, sampler] : samplers()) {
    for (const double degrees : incidences) {
      const double theta_i = radians(degrees);
      const Model model = model_of(c);
      const double lobe = dhr(model, c.values, wavelength_um, theta_i).unpolarized;
      const double mirror = mirror_dhr(model, c.values, wavelength_um, theta_i).unpolarized;
      const Moments m = moments(sampler, theta_i, 20000, ++seed);
      // dhr() itself is good to 1e-6, of a table to some 1e-4.
      const double quadrature = model.table_slots().empty() ? 2e-6 : 3e-4;
      EXPECT_NEAR(m.mean, lobe + mirror, 4.0 * m.standard_error + quadrature * (1.0 + lobe))
          << c.name << " at " << degrees;
    }
  }
}

// The bound is in units of the reflectance, so that 1 is a perfect sampler. What raises it is said
// beside the exception.
TEST(Sampler, WeightsStayBounded) {
  for (const auto& [c, sampler] : samplers()) {
    for (const double degrees : {0.0, 30.0, 60.0, 80.0, 85.0, 89.0}) {
      const double theta_i = radians(degrees);
      const Moments m = moments(sampler, theta_i, 4000, 900);
      double bound = 6.0;
      // Facets and lobes that send most light below the horizon leave little to compare with.
      if (c.name.starts_with("phong") || c.name == "ward") bound = 16.0;
      EXPECT_LT(m.greatest, bound * m.mean + 1e-12) << c.name << " at " << degrees;
    }
  }
}

TEST(Sampler, AWhiteSurfaceKeepsEveryBundleWhole) {
  const Sampler diffuse(Model::by_name("lambertian"), {1.0}, wavelength_um);
  const Sampler smooth(Model::by_name("he-torrance"), {0.05, 100.0, 0.001, 1.0}, wavelength_um);
  const Sampler facets(Model::by_name("microfacet:shadowing=vgroove"), {0.05, 100.0, 0.1, 1.0},
                       wavelength_um);
  for (const double degrees : {0.0, 45.0, 80.0}) {
    for (std::uint64_t i = 0; i < 2000; ++i) {
      const auto u = uniform(31, i);
      const auto white = diffuse.sample(radians(degrees), u[0], u[1], u[2]);
      ASSERT_TRUE(white);
      ASSERT_NEAR(element(white->weight, 0, 0), 1.0, 1e-12);
      // Of V-grooves of a perfect mirror, a bundle loses only what meets the second wall.
      const auto groove = facets.sample(radians(degrees), u[0], u[1], u[2]);
      if (groove) {
        ASSERT_LE(element(groove->weight, 0, 0), 1.0 + 1e-12);
      }
    }
    const Moments m = moments(smooth, radians(degrees), 5000, 32);
    EXPECT_NEAR(m.mean, 1.0, 0.01) << degrees;
  }
}

TEST(Sampler, PolarisedWeightsAverageToPolarisedReflectance) {
  const Model model = Model::by_name("li-torrance");
  const std::vector<double> values{1.5, 0.05, 0.3, 3.0, 0.9, 0.02, 0.4, 0.1, 12.0, 0.6};
  const Sampler sampler(model, values, wavelength_um);
  const double theta_i = radians(60.0);
  const Dhr lobe = dhr(model, values, wavelength_um, theta_i);
  const Dhr mirror = mirror_dhr(model, values, wavelength_um, theta_i);
  constexpr int count = 40000;
  double sum = 0.0, squares = 0.0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto u = uniform(33, i);
    const auto sample = sampler.sample(theta_i, u[0], u[1], u[2]);
    if (!sample) continue;
    const double s = element(sample->weight, 0, 0) + element(sample->weight, 0, 1);
    sum += s;
    squares += s * s;
  }
  const double mean = sum / count;
  EXPECT_NEAR(mean, lobe.s + mirror.s, 4.0 * std::sqrt((squares / count - mean * mean) / count));
}

TEST(Sampler, OneDistributionServesSeveralWavelengths) {
  const Model model = Model::by_name("li-torrance");
  const std::vector<SpectralValues> spectrum{
      {{1.5, 0.0, 0.15, 3.0, 1.0, 0.02, 0.05, 0.0, 12.0, 0.6}, 0.532},
      {{1.5, 0.0, 0.15, 3.0, 1.0, 0.02, 0.50, 0.1, 12.0, 0.6}, 0.633},
      {{1.5, 0.0, 0.15, 3.0, 1.0, 0.02, 0.45, 0.1, 12.0, 0.6}, 0.814}};
  const Sampler sampler(model, spectrum);
  for (const double degrees : incidences) {
    const double theta_i = radians(degrees);
    for (std::size_t k = 0; k < spectrum.size(); ++k) {
      const double expected =
          dhr(model, spectrum[k].values, spectrum[k].wavelength_um, theta_i).unpolarized +
          mirror_dhr(model, spectrum[k].values, spectrum[k].wavelength_um, theta_i).unpolarized;
      const Moments m = moments(sampler, theta_i, 20000, 41 + k, k);
      EXPECT_NEAR(m.mean, expected, 4.0 * m.standard_error) << degrees << " wavelength " << k;
      EXPECT_LT(m.greatest, 12.0 * m.mean);
    }
    const auto u = uniform(44, 3);
    const auto sample = sampler.sample(theta_i, u[0], u[1], u[2], 2);
    ASSERT_TRUE(sample);
    EXPECT_EQ(sampler.weight(*sample, 2), sample->weight);
  }
}

TEST(Sampler, SampleDensityAndWeightBelongTogether) {
  for (const auto& [c, sampler] : samplers()) {
    const double theta_i = radians(40.0);
    for (std::uint64_t i = 0; i < 50; ++i) {
      const auto u = uniform(51, i);
      const auto sample = sampler.sample(theta_i, u[0], u[1], u[2]);
      if (!sample || sample->mirror) continue;
      const Geometry<double>& g = sample->geometry;
      ASSERT_GT(sample->direction.z, 0.0);
      ASSERT_NEAR(glm::length(sample->direction), 1.0, 1e-9) << c.name;
      ASSERT_NEAR(glm::length(sample->direction - optics::exit_direction(g.theta_r, g.phi_r)), 0.0,
                  1e-12);
      // Directions of a narrow lobe lose digits on their way through angles.
      const double tolerance = c.narrow ? 1e-5 : 1e-7;
      const double value = element(evaluate<double>(model_of(c), c.values, wavelength_um, g), 0, 0);
      const double expected = value * std::cos(g.theta_r) / sample->density;
      EXPECT_NEAR(element(sample->weight, 0, 0), expected, tolerance * expected + 1e-12) << c.name;
    }
  }
}

TEST(Sampler, IsSharedByThreads) {
  const Model model = Model::by_name("li-torrance");
  const Sampler sampler(model, model.initial_values(), wavelength_um);
  std::vector<double> found(4, 0.0);
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < found.size(); ++k) {
    threads.emplace_back([&, k] { found[k] = moments(sampler, 0.5, 5000, 61).mean; });
  }
  for (std::thread& thread : threads) thread.join();
  for (const double mean : found) EXPECT_EQ(mean, found[0]);
}

TEST(Sampler, GivesNothingWhereNothingIsReflected) {
  const Sampler black(Model::by_name("lambertian"), {0.0}, wavelength_um);
  EXPECT_FALSE(black.sample(0.3, 0.5, 0.5, 0.5));
  EXPECT_EQ(black.pdf({0.3, 0.3, 0.0}), 0.0);
  const Sampler white(Model::by_name("lambertian"), {1.0}, wavelength_um);
  EXPECT_FALSE(white.sample(radians(90.5), 0.5, 0.5, 0.5));
  EXPECT_EQ(white.pdf({0.3, radians(91.0), 0.0}), 0.0);
}

/// A diffuse table that falls to nothing between 40° and 44.5° of incidence.
class TableThatGoesDark : public Table {
 public:
  static double brdf(double theta_i) {
    return 0.2 * std::clamp((44.5 - optics::degrees(theta_i)) / 4.5, 0.0, 1.0);
  }
  optics::Mueller<double> at(double, const Geometry<double>& g) const override {
    optics::Mueller<double> m(0.0);
    if (std::cos(g.theta_r) > 0.0) m[0][0] = brdf(g.theta_i);
    return m;
  }
  const std::vector<double>& wavelengths_um() const override { return wavelengths_; }
  bool polarised() const override { return false; }
  std::string description() const override { return "dark from 44.5 degrees on"; }

 private:
  std::vector<double> wavelengths_{0.633};
};

TEST(Sampler, IsRightBetweenAnIncidenceWithLightAndOneWithout) {
  const Sampler sampler(
      Model::by_name("tabulated").with_table(std::make_shared<TableThatGoesDark>()), {},
      wavelength_um);
  std::uint64_t seed = 700;
  for (const double degrees : {41.0, 42.0, 43.0, 43.7, 44.0, 44.4}) {
    const double theta_i = radians(degrees);
    const Moments m = moments(sampler, theta_i, 20000, ++seed);
    EXPECT_NEAR(m.mean, optics::pi * TableThatGoesDark::brdf(theta_i), 4.0 * m.standard_error)
        << degrees;
    const Fit fit = chi_square(
        sampler, [&](const Geometry<double>& g) { return sampler.pdf(g); }, 0.0, theta_i,
        Bins::polar, 20000, ++seed);
    EXPECT_GT(fit.p, 1e-3) << degrees;
    EXPECT_NEAR(fit.integral + fit.nothing, 1.0, 0.012) << degrees;
  }
  EXPECT_EQ(moments(sampler, radians(60.0), 1000, ++seed).greatest, 0.0);
}

TEST(Sampler, SurvivesTheEndsOfTheRandomNumbers) {
  const double last = std::nextafter(1.0, 0.0);
  for (const auto& [c, sampler] : samplers()) {
    for (const double degrees : {0.0, 45.0, 89.9}) {
      for (const double u1 : {0.0, 1e-300, last}) {
        for (const double u2 : {0.0, 1e-300, last}) {
          for (const double u3 : {0.0, 0.5, last}) {
            const auto sample = sampler.sample(radians(degrees), u1, u2, u3);
            if (!sample) continue;
            EXPECT_TRUE(std::isfinite(sample->density) && sample->density > 0.0) << c.name;
            EXPECT_TRUE(std::isfinite(element(sample->weight, 0, 0))) << c.name;
          }
        }
      }
    }
  }
}

TEST(Sampler, RefusesWhatNoModelAllows) {
  EXPECT_THROW(Sampler(Model::by_name("lambertian"), {1.5}, wavelength_um), Error);
  EXPECT_THROW(Sampler(Model::by_name("tabulated"), {}, wavelength_um), Error);
  EXPECT_THROW(Sampler(Model::by_name("lambertian"), std::vector<SpectralValues>{}), Error);
}

}  // namespace
}  // namespace umov::brdf
