// Luminance maps as the forward model of a diagnosis.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "host/chamber/figures.hpp"
#include "host/chamber/mixing_chamber.hpp"
#include "host/chamber/synthetic_mcpet.hpp"
#include "host/gap/chamber/chamber_model.hpp"
#include "host/gap/engine/diagnosis.hpp"
#include "tests/unit/failure.hpp"

namespace umov::gap {
namespace {

using chamber::Map;
using chamber::MixingChamber;
using chamber::Surface;

std::shared_ptr<const Surface> plastic() {
  static const auto one = std::make_shared<const Surface>(
      "plastic", chamber::PlanesSurface(chamber::synthetic_mcpet(chamber::mcpet_theta_i_deg, 2.5),
                                        0, chamber::mcpet_total));
  return one;
}

MapOptions coarse() {
  MapOptions options;
  options.joined = 8;
  options.rays_per_pixel = 2000;
  options.rays_per_signature = 600;
  return options;
}

Map measured(const MixingChamber& c, std::uint64_t seed, const chamber::Departure& departure = {}) {
  const chamber::View view = c.described().view(departure);
  const chamber::Tracer tracer(view.luminaire);
  chamber::MapRequest request;
  request.rays_per_pixel = 2000 / 64;
  request.seed = seed;
  return chamber::joined(chamber::luminance_map(tracer, view.camera, request), coarse().joined);
}

TEST(ChamberModel, AMattSimulationOfAPlasticLacksItsLobe) {
  MixingChamber simulated;
  simulated.wall =
      std::make_shared<const Surface>("matt", chamber::Lambertian{chamber::mcpet_total});
  const auto signatures =
      std::make_shared<const MapSignatures>(map_signatures(simulated.described(), coarse()));
  MixingChamber real = simulated;
  real.wall = plastic();
  const ChamberModel model(signatures, measured(real, 99));
  DiagnoseOptions how;
  how.draws = 100;
  const Diagnosis d = diagnose(model, how);
  ASSERT_FALSE(d.causes.empty());
  EXPECT_EQ(d.causes.front().effect, "near_specular_lobe");
  EXPECT_GT(d.closed_fraction.value, 0.9);
  // Without any effect the simulation is its own map; with one, a map and its change.
  Eigen::VectorXd mean;
  Eigen::MatrixXd jacobian;
  model.predict({{0}, {1.0}, {{0.5}}}, mean, &jacobian);
  const Eigen::VectorXd expected = signatures->mean + 0.5 * signatures->effects[0].columns.col(0);
  EXPECT_LT((mean - expected).norm(), 1e-9 * expected.norm());
  EXPECT_EQ(jacobian.cols(), 2);

  // And a simulation that has nothing wrong is not blamed for anything.
  const ChamberModel same(signatures, measured(simulated, 98));
  EXPECT_TRUE(diagnose(same, how).causes.empty());

  // Light adds up: sources however unequal are what their signatures say.
  const auto exitance =
      std::find_if(signatures->effects.begin(), signatures->effects.end(),
                   [](const MapEffect& e) { return e.effect.name == "source_exitance"; });
  ASSERT_NE(exitance, signatures->effects.end());
  chamber::Departure unequal;
  unequal.excess = {0.6, 0.0, -0.6, 0.0};
  const ChamberModel seen(signatures, measured(simulated, 97, unequal));
  const Eigen::VectorXd foretold =
      signatures->mean + exitance->columns * Eigen::Vector3d(0.0, -0.6, 0.0);
  const auto misfit = [&](const Eigen::VectorXd& map) {
    return (seen.observations().value - map).cwiseQuotient(seen.noise(map).sigma).squaredNorm() /
           static_cast<double>(map.size());
  };
  EXPECT_LT(misfit(foretold), 1.6);
  EXPECT_GT(misfit(signatures->mean), 5.0);

  // Where neither has any scatter, as in a source seen directly, both are still not exact.
  auto exact = std::make_shared<MapSignatures>(*signatures);
  exact->se.setZero();
  Map sure = measured(simulated, 98);
  std::fill(sure.luminance_se.begin(), sure.luminance_se.end(), 0.0);
  EXPECT_GT(ChamberModel(exact, sure).noise(signatures->mean).sigma.minCoeff(), 0.0);

  Map small = measured(simulated, 98);
  small.width = 3;
  EXPECT_NE(failure_of([&] { ChamberModel(signatures, small); }).find("same window"),
            std::string::npos);
}

}  // namespace
}  // namespace umov::gap
