// Surfaces of a luminaire: their draws, their values and their energy belong together.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "host/brdf/evaluate.hpp"
#include "host/chamber/surface.hpp"
#include "host/chamber/synthetic_mcpet.hpp"
#include "host/formats/table_file.hpp"
#include "host/optics/angles.hpp"
#include "host/trace/random_stream.hpp"
#include "tests/unit/failure.hpp"

namespace umov::chamber {
namespace {

using optics::pi;
using trace::uniforms;

Vec3 at(double theta_deg, double phi_deg = 180.0) {
  const double t = optics::radians(theta_deg);
  const double p = optics::radians(phi_deg);
  return {std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)};
}

brdf::PlanesTable paper_table() {
  return synthetic_mcpet(mcpet_theta_i_deg, 2.5);
}

std::vector<Surface> surfaces() {
  const brdf::Model ggx = brdf::Model::by_name("ggx+lambertian");
  std::vector<double> values;
  for (const brdf::Parameter& p : ggx.parameters()) values.push_back(p.initial);
  std::vector<Surface> all;
  all.emplace_back("matt", Lambertian{0.7});
  all.emplace_back("two", mcpet_diffuse_specular());
  all.emplace_back("table", PlanesSurface(paper_table(), 0, mcpet_total));
  all.emplace_back("model", Modelled{brdf::Sampler(ggx, values, 0.555)});
  return all;
}

// Counts of draws in cells of the hemisphere against the density, and what was not drawn.
TEST(Surface, DrawsAsItsDensitySays) {
  constexpr int rings = 8, sectors = 12, draws = 60'000, fine = 24;
  for (const Surface& s : surfaces()) {
    for (const double theta : {10.0, 50.0, 78.0}) {
      const Vec3 known = at(theta, 200.0);
      std::vector<double> counted(rings * sectors, 0.0);
      for (int i = 0; i < draws; ++i) {
        const auto u = uniforms(3, static_cast<std::uint64_t>(i), 0);
        const auto d = s.draw(known, Sense::with_light, u[0], u[1], u[2]);
        if (!d || d->density == 0.0) continue;
        EXPECT_NEAR(d->density, s.density(known, d->direction), 1e-6 * d->density);
        double phi = std::atan2(d->direction.y, d->direction.x) / (2.0 * pi);
        if (phi < 0.0) phi += 1.0;
        const int ring = std::min(rings - 1, static_cast<int>((1.0 - d->direction.z) * rings));
        const int sector = std::min(sectors - 1, static_cast<int>(phi * sectors));
        counted[static_cast<std::size_t>(ring * sectors + sector)] += 1.0;
      }
      double chi2 = 0.0;
      int cells = 0;
      for (int r = 0; r < rings; ++r) {
        for (int c = 0; c < sectors; ++c) {
          double expected = 0.0;
          for (int i = 0; i < fine; ++i) {
            for (int k = 0; k < fine; ++k) {
              const double z = 1.0 - (r + (i + 0.5) / fine) / rings;
              const double phi = 2.0 * pi * (c + (k + 0.5) / fine) / sectors;
              const double sine = std::sqrt(1.0 - z * z);
              expected += s.density(known, {sine * std::cos(phi), sine * std::sin(phi), z});
            }
          }
          expected *= draws * 2.0 * pi / (rings * sectors) / (fine * fine);
          if (expected < 20.0) continue;
          const double off = counted[static_cast<std::size_t>(r * sectors + c)] - expected;
          chi2 += off * off / expected;
          ++cells;
        }
      }
      // Mean 1, σ √(2/cells); the midpoints of `expected` take some.
      EXPECT_LT(chi2 / cells, 1.0 + 5.0 * std::sqrt(2.0 / cells)) << s.name() << " at " << theta;
    }
  }
}

// The mean weight is the reflectance whichever way the path runs, and it stays bounded.
TEST(Surface, WeightsAddUpToTheReflectance) {
  for (const Surface& s : surfaces()) {
    for (const double theta : {5.0, 45.0, 75.0}) {
      double sum = 0.0;
      double squares = 0.0;
      double largest = 0.0;
      constexpr int draws = 40'000;
      for (int i = 0; i < draws; ++i) {
        const auto u = uniforms(5, static_cast<std::uint64_t>(i), 0);
        const auto d = s.draw(at(theta), Sense::with_light, u[0], u[1], u[2]);
        const double w = d ? d->weight : 0.0;
        if (d && d->density > 0.0) {
          EXPECT_NEAR(w, s.value(at(theta), d->direction) * d->direction.z / d->density, 1e-6 * w);
        }
        sum += w;
        squares += w * w;
        largest = std::max(largest, w);
      }
      const double mean = sum / draws;
      const double error = std::sqrt(std::max(0.0, squares / draws - mean * mean) / draws);
      EXPECT_NEAR(mean, s.reflectance(theta), 4.0 * error + 1e-3) << s.name() << " at " << theta;
      EXPECT_LT(largest, 4.0) << s.name() << " at " << theta;
    }
  }
}

/// A smooth dielectric, roughness 20 nm over 1 µm, on a dark matt base.
Surface mirroring() {
  const brdf::Model model = brdf::Model::by_name("rayleigh-rice+lambertian");
  return {"mirroring", Modelled{brdf::Sampler(model, {1.5, 0.0, 0.02, 1.0, 0.05}, 0.555)}};
}

/// What leaves exactly in the mirror direction.
double mirrored_share(const Surface& s, const Vec3& known) {
  if (const auto* two = std::get_if<DiffuseSpecular>(&s.kind())) return two->specular_at(known.z);
  if (const auto* model = std::get_if<Modelled>(&s.kind())) {
    const brdf::SpectralValues& at = model->sampler.spectrum().front();
    return brdf::mirror_reflectance<double>(model->sampler.model(), at.values, at.wavelength_um,
                                            std::acos(known.z))[0][0];
  }
  return 0.0;
}

// Paths from the eye: the known direction is where light goes, the drawn one where it comes from.
// Their mean weight is ∫ f(drawn, known) cos dω, which for a table is not the reflectance.
TEST(Surface, DrawsAgainstTheLightWithTheWeightsOfLightThatComes) {
  std::vector<Surface> all = surfaces();
  all.push_back(mirroring());
  for (const Surface& s : all) {
    for (const double theta : {10.0, 50.0, 70.0}) {
      const Vec3 known = at(theta, 200.0);
      constexpr int draws = 40'000;
      double sum = 0.0, squares = 0.0, mirrored = 0.0, mirrored_squares = 0.0;
      for (int i = 0; i < draws; ++i) {
        const auto u = uniforms(11, static_cast<std::uint64_t>(i), 0);
        const auto d = s.draw(known, Sense::against_light, u[0], u[1], u[2]);
        if (!d) continue;
        if (d->density == 0.0) {
          EXPECT_NEAR(d->direction.x, -known.x, 1e-12);
          EXPECT_NEAR(d->direction.y, -known.y, 1e-12);
          mirrored += d->weight;
          mirrored_squares += d->weight * d->weight;
          continue;
        }
        ASSERT_NEAR(d->density, s.density(known, d->direction), 1e-6 * d->density) << s.name();
        ASSERT_NEAR(d->weight, s.value(d->direction, known) * d->direction.z / d->density,
                    1e-6 * d->weight)
            << s.name() << " at " << theta;
        sum += d->weight;
        squares += d->weight * d->weight;
      }
      const auto expect = [&](double found, double found_squares, double expected) {
        const double mean = found / draws;
        const double error = std::sqrt(std::max(0.0, found_squares / draws - mean * mean) / draws);
        EXPECT_NEAR(mean, expected, 4.0 * error + 1e-3) << s.name() << " at " << theta;
      };
      double whole = 0.0;
      constexpr int rings = 240, sectors = 240;
      for (int r = 0; r < rings; ++r) {
        const double sine2 = (r + 0.5) / rings;  // rings of equal ∫ cos dω
        const double sine = std::sqrt(sine2);
        for (int c = 0; c < sectors; ++c) {
          const double phi = 2.0 * pi * (c + 0.5) / sectors;
          whole +=
              s.value({sine * std::cos(phi), sine * std::sin(phi), std::sqrt(1.0 - sine2)}, known);
        }
      }
      expect(sum, squares, pi * whole / (rings * sectors));
      expect(mirrored, mirrored_squares, mirrored_share(s, known));
    }
  }
  EXPECT_GT(mirrored_share(all.back(), at(50.0)), 0.01);
}

/// Factor of an incidence, from one direction of the table.
double energy_factor(const PlanesSurface& fast, const brdf::PlanesTable& table, const Vec3& from) {
  return fast.value(from, at(0.0)) / table.at(0.555, {std::acos(from.z), 0.0, 0.0})[0][0];
}

TEST(PlanesSurface, FollowsTheTableAndKeepsItsEnergyInBetween) {
  const brdf::PlanesTable table = paper_table();
  const PlanesSurface fast(table, 0, mcpet_total);
  const Surface surface("table", fast);
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const auto u = uniforms(9, i, 0);
    const Vec3 from = at(85.0 * u[0], 360.0 * u[1]);
    const Vec3 to = at(85.0 * u[2], 360.0 * u[3]);
    const double phi = std::atan2(from.y * to.x - from.x * to.y, -from.x * to.x - from.y * to.y);
    const double exact = table.at(0.555, {std::acos(from.z), std::acos(to.z), phi})[0][0] *
                         energy_factor(fast, table, from);
    EXPECT_NEAR(fast.value(from, to), exact, 2e-3 * exact) << i;
  }
  for (const double theta : {0.0, 5.0, 35.0, 52.0, 65.0, 75.0, 84.0}) {
    EXPECT_NEAR(surface.reflectance(theta), mcpet_total, 0.004) << theta;
  }
  // Light from overhead is the limit of light from beside it.
  for (const double theta : {10.0, 40.0, 70.0}) {
    for (const double phi : {0.0, 30.0, 90.0, 200.0}) {
      const double beside = fast.value(at(0.001), at(theta, phi));
      EXPECT_NEAR(fast.value(at(0.0), at(theta, phi)), beside, 1e-3 * beside)
          << theta << " " << phi;
    }
  }
  // As its planes stand, the row at 80° would give more than it gets; that is refused.
  const PlanesSurface bare(table, 0);
  for (const double theta : mcpet_theta_i_deg) {
    EXPECT_NEAR(energy_factor(bare, table, at(theta)), 1.0, 1e-4) << theta;
  }
  EXPECT_NE(failure_of([&] { Surface("bare", bare); }).find("bare: reflects 1.0"),
            std::string::npos);
}

