#include "host/optics/frames.hpp"

#include <gtest/gtest.h>

#include "host/optics/fresnel.hpp"

namespace umov::optics {
namespace {

void expect_near(const Vec3<double>& a, const Vec3<double>& b, double tolerance = 1e-14) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

void expect_right_handed(const Beam<double>& beam) {
  expect_near(cross(beam.s, beam.p), beam.k);
  EXPECT_NEAR(dot(beam.s, beam.s), 1.0, 1e-14);
  EXPECT_NEAR(dot(beam.s, beam.k), 0.0, 1e-14);
}

TEST(Frames, IncidentLightTravelsDownAndForward) {
  const Vec3<double> k = incident_direction(radians(30.0));
  expect_near(k, {0.5, 0.0, -std::sqrt(0.75)});
}

TEST(Frames, NegativeExitAngleIsTheRetroSide) {
  expect_near(exit_direction(radians(-30.0), 0.0), exit_direction(radians(30.0), pi));
}

TEST(Frames, BasesAreRightHandedAndSIsAcrossTheNormal) {
  for (const double theta : {0.0, 1e-9, 20.0, 89.9}) {
    expect_right_handed(incident_beam(radians(theta)));
    for (const double phi : {-170.0, -60.0, 0.0, 45.0, 180.0}) {
      const Beam<double> beam = exit_beam(radians(theta), radians(phi));
      expect_right_handed(beam);
      EXPECT_NEAR(beam.s.z, 0.0, 1e-15);
      if (theta > 1e-6) expect_near(beam.s, beam_along(beam.k).s, 1e-12);
    }
  }
}

TEST(Frames, BeamAlongTheNormalTakesYForS) {
  expect_near(beam_along(Vec3<double>(0.0, 0.0, 1.0)).s, {0.0, 1.0, 0.0});
  expect_near(beam_along(Vec3<double>(0.0, 0.0, -1.0)).s, {0.0, 1.0, 0.0});
  expect_near(incident_beam(0.0).s, {0.0, 1.0, 0.0});
  expect_near(exit_beam(0.0, 0.0).s, {0.0, 1.0, 0.0});
}

TEST(Frames, ScatteringInPlaneNeedsNoRotation) {
  for (const double theta_r : {-80.0, -30.0, 0.0, 30.0, 80.0}) {
    const Beam<double> in = incident_beam(radians(40.0));
    const Beam<double> out = exit_beam(radians(theta_r), 0.0);
    const Vec3<double> normal = scattering_plane_normal(in, out);
    EXPECT_NEAR(rotation_to(in, normal).cos2, 1.0, 1e-14);
    EXPECT_NEAR(rotation_to(out, normal).cos2, 1.0, 1e-14);
    EXPECT_NEAR(rotation_to(in, normal).sin2, 0.0, 1e-14);
  }
}

TEST(Frames, RetroReflectionIsTheSameFromEverySide) {
  const Mueller<double> facet = reflection_mueller(1.5, 0.3, 1.0);
  const Beam<double> in = incident_beam(radians(35.0));
  const auto seen = [&](double theta_r_deg, double phi_deg) {
    const Beam<double> out = exit_beam(radians(theta_r_deg), radians(phi_deg));
    return to_beam_bases(facet, in, out, scattering_plane_normal(in, out));
  };
  const Mueller<double> exact = seen(-35.0, 0.0);
  for (const auto& [d_theta, d_phi] :
       {std::pair{1e-7, 0.0}, {-1e-7, 0.0}, {0.0, 1e-7}, {1e-9, -1e-8}}) {
    const Mueller<double> near = seen(-35.0 + d_theta, d_phi);
    for (int i = 0; i < 16; ++i) {
      EXPECT_NEAR(element(near, i / 4, i % 4), element(exact, i / 4, i % 4), 1e-8) << i;
    }
  }
}

}  // namespace
}  // namespace umov::optics
