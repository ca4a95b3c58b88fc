// Several wavelengths on one path: each as bright as if it were alone.
#include "host/chamber/bands.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/chamber/camera.hpp"
#include "host/chamber/goniophotometer.hpp"
#include "host/chamber/mixing_chamber.hpp"
#include "host/chamber/synthetic_mcpet.hpp"
#include "host/optics/luminous_efficiency.hpp"
#include "tests/unit/chamber/chambers.hpp"
#include "tests/unit/failure.hpp"

namespace umov::chamber {
namespace {

using optics::pi;

const std::vector<double> red_to_blue{0.45, 0.50, 0.555, 0.61, 0.65};
const std::vector<double> coloured{0.35, 0.6, 0.9, 0.8, 0.5};

/// W/nm of a lumen whose power rises with the band.
std::vector<double> reddish(const Bands& bands) {
  std::vector<double> power{1.0, 2.0, 3.0, 4.0, 5.0};
  const double lumens = bands.luminous(power);
  for (double& p : power) p /= lumens;
  return power;
}

std::shared_ptr<const Surface> coloured_matt() {
  std::vector<Surface::Kind> bands;
  for (const double rho : coloured) bands.emplace_back(Lambertian{rho});
  return std::make_shared<const Surface>("coloured", bands);
}

/// Means of each band and their errors.
struct Seen {
  std::vector<double> mean, error;
};

Seen seen(const Tracer& tracer, const Vec3& origin, const Vec3& direction, int paths,
          Estimator estimator = Estimator::mis) {
  const std::size_t count = tracer.luminaire().bands->size();
  std::vector<double> sum(count, 0.0), squares(count, 0.0), one(count);
  Work work;
  for (int i = 0; i < paths; ++i) {
    tracer.radiance(origin, direction, estimator, 5, static_cast<std::uint64_t>(i), one, work);
    for (std::size_t b = 0; b < count; ++b) {
      sum[b] += one[b];
      squares[b] += one[b] * one[b];
    }
  }
  Seen s;
  for (std::size_t b = 0; b < count; ++b) {
    const double mean = sum[b] / paths;
    s.mean.push_back(mean);
    s.error.push_back(std::sqrt(std::max(0.0, squares[b] / paths - mean * mean) / paths));
  }
  return s;
}

TEST(Bands, AreAsBrightAsTheEyeSeesThem) {
  std::vector<double> um;
  for (int i = 0; i <= 80; ++i) um.push_back(0.380 + 0.005 * i);
  const Bands fine(um);
  for (std::size_t b = 10; b < 70; ++b) {
    // V bends within a band: its mean is not its middle.
    EXPECT_NEAR(fine.lumens()[b], 683.0 * 5.0 * optics::luminous_efficiency(um[b]), 15.0) << b;
  }
  // ∫ V dλ = 106.857 nm (CIE 18.2), however it is cut.
  for (const Bands& bands : {fine, Bands({0.38, 0.45, 0.555, 0.61, 0.78}), Bands({0.6})}) {
    EXPECT_NEAR(bands.luminous(std::vector<double>(bands.size(), 1.0)), 683.0 * 106.857, 15.0);
  }
  // A line of 1 nm keeps its lumens in bands far wider.
  const Bands wide({0.40, 0.46, 0.52, 0.58, 0.64, 0.70});
  std::vector<double> line(wide.fine_um().size(), 0.0);
  line[132] = 1.0;  // 532 nm
  EXPECT_NEAR(wide.luminous(wide.means(line)), 683.0 * optics::luminous_efficiency(0.532),
              0.01 * 683.0);
  // So it does beside the first and the last band, where V goes on beyond them.
  const Bands narrow({0.50, 0.55, 0.60});
  for (const std::size_t nm : {2u, 50u, 98u}) {
    std::vector<double> at(narrow.fine_um().size(), 0.0);
    at[nm] = 1.0;
    const double lumens = 683.0 * optics::luminous_efficiency(0.5 + 1e-3 * static_cast<double>(nm));
    EXPECT_NEAR(narrow.luminous(narrow.means(at)) / lumens, 1.0, 0.02) << nm;
  }
}

TEST(Bands, CloserThanANanometreHaveTheirShareToo) {
  const Bands close({0.555, 0.5553, 0.556});
  const std::vector<double> even(close.fine_um().size(), 2.0);
  for (const double mean : close.means(even)) EXPECT_NEAR(mean, 2.0, 1e-9);
}

TEST(Bands, ThatCannotBeAreRefused) {
  EXPECT_NE(failure_of([] { Bands({0.5, 0.4}); }).find("400 nm after 500 nm"), std::string::npos);
  EXPECT_NE(failure_of([] { Bands({0.3}); }).find("360 to 830"), std::string::npos);
  EXPECT_NE(failure_of([] { Bands({}); }).find("0 bands"), std::string::npos);
  Luminaire l;
  l.bands.emplace(std::vector{0.5, 0.6});
  l.add(coloured_matt());
  EXPECT_NE(failure_of([&] { Tracer{l}; }).find("5 bands in a luminaire of 2"), std::string::npos);
}

TEST(SpectralSphere, MultipliesEachBandByItsOwnReflectance) {
  constexpr double radius = 100.0, port_z = -95.0, flux = 100.0;
  Luminaire l;
  l.bands.emplace(red_to_blue);
  const auto wall = coloured_matt();
  l.scene.spheres.push_back({Vec3(0, 0, 0), radius, l.add(wall, true), port_z});
  Emitter source = disc(0, 0, radius - 0.01, 0.5, flux, false);
  source.spectrum = reddish(*l.bands);
  l.add_emitter(source, wall);
  const Tracer tracer(l);
  const double port = 0.5 * (1.0 + port_z / radius);
  const Seen s = seen(tracer, Vec3(0, 0, 0), Vec3(0.6, 0.0, 0.8), 40'000);
  const Distribution d = intensity_distribution(tracer, {.rays = 200'000});
  std::vector<double> irradiance;  // W/(m² nm)
  for (std::size_t b = 0; b < coloured.size(); ++b) {
    irradiance.push_back(1e6 * flux * source.spectrum[b] / (4.0 * pi * radius * radius) /
                         (1.0 - coloured[b] * (1.0 - port)));
    const double expected = coloured[b] * irradiance[b] / pi;
    EXPECT_NEAR(s.mean[b], expected, 3.0 * s.error[b] + 1e-4 * expected) << b;
    EXPECT_LT(s.error[b], 0.01 * expected) << b;
    const double out = port * irradiance[b] * 4.0 * pi * radius * radius * 1e-6;
    EXPECT_NEAR(d.fate.spectrum_out[b], out, 0.02 * out) << b;
  }
  const double lumens = port * l.bands->luminous(irradiance) * 4.0 * pi * radius * radius * 1e-6;
  EXPECT_NEAR(d.out_lm, lumens, 3.0 * d.out_se);
  EXPECT_NEAR(l.bands->luminous(d.fate.spectrum_out), d.out_lm, 1e-9 * d.out_lm);
  EXPECT_NEAR(d.fate.launched, flux, 1e-9 * flux);
  EXPECT_NEAR(d.fate.out + d.fate.absorbed, flux, 1e-3 * flux);
}

// Walls that all shine alike and reflect alike: Le/(1 - ρ), in each band with its own ρ.
TEST(SpectralFurnace, IsEvenInEveryBand) {
  std::vector<Surface::Kind> kinds;
  for (const double total : coloured) kinds.emplace_back(DiffuseSpecular(total, {0.0}, {0.3}));
  const auto mixed = std::make_shared<const Surface>("mixed", kinds);
  for (const auto& surface : {coloured_matt(), mixed}) {
    Luminaire l;
    l.bands.emplace(red_to_blue);
    const std::vector<double> power = reddish(*l.bands);
    const auto side = [&](const Vec3& centre, const Vec3& u, const Vec3& v) {
      Emitter e{};
      e.flux_lm = 4.0 * std::sqrt(optics::dot(u, u) * optics::dot(v, v)) * 1e-6 * pi * 1000.0;
      e.centre = centre;
      e.half_u = u;
      e.half_v = v;
      e.spectrum = power;
      const Vec3 n = optics::cross(u, v);
      e.normal = n / std::sqrt(optics::dot(n, n));
      l.add_emitter(e, surface);
    };
    const Vec3 x(10, 0, 0), y(0, 15, 0), z(0, 0, 20);
    side(-x, y, z);
    side(x, z, y);
    side(-y, z, x);
    side(y, x, z);
    side(-z, x, y);
    side(z, y, x);
    const Tracer tracer(l);
    for (const Estimator e : {Estimator::unidirectional, Estimator::next_event, Estimator::mis}) {
      const Seen s = seen(tracer, Vec3(1, 2, 3), Vec3(0.48, 0.6, 0.64), 20'000, e);
      for (std::size_t b = 0; b < coloured.size(); ++b) {
        const double expected = 1000.0 * power[b] / (1.0 - coloured[b]);
        EXPECT_NEAR(s.mean[b], expected, 3.5 * s.error[b] + 1e-9)
            << surface->name() << " " << static_cast<int>(e) << " " << b;
      }
    }
  }
}

/// The mixing chamber with a wall that is given band by band, all together and one at a time.
void expect_bands_as_if_alone(const std::shared_ptr<const Surface>& together,
                              const std::vector<std::shared_ptr<const Surface>>& alone) {
  MixingChamber chamber;
  chamber.wall = together;
  Luminaire l = chamber.luminaire();
  l.bands.emplace(std::vector{0.45, 0.65});
  const std::vector<double> power(2, 1.0 / l.bands->luminous(std::vector{1.0, 1.0}));
  for (Emitter& e : l.emitters) e.spectrum = power;
  const Tracer tracer(l);
  const Vec3 along = Vec3(0.9, 0.1, -0.8) / std::sqrt(0.81 + 0.01 + 0.64);
  const Vec3 origin = Vec3(0.0, 0.0, 31.0);
  constexpr int paths = 40'000;
  const Seen s = seen(tracer, origin, along, paths);
  for (std::size_t b = 0; b < 2; ++b) {
    chamber.wall = alone[b];
    const Luminaire one = chamber.luminaire();
    const Tracer single(one);
    double sum = 0.0, squares = 0.0;
    Work work;
    for (int i = 0; i < paths; ++i) {
      const double v =
          single.luminance(origin, along, Estimator::mis, 77, static_cast<std::uint64_t>(i), work);
      sum += v;
      squares += v * v;
    }
    const double mean = power[b] * sum / paths;
    const double error = std::sqrt((power[b] * power[b] * squares / paths - mean * mean) / paths);
    EXPECT_LT(s.error[b], 0.03 * mean) << together->name();
    EXPECT_NEAR(s.mean[b], mean, 3.5 * std::hypot(error, s.error[b])) << together->name() << b;
  }
}

TEST(SpectralPaths, OfTablesAndModelsAreAsIfEachBandWereAlone) {
  const auto table = synthetic_mcpet(mcpet_theta_i_deg, 2.5);
  const PlanesSurface dark(table, 0, 0.6), light(table, 0, 0.9);
  expect_bands_as_if_alone(
      std::make_shared<const Surface>("table", std::vector<Surface::Kind>{dark, light}),
      {std::make_shared<const Surface>("dark", dark),
       std::make_shared<const Surface>("light", light)});

  const brdf::Model ggx = brdf::Model::by_name("ggx+lambertian");
  std::vector<brdf::SpectralValues> values(2);
  for (const brdf::Parameter& p : ggx.parameters()) {
    for (std::size_t b = 0; b < 2; ++b)
      values[b].values.push_back(p.name.ends_with("rho") ? 0.2 + 0.4 * static_cast<double>(b)
                                                         : p.initial);
  }
  values[0].wavelength_um = 0.45;
  values[1].wavelength_um = 0.65;
  const auto of = [&](const brdf::SpectralValues& v) {
    return std::make_shared<const Surface>("model",
                                           Modelled{brdf::Sampler(ggx, v.values, v.wavelength_um)});
  };
  expect_bands_as_if_alone(
      std::make_shared<const Surface>("model", Modelled{brdf::Sampler(ggx, values)}),
      {of(values[0]), of(values[1])});
}

TEST(SpectralMap, OfGreyWallsIsThatOfNoBandsAndItsSumTheLuminance) {
  MixingChamber chamber;
  chamber.wall = std::make_shared<const Surface>("two", mcpet_diffuse_specular());
  const Luminaire plain = chamber.luminaire();
  Luminaire banded = plain;
  banded.bands.emplace(red_to_blue);
  for (Emitter& e : banded.emitters) e.spectrum = reddish(*banded.bands);
  const Camera camera = chamber.camera(20);
  const Map one = luminance_map(Tracer(plain), camera, {.rays_per_pixel = 20});
  const Map many = luminance_map(Tracer(banded), camera, {.rays_per_pixel = 20, .threads = 2});
  const std::size_t pixels = one.luminance_cd_m2.size();
  ASSERT_EQ(many.radiance.size(), 5 * pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    const double expected = one.luminance_cd_m2[i];
    EXPECT_NEAR(many.luminance_cd_m2[i], expected, 1e-9 * expected);
    EXPECT_NEAR(many.luminance_se[i], one.luminance_se[i], 1e-6 * expected);
    double sum = 0.0;
    for (std::size_t b = 0; b < 5; ++b) {
      sum += banded.bands->lumens()[b] * many.radiance[b * pixels + i];
      EXPECT_NEAR(many.radiance_se[b * pixels + i],
                  one.luminance_se[i] * banded.emitters[0].spectrum[b],
                  1e-6 * expected * banded.emitters[0].spectrum[b]);
    }
    EXPECT_NEAR(sum, expected, 1e-9 * expected);
  }
}

}  // namespace
}  // namespace umov::chamber
