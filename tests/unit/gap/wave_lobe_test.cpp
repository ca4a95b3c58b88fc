// The lobe of waves: what He and Torrance's model is above the base's facets.
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "host/gap/scan/effects/sample.hpp"
#include "host/optics/angles.hpp"

namespace umov::gap::scan {
namespace {

constexpr double n = 1.5, kappa = 0.02, slope = 0.15, wavelength_um = 0.633;

optics::Mueller<double> with_waves(const brdf::Geometry<double>& geometry, double share,
                                   double height_um) {
  static const brdf::Model facets = brdf::Model::by_name("microfacet");
  const std::vector<double> parameters{n, kappa, slope, 1.0};
  const Material<double> material{&facets, parameters, wavelength_um, 0, 0};
  const double values[] = {share, 1 / height_um};
  Switched<double> on;
  on.wavelengths = 1;
  on.values[number(EffectId::wave_lobe)] = values;
  return sample_mueller(material, geometry, on);
}

brdf::Geometry<double> directions(double theta_i_deg, double theta_r_deg, double phi_deg = 0) {
  return {optics::radians(theta_i_deg), optics::radians(theta_r_deg), optics::radians(phi_deg)};
}

TEST(WaveLobe, WholeItIsTheLibrarysModel) {
  static const brdf::Model waves = brdf::Model::by_name("he-torrance");
  for (const double height_um : {0.25, 0.8, 3.0}) {
    const std::vector<double> parameters{n, kappa, height_um,
                                         height_um * std::numbers::sqrt2 / slope};
    for (const auto& geometry : {directions(20, 25), directions(60, 40), directions(70, 75),
                                 directions(30, -10), directions(40, 35, 20)}) {
      const optics::Mueller<double> ours = with_waves(geometry, 1, height_um);
      const optics::Mueller<double> model =
          brdf::evaluate<double>(waves, parameters, wavelength_um, geometry);
      for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r)
          EXPECT_NEAR(ours[c][r], model[c][r], 1e-12 * model[0][0]) << height_um;
    }
  }
}

TEST(WaveLobe, TallHeightsNearNormalIncidenceAreFacets) {
  // Off by about 1/g, g the variance of the phase: 4e-5 for heights of 8 µm.
  for (const double theta_r_deg : {10.0, 15.0, 25.0}) {
    const auto geometry = directions(10, theta_r_deg);
    const double waves = with_waves(geometry, 1, 8.0)[0][0];
    const double facets = with_waves(geometry, 0, 8.0)[0][0];
    EXPECT_NEAR(waves / facets, 1, 3e-4) << theta_r_deg;
    EXPECT_GT(std::abs(with_waves(geometry, 1, 0.4)[0][0] / facets - 1), 3e-3) << theta_r_deg;
  }
}

}  // namespace
}  // namespace umov::gap::scan