TEST(SyntheticMcpet, HasTheCharacterThatTheModelsNeed) {
  double before = 0.0;
  for (const double theta : mcpet_theta_i_deg) {
    const double specular = mcpet_specular(theta);
    EXPECT_GT(specular, before);
    before = specular;
  }
  EXPECT_LT(mcpet_specular(5.0), 0.01);
  EXPECT_GT(mcpet_specular(80.0), 0.05);
  // The shipped file is this table.
  const auto shipped = formats::read_table(std::filesystem::path(UMOV_SOURCE_DIR) /
                                           "examples/chambers/mcpet-synthetic.csv");
  const auto made = paper_table();
  for (const double theta : {5.0, 33.0, 70.0}) {
    for (const double phi : {0.0, 40.0, 180.0}) {
      const brdf::Geometry<double> g{optics::radians(theta), optics::radians(50.0),
                                     optics::radians(phi)};
      EXPECT_NEAR(shipped->at(0.555, g)[0][0], made.at(0.555, g)[0][0], 1e-9);
    }
  }
}

TEST(Surface, MoreLightThanCameInIsRefused) {
  EXPECT_EQ(failure_of([] { Surface("wall", Lambertian{1.01}); }),
            "wall: rho = 1.01 (a surface reflects between 0 and 1)");
  EXPECT_NE(failure_of([] {
              Surface("wall", DiffuseSpecular{0.9, {0.0}, {0.95}});
            }).find("part of"),
            std::string::npos);
}

}  // namespace
}  // namespace umov::chamber
