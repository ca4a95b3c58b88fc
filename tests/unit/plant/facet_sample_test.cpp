// Facet surfaces: their slope distributions, masking and limits.
#include <gtest/gtest.h>

#include <cmath>

#include "hil/plant/facet_sample.hpp"
#include "hil/plant/rough_surface.hpp"
#include "hil/plant/sample_catalog.hpp"

namespace umov::plant::test {
namespace {

/// Area of facets over area of the surface, summed over slopes: facets that mirror light from
/// straight above. The factor's 4 cos θi cos θr taken off, D cos⁴θh is the density of slopes.
double projected_area(const FacetLobe& lobe) {
  const double norm = lobe_norm(lobe);
  const Vec3 down(0, 0, -1);
  double sum = 0.0;
  const double step = 0.004;
  for (double x = -0.995; x < 0.995; x += step) {
    for (double y = -0.995; y < 0.995; y += step) {
      const double steep2 = x * x + y * y;
      if (steep2 > 0.98) continue;  // beyond, the light would leave downwards
      const double cos_h = 1.0 / std::sqrt(1.0 + steep2);
      const Vec3 h(x * cos_h, y * cos_h, cos_h);
      const Vec3 k_r = down + 2.0 * h.z * h;
      sum += lobe_factor(lobe, norm, down, k_r) * 4.0 * k_r.z * std::pow(cos_h, 4.0) * step * step;
    }
  }
  return sum;
}

TEST(FacetLobe, OfGaussianSlopesIsTheSameAsTheRoughSurfacesOwn) {
  FacetLobe lobe;
  lobe.slope = 0.2;
  const double norm = lobe_norm(lobe);
  for (const double tr : {-40.0, 10.0, 65.0}) {
    const Vec3 k_i = optics::incident_direction(optics::radians(50.0));
    const Vec3 k_r = optics::exit_direction(optics::radians(tr), 0.3);
    EXPECT_NEAR(lobe_factor(lobe, norm, k_i, k_r), facet_factor(0.2, k_i, k_r),
                1e-12 * facet_factor(0.2, k_i, k_r));
  }
}

TEST(FacetLobe, CoversTheSurfaceOnceWhateverItsDistribution) {
  FacetLobe gaussian{SlopeDistribution::gaussian, 1.0, 0.1, 0.18, 0.0};
  FacetLobe ring{SlopeDistribution::ring, 1.0, 0.05, 0.0, 0.35};
  // Masking at these slopes and straight incidence takes a few per mille; long tails of GGX leave.
  EXPECT_NEAR(projected_area(gaussian), 1.0, 0.01);
  EXPECT_NEAR(projected_area(ring), 1.0, 0.06);
  FacetLobe ggx{SlopeDistribution::ggx, 1.0, 0.05, 0.0, 0.0};
  EXPECT_NEAR(projected_area(ggx), 1.0, 0.02);
}

TEST(FacetSample, OfGgxHasLongerTailsThanGaussian) {
  FacetParameters p;
  p.lobes[0].slope = 0.1;
  const FacetSample gaussian("g", p);
  p.lobes[0].distribution = SlopeDistribution::ggx;
  const FacetSample ggx("t", p);
  const auto ratio = [](const Sample& s) {
    return optics::element(brdf_at(s, 30, 70, 0, 633), 0, 0) /
           optics::element(brdf_at(s, 30, 30, 0, 633), 0, 0);
  };
  EXPECT_GT(ratio(ggx), 5.0 * ratio(gaussian));
}

TEST(FacetSample, OfRingHasItsHumpBesideTheMirrorDirection) {
  FacetParameters p;
  p.lobes[0] = {SlopeDistribution::ring, 1.0, 0.04, 0.0, 0.3};
  const FacetSample ring("r", p);
  const auto f = [&](double tr) { return optics::element(brdf_at(ring, 20, tr, 0, 633), 0, 0); };
  const double hump_deg = 20.0 - 2.0 * optics::degrees(std::atan(0.3));
  EXPECT_GT(f(hump_deg), 10.0 * f(20.0));
}

TEST(FacetSample, AnisotropicTurnsWithTheSample) {
  FacetParameters p;
  p.lobes[0].slope = 0.05;
  p.lobes[0].slope_y = 0.3;
  const FacetSample brushed("b", p);
  // Along the plane of incidence narrow; across it wide.
  const double in_plane = optics::element(brdf_at(brushed, 30, 50, 0, 633), 0, 0);
  const double across = optics::element(brdf_at(brushed, 30, 30, 25, 633), 0, 0);
  EXPECT_GT(across, 20.0 * in_plane);
}

TEST(ShippedFacetSamples, DoNotShineByThemselves) {
  for (const char* name : {"gold-ggx", "two-roughnesses", "embossed"}) {
    const auto sample = make_sample(name);
    for (const double nm : {532.0, 633.0, 814.0}) {
      for (const double ti : {0.0, 40.0, 70.0}) {
        const double value = dhr(*sample, ti, nm).unpolarized;
        EXPECT_LT(value, 0.6) << name;
        EXPECT_GT(value, 0.05) << name;
      }
    }
  }
}

TEST(Samples, KnowHowTheyLookUnderWaterAndSwollen) {
  FacetParameters p;
  p.n = Spectrum(1.5);
  p.lobes[0].slope = 0.1;
  const FacetSample dry("d", p);
  const auto wet = dry.immersed(1.33);
  EXPECT_NEAR(wet->surface_index(633), 1.5 / 1.33, 1e-12);
  EXPECT_NEAR(dry.with_slopes(1.2)->slope_rms(), 0.12, 1e-12);
  const auto paint = make_sample("black-gloss");
  EXPECT_NEAR(paint->with_slopes(2.0)->slope_rms(), 2.0 * paint->slope_rms(), 1e-12);
  // An index of 1 changes nothing.
  const Mueller a = brdf_at(*paint, 40, 45, 0, 633);
  const Mueller b = brdf_at(*paint->immersed(1.0), 40, 45, 0, 633);
  EXPECT_EQ(optics::element(a, 0, 0), optics::element(b, 0, 0));
  EXPECT_EQ(make_sample("germanium")->with_slopes(1.1), nullptr);
}

}  // namespace
}  // namespace umov::plant::test
