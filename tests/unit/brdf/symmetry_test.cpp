// What every model must obey, whatever its formula: reciprocity, mirror symmetry, continuity,
// realisability.
#include <gtest/gtest.h>

#include <cmath>

#include "host/brdf/evaluate.hpp"
#include "tests/unit/brdf/variants.hpp"

namespace umov::brdf {
namespace {

using optics::element;
using optics::Mueller;
using optics::radians;

struct Angles {
  double theta_i, theta_r, phi;
};

Mueller<double> value(const Variant& v, Angles a) {
  return evaluate<double>(Model::by_name(v.name), v.values, 0.633,
                          Geometry<double>{radians(a.theta_i), radians(a.theta_r), radians(a.phi)});
}

void expect_close(const Mueller<double>& a, const Mueller<double>& b, double tolerance,
                  const std::string& where) {
  for (int i = 0; i < 16; ++i) {
    EXPECT_NEAR(element(a, i / 4, i % 4), element(b, i / 4, i % 4),
                tolerance * element(b, 0, 0) + 1e-300)
        << where << " element " << i / 4 << i % 4;
  }
}

TEST(EveryModel, IsReciprocalIncludingPolarisation) {
  // Reversing a beam turns (s, p, k) into (-s, p, -k): U changes sign, Q and V stay. The azimuth
  // from the new incoming to the new outgoing beam is -φ.
  const double sign[4] = {1, 1, -1, 1};
  for (const Variant& v : all_variants()) {
    if (std::string(v.name) == "ward") continue;  // its axes are fixed to the plane of incidence
    for (const Angles a :
         {Angles{30, 50, 0}, {20, 60, 37}, {65, 10, 120}, {45, 45, 170}, {0, 40, 0}}) {
      const Mueller<double> there = value(v, a);
      Mueller<double> expected(0.0);
      for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) {
          optics::set_element(expected, r, c, sign[r] * sign[c] * element(there, c, r));
        }
      }
      expect_close(value(v, {a.theta_r, a.theta_i, -a.phi}), expected, 1e-10, v.name);
    }
  }
}

TEST(EveryModel, MirroredGeometryMirrorsUAndV) {
  const double sign[4] = {1, 1, -1, -1};
  for (const Variant& v : all_variants()) {
    for (const Angles a : {Angles{20, 60, 37}, {65, 10, 120}}) {
      const Mueller<double> left = value(v, a);
      Mueller<double> expected(0.0);
      for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) {
          optics::set_element(expected, r, c, sign[r] * sign[c] * element(left, r, c));
        }
      }
      expect_close(value(v, {a.theta_i, a.theta_r, -a.phi}), expected, 1e-10, v.name);
    }
  }
}

TEST(EveryModel, IsContinuousWhereFramesDegenerate) {
  // Small enough that even a narrow lobe's flank, with logarithmic slopes of some thousands, hardly
  // moves.
  constexpr double step = 1e-8;  // degrees
  constexpr double tolerance = 1e-6;
  for (const Variant& v : all_variants()) {
    for (const Angles a : {Angles{0, 0, 0},
                           {0, 30, 0},
                           {0, 30, 60},
                           {40, 0, 0},
                           {40, 0, 60},
                           {35, -35, 0},
                           {35, 35, 180},
                           {35, 35, 0},
                           {70, -70, 0},
                           {80, 80, 0}}) {
      const Mueller<double> exact = value(v, a);
      for (int i = 0; i < 16; ++i)
        ASSERT_TRUE(std::isfinite(element(exact, i / 4, i % 4))) << v.name;
      expect_close(value(v, {a.theta_i + step, a.theta_r, a.phi}), exact, tolerance, v.name);
      expect_close(value(v, {a.theta_i, a.theta_r + step, a.phi}), exact, tolerance, v.name);
      expect_close(value(v, {a.theta_i, a.theta_r - step, a.phi}), exact, tolerance, v.name);
      expect_close(value(v, {a.theta_i, a.theta_r, a.phi + step}), exact, tolerance, v.name);
    }
  }
}

TEST(EveryModel, SignedExitAngleAndAzimuthNameTheSameDirection) {
  for (const Variant& v : all_variants()) {
    expect_close(value(v, {30, -50, 0}), value(v, {30, 50, 180}), 1e-10, v.name);
    expect_close(value(v, {30, 50, -180}), value(v, {30, 50, 180}), 1e-10, v.name);
  }
}

TEST(EveryModel, TurnsNoLightIntoMoreThanFullyPolarisedLight) {
  for (const Variant& v : all_variants()) {
    for (const Angles a : {Angles{30, 50, 0}, {20, 60, 37}, {65, 10, 120}, {80, 75, 5}}) {
      const Mueller<double> m = value(v, a);
      for (int k = 0; k < 24; ++k) {
        const double azimuth = 0.7 * k, height = -1.0 + 2.0 * k / 23.0;
        const double ring = std::sqrt(1.0 - height * height);
        const optics::Stokes<double> out =
            optics::apply(m, optics::Stokes<double>(1.0, ring * std::cos(azimuth),
                                                    ring * std::sin(azimuth), height));
        EXPECT_LE(std::hypot(out[1], out[2], out[3]), out[0] * (1.0 + 1e-9) + 1e-300) << v.name;
      }
    }
  }
}

TEST(EveryModel, GivesNothingBelowTheHorizon) {
  for (const Variant& v : all_variants()) {
    EXPECT_EQ(element(value(v, {30, 95, 0}), 0, 0), 0.0) << v.name;
    EXPECT_EQ(element(value(v, {95, 30, 0}), 0, 0), 0.0) << v.name;
  }
}

}  // namespace
}  // namespace umov::brdf
