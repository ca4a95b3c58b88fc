// Series without a formula must keep to what any reflectance obeys.
#include <array>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "host/gap/scan/effects/sample.hpp"
#include "host/optics/angles.hpp"

namespace umov::gap::scan {
namespace {

optics::Mueller<double> free_form(double theta_i_deg, double theta_r_deg, EffectId id,
                                  std::size_t terms) {
  static const brdf::Model base = brdf::Model::by_name("microfacet+nef");
  std::vector<double> parameters;
  for (const brdf::Parameter& p : base.parameters()) parameters.push_back(p.initial);
  int lobe = -1;
  for (const brdf::Component& part : base.components())
    if (part.kind == brdf::Kind::microfacet) lobe = static_cast<int>(part.first);
  const Material<double> material{&base, parameters, 0.633, 0, lobe};
  const brdf::Geometry<double> geometry{optics::radians(theta_i_deg), optics::radians(theta_r_deg),
                                        0.0};
  std::vector<double> coefficients;
  for (std::size_t i = 0; i < terms; ++i)
    coefficients.push_back(0.05 * (1.0 + static_cast<double>(i % 3)));
  Switched<double> with, without;
  with.wavelengths = without.wavelengths = 1;
  with.values[number(id)] = coefficients.data();
  return sample_mueller(material, geometry, with) - sample_mueller(material, geometry, without);
}

TEST(FreeForms, AreReciprocalInThePlaneOfIncidence) {
  for (const auto& [id, terms] : {std::pair{EffectId::free_slopes, slope_terms},
                                  {EffectId::free_lobe, lobe_terms + 1},
                                  {EffectId::free_diffuse, diffuse_terms}}) {
    double largest = 0;
    for (const auto& [a, b] : {std::pair{10.0, 35.0}, {50.0, 62.0}, {20.0, 75.0}, {5.0, -40.0}}) {
      const optics::Mueller<double> there = free_form(a, b, id, terms);
      // The way back: from b to a on the same side of the normal.
      const double sign = b < 0 ? -1.0 : 1.0;
      const optics::Mueller<double> back = free_form(sign * b, sign * a, id, terms);
      // Columns and rows change places; of I, Q and V in plane no sign does, and U has none here.
      for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 2; ++j) {
          largest = std::max(largest, std::abs(there[i][j]));
          EXPECT_NEAR(there[i][j], back[j][i], 1e-12) << number(id) << " " << a << " " << b;
        }
      }
      EXPECT_NEAR(there[2][2], back[2][2], 1e-12);
    }
    EXPECT_GT(largest, 1e-4) << number(id);
  }
}

}  // namespace
}  // namespace umov::gap::scan
