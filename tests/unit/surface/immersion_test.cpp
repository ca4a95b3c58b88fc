// Models of the library below a liquid.
#include "host/surface/immersion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <string>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/mueller.hpp"
#include "host/surface/scene_file.hpp"
#include "host/trace/simulation.hpp"

namespace umov::surface {
namespace {

using optics::radians;

Surface scene(const std::string& text) {
  return surface_from_toml(text, "scene.toml", {});
}

trace::Result simulated(const std::string& text, double theta_i_deg, std::uint64_t samples) {
  const Surface s = scene(text);
  const trace::Geometry geometry(s.scene);
  const trace::PathTracer tracer(s.scene, geometry);
  trace::Request request;
  request.theta_i = radians(theta_i_deg);
  request.samples = samples;
  return trace::simulate(tracer, trace::Hemisphere(9, 0, 0.0), request);
}

double m00(const trace::Result& r) {
  return r.hemispherical(0).mean[0][0];
}

const std::string head = "[surface]\nwavelengths_um = 0.6\nperiod_um = 100\n[substrate]\n";
const std::string film = "[film]\nthickness_um = 5\nn = 1.5\nkappa = 0\n";

brdf::Sampler sampler(const std::string& model, std::vector<double> values) {
  return {brdf::Model::by_name(model), std::move(values), 0.6};
}

TEST(Immersion, TakesTheIndexRelativeToTheLiquidAndTheWavelengthInIt) {
  const trace::Medium water{{1.333}, {0.0}};
  const auto wet = immersed(sampler("microfacet+lambertian", {1.5, 0.2, 0.15, 1.0, 0.3}), water);
  const auto& values = wet.spectrum()[0].values;
  EXPECT_NEAR(values[0], 1.5 / 1.333, 1e-12);
  EXPECT_NEAR(values[1], 0.2 / 1.333, 1e-12);
  EXPECT_EQ(values[2], 0.15);
  EXPECT_EQ(values[4], 0.3);
  EXPECT_NEAR(wet.spectrum()[0].wavelength_um, 0.6 / 1.333, 1e-12);
  // (1.5 + 0.2i)/(1.333 + 0.01i), multiplied out.
  const auto dark = immersed(sampler("ggx", {1.5, 0.2, 0.2}), {{1.333}, {0.01}});
  const std::complex<double> expected =
      std::complex<double>(1.5, 0.2) / std::complex<double>(1.333, 0.01);
  EXPECT_NEAR(dark.spectrum()[0].values[0], expected.real(), 1e-12);
  EXPECT_NEAR(dark.spectrum()[0].values[1], expected.imag(), 1e-12);
  for (const char* model : {"phong", "ward", "beard-maxwell", "li-torrance"}) {
    const auto m = brdf::Model::by_name(model);
    EXPECT_THROW(immersed(brdf::Sampler(m, m.initial_values(), 0.6), water), Error) << model;
  }
}

TEST(Immersion, MakesAFaceOfTheLiquidsIndexInvisible) {
  // A film of the paint's own index: what is left is the film's upper side, which is smooth.
  const std::string paint = head + "model = \"microfacet\"\nn = 1.5\nslope_rms = 0.3\n";
  const trace::Result wet = simulated(paint + film, 40.0, 100'000);
  const trace::Result smooth =
      simulated(head + "model = \"lambertian\"\nrho = 0\n" + film, 40.0, 100'000);
  EXPECT_NEAR(m00(wet), m00(smooth), 1e-9);
  EXPECT_GT(m00(simulated(paint, 40.0, 100'000)), 0.5 * m00(smooth)) << "dry, it reflects";
}

TEST(Immersion, GivesAModelWhatFacetsThatAreTracedOneByOneGiveUnderTheFilm) {
  // The same metal twice: as a model, and as a rough ground of smooth facets, each of which
  // reflects after Fresnel, relative to the medium in front of it.
  const std::string metal = "n = 1.2\nkappa = 1.5\n";
  const std::string facets =
      "model = \"microfacet:shadowing=smith-correlated\"\n" + metal + "slope_rms = 0.15\n";
  const trace::Result model = simulated(head + facets + film, 30.0, 200'000);
  const trace::Result traced =
      simulated(head + "model = \"fresnel\"\n" + metal +
                    "rough = { slope_rms = 0.15, correlation_um = 4 }\n" + film,
                30.0, 200'000);
  for (const auto& [row, column] : {std::pair{0, 0}, {1, 0}, {1, 1}, {2, 2}, {2, 3}}) {
    EXPECT_NEAR(optics::element(model.hemispherical(0).mean, row, column),
                optics::element(traced.hemispherical(0).mean, row, column), 0.01 * m00(traced))
        << row << column;
  }
  EXPECT_GT(m00(simulated(head + facets, 30.0, 200'000)), 1.1 * m00(traced))
      << "the liquid must matter here";
}

TEST(Immersion, OfParticlesInAFilmButNotOfThoseOnIt) {
  const std::string particles =
      "[[particles]]\nmaterial = \"grain\"\nradius_um = 10\ncoverage = 0.2\n"
      "[materials.grain]\nmodel = \"microfacet\"\n";
  const auto immersed_in = [](const Surface& s) {
    return std::get<trace::Modelled>(s.scene.materials[s.layers[0].material]).immersed.size();
  };
  const std::string ground = "model = \"lambertian\"\nrho = 0.5\n";
  EXPECT_EQ(immersed_in(scene(head + ground + film + "particles = \"in\"\n" + particles)), 1u);
  EXPECT_EQ(immersed_in(scene(head + ground + film + "particles = \"on\"\n" + particles)), 0u);
  const std::string drops = "[[drops]]\ncontact_angle_deg = 90\nradius_um = 15\ncoverage = 0.2\n";
  EXPECT_EQ(immersed_in(scene(head + ground + drops + particles)), 0u) << "drops lie beside them";
}

TEST(Immersion, IsRefusedWithItsLineWhereAFormulaIsOfAir) {
  const auto refused = [](const std::string& text) {
    try {
      scene(text);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("taken");
  };
  const std::string phong = head + "model = \"phong\"\n";
  EXPECT_EQ(refused(phong), "taken") << "dry";
  const std::string said = refused(phong + film);
  EXPECT_NE(said.find("scene.toml:5"), std::string::npos) << said;
  EXPECT_NE(said.find("in air"), std::string::npos) << said;
  EXPECT_NE(refused(phong + "[[drops]]\ncontact_angle_deg = 90\nradius_um = 5\ncoverage = 0.2\n")
                .find("in air"),
            std::string::npos);
}

}  // namespace
}  // namespace umov::surface
