// Series without a formula must keep to what any reflectance obeys.
#include <array>
#include <cmath>
#include <iterator>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "host/gap/scan/effects/sample.hpp"
#include "host/optics/angles.hpp"

namespace umov::gap::scan {
namespace {

const brdf::Model& base() {
  static const brdf::Model model = brdf::Model::by_name("microfacet+nef");
  return model;
}

std::size_t lobe() {
  for (const brdf::Component& part : base().components())
    if (part.kind == brdf::Kind::microfacet) return part.first;
  return 0;
}

double slope() {
  return base().parameters()[lobe() + 2].initial;
}

/// What an effect with these coefficients adds to the base.
optics::Mueller<double> added(double theta_i_deg, double theta_r_deg, double phi_deg,
                              const Switched<double>& with) {
  std::vector<double> parameters;
  for (const brdf::Parameter& p : base().parameters()) parameters.push_back(p.initial);
  const Material<double> material{&base(), parameters, 0.633, 0, static_cast<int>(lobe())};
  const brdf::Geometry<double> geometry{optics::radians(theta_i_deg), optics::radians(theta_r_deg),
                                        optics::radians(phi_deg)};
  Switched<double> without;
  without.wavelengths = 1;
  return sample_mueller(material, geometry, with) - sample_mueller(material, geometry, without);
}

optics::Mueller<double> free_form(double theta_i_deg, double theta_r_deg, EffectId id,
                                  std::size_t terms, double phi_deg = 0) {
  std::vector<double> coefficients;
  for (std::size_t i = 0; i < terms; ++i)
    coefficients.push_back(0.05 * (1.0 + static_cast<double>(i % 3)));
  Switched<double> with;
  with.wavelengths = 1;
  with.values[number(id)] = coefficients.data();
  return added(theta_i_deg, theta_r_deg, phi_deg, with);
}

/// All of a series' coefficients zero but one, or none of them and one added to its sum.
optics::Mueller<double> one_of(double theta_i_deg, double theta_r_deg, const Series& series,
                               std::size_t which, double lift) {
  std::vector<double> coefficients(200, 0.0);
  if (which < series.terms) coefficients[series.first + which] = 1.0;
  Switched<double> with;
  with.wavelengths = 1;
  with.values[number(series.effect)] = coefficients.data();
  with.lift[static_cast<std::size_t>(series.id)] = &lift;
  return added(theta_i_deg, theta_r_deg, 0.0, with);
}

struct Form {
  EffectId id;
  std::size_t terms;  ///< for one wavelength
};

const Form forms[] = {{EffectId::free_slopes, slope_terms},
                      {EffectId::fine_slopes, fine_slope_terms},
                      {EffectId::free_lobe, growth_terms + lobe_extra + 1},
                      {EffectId::spectral_lobe, spectral_lobe_terms},
                      {EffectId::free_diffuse, diffuse_shape_terms + kept_terms + diffuse_extra},
                      {EffectId::spectral_diffuse, spectral_diffuse_terms},
                      {EffectId::anisotropic_slopes, 2}};

TEST(FreeForms, AreReciprocalInThePlaneOfIncidence) {
  for (const auto& [id, terms] : forms) {
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

const Form azimuthal{EffectId::azimuthal_diffuse, azimuthal_terms};

TEST(FreeForms, AzimuthalDiffuseLightIsNoneInThePlaneOfIncidence) {
  for (const double theta_r_deg : {-60.0, -20.0, 5.0, 45.0}) {
    const optics::Mueller<double> m = free_form(25.0, theta_r_deg, azimuthal.id, azimuthal.terms);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) EXPECT_NEAR(m[i][j], 0.0, 1e-14);
  }
  EXPECT_GT(std::abs(free_form(25.0, 50.0, azimuthal.id, azimuthal.terms, 90.0)[0][0]), 1e-4);
}

TEST(FreeForms, AzimuthalDiffuseLightFollowsTheTurnAboutTheHalfDirection) {
  const double i = optics::radians(35.0), r = optics::radians(60.0), phi = optics::radians(70.0);
  using Vec = optics::Vec3<double>;
  // Towards the source and the detector; φ_r is zero where the mirror direction goes.
  const Vec to_source(-std::sin(i), 0.0, std::cos(i));
  const Vec to_detector(std::sin(r) * std::cos(phi), std::sin(r) * std::sin(phi), std::cos(r));
  const Vec sum = to_source + to_detector, normal(0.0, 0.0, 1.0);
  const Vec half = sum * (1.0 / std::sqrt(optics::dot(sum, sum)));
  const Vec a = normal - half * optics::dot(normal, half);
  const Vec b = to_source - half * optics::dot(to_source, half);
  const double turn2 = std::pow(optics::dot(a, b), 2) / (optics::dot(a, a) * optics::dot(b, b));
  const double expected = 4.0 * optics::dot(a, a) * optics::dot(b, b) * (1.0 - turn2);

  const brdf::FacetFrame<double> f = brdf::facet_frame(brdf::Geometry<double>{i, r, phi});
  const std::array<double, azimuthal_terms> first{1.0, 0.0, 0.0, 0.0, 0.0};
  optics::Mueller<double> m = optics::zero_mueller<double>();
  add_azimuthal_diffuse(m, 1.0, first.data(), f);
  optics::Mueller<double> unit = optics::zero_mueller<double>();
  brdf::add_depolarized(unit, 1.0);
  EXPECT_NEAR(m[0][0], expected * unit[0][0], 1e-12);
}

TEST(FreeForms, AreIsotropicOutOfThePlaneOfIncidence) {
  // Mirrored at the plane of incidence, intensity for unpolarised light stays; with the beams
  // exchanged it stays as well, whatever the azimuth.
  std::vector<Form> isotropic(std::begin(forms), std::end(forms));
  isotropic.back() = azimuthal;  // in the place of anisotropic slopes
  for (const auto& [id, terms] : isotropic) {
    for (const double phi_deg : {15.0, 60.0, 140.0}) {
      const double there = free_form(25.0, 50.0, id, terms, phi_deg)[0][0];
      EXPECT_NEAR(there, free_form(25.0, 50.0, id, terms, -phi_deg)[0][0], 1e-12) << number(id);
      EXPECT_NEAR(there, free_form(50.0, 25.0, id, terms, phi_deg)[0][0], 1e-12) << number(id);
    }
  }
}

TEST(FreeForms, LiftOfASumIsTheDerivativeOfEveryCoefficientOverItsTerm) {
  const brdf::FacetFrame<double> f =
      brdf::facet_frame(brdf::Geometry<double>{optics::radians(20.0), optics::radians(55.0), 0.0});
  std::array<Term, most_terms> terms;
  for (const Series& series : all_series) {
    const std::span<Term> used = std::span<Term>(terms).first(series.terms);
    series_basis(series.id, slope(), f, used);
    double largest = 0;
    for (std::size_t j = 0; j < series.terms; ++j) {
      largest = std::max(largest, std::abs(used[j].value));
      const optics::Mueller<double> by_term = one_of(20.0, 55.0, series, j, 0.0);
      const optics::Mueller<double> by_lift = one_of(20.0, 55.0, series, series.terms, 1.0);
      for (int c = 0; c < 2; ++c)
        for (int r = 0; r < 2; ++r)
          EXPECT_NEAR(by_term[c][r], used[j].value * by_lift[c][r], 1e-10)
              << number(series.effect) << " " << j;
    }
    EXPECT_GT(largest, 0.1) << number(series.effect);
  }
}

}  // namespace
}  // namespace umov::gap::scan
