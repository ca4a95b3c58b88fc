#include "hil/plant/rough_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "host/optics/fresnel.hpp"

namespace umov::plant {
namespace {

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      cells.emplace_back();
    else
      cells.back() += c;
  }
  return cells;
}

double entry(const std::string& text, const std::string& name) {
  const std::size_t at = (" " + text).find(" " + name + "=");
  return std::stod(text.substr(at + name.size() + 1));
}

TEST(DirectionalDiffuse, AgreesWithTheReferenceTableToOnePartInAMillion) {
  std::ifstream file(UMOV_TEST_DATA "/reference/brdf_reference_values.csv");
  ASSERT_TRUE(file);
  int rows = 0;
  for (std::string line; std::getline(file, line);) {
    const bool with_shadow = line.find("He1991_directional_diffuse_brdf") != std::string::npos;
    const bool without = line.find("He1991_rough_limit_brdf_without_S") != std::string::npos;
    if (line.starts_with("#") || (!with_shadow && !without)) continue;
    std::vector<std::string> cells = cells_of(line);
    // The parameter field of some rows holds unquoted commas; geometry counts from the basis
    // column.
    std::size_t basis = 0;
    while (cells.at(basis) != "scalar") ++basis;
    const std::string& parameters = cells[3];
    const double theta_i = optics::radians(std::stod(cells[basis - 3]));
    const double theta_r = optics::radians(std::stod(cells[basis - 2]));
    const double phi = optics::radians(std::stod(cells[basis - 1]));
    const double expected = std::stod(cells[basis + 17]);
    const HeightStatistics surface{entry(parameters, "sigma0"), entry(parameters, "tau")};
    const Vec3 k_i = optics::incident_direction(theta_i);
    const Vec3 k_r = optics::exit_direction(theta_r, phi);
    double value =
        directional_diffuse_factor(surface, k_i, k_r, entry(parameters, "lambda")) *
        optics::reflectance(entry(parameters, "n"), entry(parameters, "k"), facet_cosine(k_i, k_r));
    if (without) value /= surface.shadowing(-k_i.z, k_r.z);
    EXPECT_NEAR(value, expected, 1e-6 * expected) << line;
    ++rows;
  }
  EXPECT_EQ(rows, 16);
}

TEST(DirectionalDiffuse, TendsToTheGaussianFacetFormOnAVeryRoughSurface) {
  // The rough limit is P8 with a 1-D slope of √2 σ0/τ; what is left falls with 1/g.
  const HeightStatistics surface{60.0, 600.0};
  const Vec3 k_i = optics::incident_direction(0.5);
  for (const double theta_r : {0.2, 0.5, 0.8}) {
    const Vec3 k_r = optics::exit_direction(theta_r, 0.1);
    EXPECT_NEAR(directional_diffuse_factor(surface, k_i, k_r, 0.633),
                facet_factor(std::sqrt(2.0) * 0.1, k_i, k_r),
                1e-4 * facet_factor(std::sqrt(2.0) * 0.1, k_i, k_r));
  }
}

TEST(PhaseSeries, EqualsThePlainSumForFewAndForManyTerms) {
  for (const double g : {0.03, 1.0, 12.0, 60.0, 400.0, 3000.0}) {
    for (const double a : {0.0, 0.5 * g, 20.0 * g, 200.0 * g}) {
      long double sum = 0.0L;
      for (int m = 1; m < 9000; ++m) {
        sum +=
            std::exp(static_cast<long double>(m) * std::log(static_cast<long double>(g)) -
                     static_cast<long double>(g) - std::lgamma(static_cast<long double>(m) + 1.0L) -
                     std::log(static_cast<long double>(m)) - static_cast<long double>(a) / m);
      }
      const double expected = static_cast<double>(sum);
      EXPECT_NEAR(phase_series(g, a), expected, 1e-9 * expected) << "g " << g << " a " << a;
    }
  }
}

TEST(FacetFactor, IntegratesToTheVisibleFacetsOnAGentleSurface) {
  // Without Fresnel loss a single-bounce surface of small slopes returns nearly all light.
  const double slope = 0.05;
  const Vec3 k_i = optics::incident_direction(0.4);
  double sum = 0.0;
  constexpr int n = 400;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double theta = 0.4 + 0.6 * ((i + 0.5) / n - 0.5);
      const double phi = 2.0 * ((j + 0.5) / n - 0.5);
      sum += facet_factor(slope, k_i, optics::exit_direction(theta, phi)) * std::cos(theta) *
             std::sin(theta) * (0.6 / n) * (2.0 / n);
    }
  }
  EXPECT_NEAR(sum, 1.0, 0.01);
}

}  // namespace
}  // namespace umov::plant
