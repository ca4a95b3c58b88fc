// Nearly smooth surfaces against what else is known of them.
#include <gtest/gtest.h>

#include <cmath>

#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"

namespace umov::brdf {
namespace {

using optics::element;
using optics::Mueller;
using optics::radians;

TEST(RayleighRice, LobeAndMirrorPartOfAPerfectReflectorSumToOneUpToTheNextOrder) {
  const Model model = Model::by_name("rayleigh-rice");
  for (const double sigma : {0.001, 0.003, 0.006}) {
    for (const double degrees_i : {0.0, 30.0, 60.0}) {
      const std::vector<double> values{0.05, 100.0, sigma, 30.0};
      const double theta = radians(degrees_i);
      const double lobe = dhr(model, values, 0.633, theta).unpolarized;
      const double mirror = mirror_dhr(model, values, 0.633, theta).unpolarized;
      const double fresnel = optics::reflectance(0.05, 100.0, std::cos(theta));
      const double g = std::pow(4.0 * optics::pi * sigma / 0.633 * std::cos(theta), 2);
      EXPECT_NEAR(lobe, fresnel * g, 0.01 * g) << sigma << " at " << degrees_i;
      EXPECT_NEAR(lobe + mirror, fresnel, 0.51 * g * g + 0.01 * g) << sigma << " at " << degrees_i;
    }
  }
}

TEST(RayleighRice, AgreesWithHeTorranceWhereBothHold) {
  // Small heights, correlation over many wavelengths, near the mirror direction.
  const Model rice = Model::by_name("rayleigh-rice"), torrance = Model::by_name("he-torrance");
  const std::vector<double> values{1.5, 0.0, 0.002, 20.0};
  for (const double offset : {0.0, 0.3, 1.0}) {
    const Geometry<double> g{radians(20.0), radians(20.0 + offset), radians(offset)};
    const double a = element(evaluate<double>(rice, values, 0.633, g), 0, 0);
    const double b = element(evaluate<double>(torrance, values, 0.633, g), 0, 0);
    EXPECT_NEAR(a / b, 1.0, 0.02) << offset;
  }
}

TEST(RayleighRice, ScattersPureStates) {
  // One amplitude matrix: the squares of all 16 elements add up to 4 m00².
  for (const char* name : {"rayleigh-rice", "rayleigh-rice:psd=abc"}) {
    const Model model = Model::by_name(name);
    std::vector<double> values = model.initial_values();
    values[0] = 0.958;
    values[1] = 6.69;
    for (const double phi : {0.0, 40.0, 90.0, 170.0}) {
      const Mueller<double> m = evaluate<double>(
          model, values, 0.633, Geometry<double>{radians(55.0), radians(25.0), radians(phi)});
      double squares = 0.0;
      for (int k = 0; k < 16; ++k) squares += std::pow(element(m, k / 4, k % 4), 2);
      EXPECT_NEAR(squares / std::pow(element(m, 0, 0), 2), 4.0, 1e-10) << name << " " << phi;
    }
  }
}

TEST(RayleighRice, ScatteringVarianceIsTheIntegralOfTheSpectrum) {
  const double wavelength = 0.633;
  const auto integral = [&](Psd psd, const std::vector<double>& shape) {
    double sum = 0.0;
    constexpr int count = 400000;
    for (int k = 0; k < count; ++k) {
      const double f = (k + 0.5) / count / wavelength;
      sum += 2.0 * optics::pi * f * spectral_density<double, double>(psd, shape, f * f);
    }
    return sum / count / wavelength;
  };
  for (const auto& [psd, shape] : {std::pair{Psd::gaussian, std::vector{0.01, 1.0}},
                                   {Psd::gaussian, std::vector{0.01, 0.1}},
                                   {Psd::abc, std::vector{1e-3, 10.0, 2.5}},
                                   {Psd::abc, std::vector{1e-3, 10.0, 2.0}},
                                   {Psd::abc, std::vector{1e-3, 10.0, 1.2}},
                                   {Psd::abc, std::vector{1e-3, 0.001, 4.0}}}) {
    const double value =
        scattering_variance<double>(psd, std::span<const double>(shape), wavelength);
    EXPECT_NEAR(value / integral(psd, shape), 1.0, 1e-6) << shape[1] << " " << shape.back();
  }
  // The whole variance where the spectrum ends below 1/λ.
  const std::vector<double> wide{0.01, 5.0};
  EXPECT_NEAR(scattering_variance<double>(Psd::gaussian, wide, wavelength), 1e-4, 1e-12);
}

}  // namespace
}  // namespace umov::brdf
