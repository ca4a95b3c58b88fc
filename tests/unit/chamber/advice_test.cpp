// How much of a BRDF a luminaire needs.
#include <gtest/gtest.h>

#include "host/chamber/advice.hpp"
#include "host/chamber/mixing_chamber.hpp"
#include "host/chamber/synthetic_mcpet.hpp"
#include "host/optics/angles.hpp"
#include "tests/unit/failure.hpp"

namespace umov::chamber {
namespace {

Job job(const std::shared_ptr<const Surface>& wall) {
  MixingChamber chamber;
  chamber.wall = wall;
  Job job;
  job.luminaire = chamber.luminaire();
  job.camera = chamber.camera(8);
  job.region = Region{20.0, 40.0, 15.0, 23.0};
  job.distribution = DistributionRequest{};
  job.distribution->planes = 4;
  job.distribution->angles = 19;
  return job;
}

TEST(Advice, TheMapNeedsMoreOfAPlasticThanTheDistribution) {
  const auto plastic = std::make_shared<const Surface>(
      "plastic", PlanesSurface(synthetic_mcpet(mcpet_theta_i_deg, 1.0), 0, mcpet_total));
  AdviceRequest request;
  request.rays_per_pixel = 200;
  request.launches = 150'000;
  const Advice advice = advise(job(plastic), request);
  ASSERT_EQ(advice.ablations.size(), 8U);
  const Ablation& reflectance = advice.ablations.front();
  const Ablation& richest = advice.ablations.back();
  EXPECT_EQ(reflectance.readings, 1);
  EXPECT_LT(*reflectance.intensity, 0.02);
  EXPECT_GT(*reflectance.luminance, 0.05);
  EXPECT_LT(*richest.luminance, 0.02);
  EXPECT_FALSE(reflectance.ugr.has_value());
  ASSERT_EQ(advice.sentences.size(), 2U);
  EXPECT_NE(advice.sentences[0].find("reflectance alone of `plastic` is enough, 1 reading"),
            std::string::npos);
  EXPECT_NE(advice.sentences[1].find("in two planes of `plastic` is enough"), std::string::npos)
      << advice.sentences[1];
}

TEST(Advice, TablesTooCoarseForALobeAreLeftOut) {
  const auto polished = std::make_shared<const Surface>(
      "polished", Modelled{brdf::Sampler(brdf::Model::by_name("ggx"), {0.05, 100.0, 0.01}, 0.555)});
  Job narrow = job(polished);
  narrow.camera.reset();
  AdviceRequest request;
  request.launches = 6400;
  const Advice advice = advise(narrow, request);
  ASSERT_GE(advice.ablations.size(), 2U);
  EXPECT_EQ(advice.ablations[1].readings, 7);
  for (const Ablation& a : advice.ablations) {
    EXPECT_EQ(a.knows.find("every 10°"), std::string::npos) << a.knows;
  }
}

TEST(Advice, NothingCanBeLeftOutOfALambertianWall) {
  const auto matt = std::make_shared<const Surface>("matt", Lambertian{0.9});
  EXPECT_NE(failure_of([&] { advise(job(matt), {}); }).find("nothing to leave out"),
            std::string::npos);
}

TEST(Advice, IsNotGivenOnSpectra) {
  const auto coloured = std::make_shared<const Surface>(
      "coloured", std::vector<Surface::Kind>{DiffuseSpecular(0.3, {0.0}, {0.05}),
                                             DiffuseSpecular(0.9, {0.0}, {0.05})});
  EXPECT_NE(failure_of([&] { advise(job(coloured), {}); }).find("coloured: has a spectrum"),
            std::string::npos);
}

TEST(MeasuredPlanes, BringBackASurfaceThatIsATable) {
  const brdf::PlanesTable table = synthetic_mcpet(mcpet_theta_i_deg, 2.5);
  const Surface surface("table", PlanesSurface(table, 0, mcpet_total));
  const brdf::PlanesTable again = measured_planes(surface, {5, 25, 45, 60, 70, 80}, 2.5);
  const Vec3 from(-std::sqrt(0.5), 0.0, std::sqrt(0.5));
  const double factor =
      surface.value(from, Vec3(0, 0, 1)) / table.at(0.555, {optics::radians(45.0), 0.0, 0.0})[0][0];
  const brdf::Geometry<double> g{optics::radians(45.0), optics::radians(30.0), 0.0};
  EXPECT_NEAR(again.at(0.555, g)[0][0], factor * table.at(0.555, g)[0][0],
              2e-3 * table.at(0.555, g)[0][0]);
  EXPECT_NEAR(measured_specular(surface, 45.0), factor * mcpet_specular(45.0),
              0.05 * mcpet_specular(45.0));
}

}  // namespace
}  // namespace umov::chamber
