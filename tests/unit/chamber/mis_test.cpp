// Multiple importance sampling is right in the mean with any weights that add up to 1, so its
// weights are judged by the variance: here it is known without a single path.
#include <gtest/gtest.h>

#include <cmath>

#include "host/optics/angles.hpp"
#include "tests/unit/chamber/chambers.hpp"

namespace umov::chamber {
namespace {

using optics::pi;

constexpr double height = 10.0, radius = 10.0;

/// A disc that shines down, coaxial over the point of a plate that is looked at from aside.
struct Plate {
  Luminaire luminaire;
  Vec3 along = Vec3(3.0, 0.0, -0.4) / std::sqrt(9.16);

  explicit Plate(const std::shared_ptr<const Surface>& surface) {
    luminaire.add_emitter(disc(0, 0, height, radius, 1.0, false), matt(0.0));
    luminaire.scene.plates.push_back({0.0, 0.0, 0.0, 100.0, true, luminaire.add(surface)});
  }
};

struct Moments {
  double mean, variance;
};

/// Mean and variance of one path where a direction at θ is asked for with density a by the point
/// of the disc and drawn with density b by the plate, weighted by the squares of these:
/// each way gives wF/p, and both are independent.
Moments by_quadrature(double brdf, double drawn_share) {
  const double area = pi * radius * radius;
  const double luminance = 1e6 / area / pi;
  const double top = std::atan2(radius, height);
  constexpr int steps = 20'000;
  double mean_a = 0.0, mean_b = 0.0, square_a = 0.0, square_b = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double theta = top * (i + 0.5) / steps;
    const double cosine = std::cos(theta);
    const double solid_angle = 2.0 * pi * std::sin(theta) * top / steps;
    const double a = height * height / (cosine * cosine * cosine * area);
    const double b = drawn_share * cosine / pi;
    const double weight_a = a * a / (a * a + b * b);
    const double light = brdf * cosine * luminance;
    mean_a += weight_a * light * solid_angle;
    mean_b += (1.0 - weight_a) * light * solid_angle;
    square_a += std::pow(weight_a * light, 2) / a * solid_angle;
    square_b += std::pow((1.0 - weight_a) * light, 2) / b * solid_angle;
  }
  return {mean_a + mean_b, square_a - mean_a * mean_a + square_b - mean_b * mean_b};
}

Moments by_paths(const Tracer& tracer, const Vec3& along) {
  constexpr int paths = 400'000;
  double sum = 0.0, squares = 0.0;
  Work work;
  for (int i = 0; i < paths; ++i) {
    const double seen = tracer.luminance(-20.0 * along, along, Estimator::mis, 3,
                                         static_cast<std::uint64_t>(i), work);
    sum += seen;
    squares += seen * seen;
  }
  const double mean = sum / paths;
  return {mean, squares / paths - mean * mean};
}

// With half of the BRDF's density in the weights the variance would be 12 % smaller (the heuristic
// is good, not the best) and 11 % larger.
TEST(Weights, AreThoseOfTheDensitiesByTheVarianceTheyLeave) {
  const auto half_mirror =
      std::make_shared<const Surface>("half mirror", DiffuseSpecular{1.0, {0.0}, {0.5}});
  for (const auto& [surface, share] : {std::pair{matt(1.0), 1.0}, {half_mirror, 0.5}}) {
    const Plate plate(surface);
    const Tracer tracer(plate.luminaire);
    const Moments expected = by_quadrature(share / pi, share);
    const Moments found = by_paths(tracer, plate.along);
    EXPECT_NEAR(found.mean, expected.mean, 0.005 * expected.mean) << surface->name();
    EXPECT_NEAR(found.variance, expected.variance, 0.02 * expected.variance) << surface->name();
  }
}

}  // namespace
}  // namespace umov::chamber
