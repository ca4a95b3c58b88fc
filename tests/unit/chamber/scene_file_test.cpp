// Scene files: what they say is what is traced, and what cannot be is refused with its place.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "host/chamber/scene_file.hpp"
#include "host/optics/angles.hpp"
#include "tests/unit/failure.hpp"

namespace umov::chamber {
namespace {

const std::string chamber = R"([chamber]
diameter_mm = 43
height_mm = 21.4
wall = { model = "lambertian", rho = 0.984 }

[[source]]
kind = "disk"
diameter_mm = 5
flux_lm = 0.96
ring_radius_mm = 6.6
count = 4
depth_mm = 1
edge = "black"
)";
const std::string camera = R"([camera]
view_deg = 55
pixels = [300, 125]
pixel_mm = 0.2
)";
const std::string gonio = "[goniophotometer]\nrays = 1e4\n";

std::string refusal(const std::string& text) {
  return failure_of([&] { job_from_toml(text, "scene.toml"); });
}

TEST(SceneFile, APapersChamberIsReadAsItIsWritten) {
  const Job job = job_from_toml(chamber + camera + "[region]\nx_mm = [15, 35]\ny_mm = [15, 23]\n",
                                "scene.toml");
  const Luminaire& l = job.luminaire;
  EXPECT_EQ(l.emitters.size(), 4U);
  EXPECT_NEAR(l.flux_lm(), 3.84, 1e-12);
  EXPECT_EQ(l.scene.tubes.size(), 5U);  // wall and four edges
  ASSERT_TRUE(job.camera.has_value());
  EXPECT_EQ(job.camera->width, 300U);
  EXPECT_EQ(job.camera->centre.z, 21.4);
  EXPECT_EQ(job.map.rays_per_pixel, 1000U);
  EXPECT_FALSE(job.distribution.has_value());
  // From 55° no source is in view: nothing but the walls shines.
  const Tracer tracer(l);
  int met = 0;
  for (int i = -10; i <= 10; ++i) {
    const Vec3 origin =
        job.camera->centre + 0.2 * i * job.camera->up() + 100.0 * job.camera->towards();
    const auto hit = tracer.geometry().nearest(origin, -job.camera->towards(), 1e3);
    if (!hit) continue;
    EXPECT_LT(l.emitter_of[hit->material], 0);
    ++met;
  }
  EXPECT_GT(met, 10);
}

TEST(SceneFile, BadNumbersAreRefusedWithLineAndRemedy) {
  auto with = [&](const std::string& from, const std::string& to) {
    std::string text = chamber + gonio;
    text.replace(text.find(from), from.size(), to);
    return refusal(text);
  };
  EXPECT_EQ(with("flux_lm = 0.96", "flux_lm = -1"),
            "scene.toml:9: source[0].flux_lm = -1 is out of range (choose 0 to 1000000000)");
  EXPECT_EQ(with("rho = 0.984", "rho = 1.2"),
            "scene.toml:4: wall rho = 1.2 (a surface reflects between 0 and 1)");
  EXPECT_NE(with("ring_radius_mm = 6.6", "ring_radius_mm = 20").find("over the edge"),
            std::string::npos);
  EXPECT_NE(with("ring_radius_mm = 6.6", "ring_radius_mm = 2").find("overlap"), std::string::npos);
  EXPECT_NE(with("edge = \"black\"", "edge = \"paint\"").find("add [surfaces.paint]"),
            std::string::npos);
  EXPECT_NE(with("depth_mm = 1", "deep_mm = 1").find("deep_mm is not known here"),
            std::string::npos);
  EXPECT_NE(refusal(chamber).find("nothing is to be measured"), std::string::npos);
  EXPECT_NE(refusal(gonio).find("there is nothing in it"), std::string::npos);
}

TEST(SceneFile, BandsGiveSourcesAndWallsTheirSpectra) {
  std::string text =
      chamber + gonio + "[bands]\nwavelength_nm = { from = 400, to = 700, step = 50 }\n";
  text.replace(text.find("rho = 0.984"), 11,
               "rho = { wavelength_nm = [400, 600, 700], value = [0.2, 0.8, 0.8] }");
  text.replace(text.find("edge ="), 6,
               "spectrum = { wavelength_nm = [400, 700], value = [0, 3] }\nedge =");
  const Job job = job_from_toml(text, "scene.toml");
  const Luminaire& l = job.luminaire;
  ASSERT_TRUE(l.bands.has_value());
  ASSERT_EQ(l.bands->size(), 7U);
  std::vector<double> f(7);
  l.surfaces[l.scene.tubes.front().material]->values(Vec3(0, 0, 1), Vec3(0, 0, 1), f);
  EXPECT_NEAR(optics::pi * f[1], 0.35, 1e-12);
  EXPECT_NEAR(optics::pi * f[6], 0.8, 1e-12);
  for (const Emitter& e : l.emitters) {
    EXPECT_NEAR(l.bands->luminous(e.spectrum), 1.0, 1e-12);
    EXPECT_NEAR(e.spectrum[4] / e.spectrum[3], 200.0 / 150.0, 0.1);  // means by V, not points
  }
  const Distribution d = intensity_distribution(Tracer(l), *job.distribution);
  EXPECT_GT(d.out_lm, 1.0);
  EXPECT_NEAR(l.bands->luminous(d.fate.spectrum_out), d.out_lm, 1e-9);

  EXPECT_NE(refusal(chamber + gonio + "[bands]\nwavelength_nm = [500, 400]\n").find("rising order"),
            std::string::npos);
  std::string lone = chamber + gonio;
  lone.replace(lone.find("edge ="), 6, "spectrum = 1\nedge =");
  EXPECT_NE(
      refusal(lone).find("scene.toml:13: source[0].spectrum is given, but the scene has no bands"),
      std::string::npos)
      << refusal(lone);
  std::string bright = text;
  bright.replace(bright.find("0.8, 0.8"), 8, "0.8, 1.8");
  EXPECT_NE(refusal(bright).find("scene.toml:4"), std::string::npos) << refusal(bright);
  std::string unlit = text;
  unlit.replace(unlit.find("value = [0, 3]"), 14, "value = [0, 0]");
  EXPECT_NE(refusal(unlit).find("no light in the bands"), std::string::npos) << refusal(unlit);
}

TEST(SceneFile, GlareIsOfTheObserverWhoTakesTheMap) {
  const auto distance = [](const std::string& text) {
    return job_from_toml(text, "scene.toml").glare->observer_distance_m;
  };
  const std::string near = chamber + camera + "distance_mm = 500\n[glare]\n";
  EXPECT_EQ(distance(chamber + camera + "[glare]\n"), 2.0);
  EXPECT_EQ(distance(chamber + camera + "[glare]\nobserver_distance_m = 3\n"), 3.0);
  EXPECT_EQ(distance(near), 0.5);
  EXPECT_EQ(distance(near + "observer_distance_m = 0.5\n"), 0.5);
  EXPECT_EQ(refusal(near + "observer_distance_m = 2\n"),
            "scene.toml:20: glare.observer_distance_m = 2, but the camera stands at 500 mm (leave "
            "it out, or move the camera by its distance_mm)");
}

class SceneFolder : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void put(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  std::string refusal_here(const std::string& text) {
    return failure_of([&] { job_from_toml(text, folder_ / "scene.toml"); });
  }
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() /
      ("umov-scene-" +
       std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
};

TEST_F(SceneFolder, OpenMeshesAreRefusedWhereClosedOnesAreNeeded) {
  put("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  const std::string mesh =
      "[[mesh]]\nfile = \"open.obj\"\nsurface = \"black\"\nclosed = \"yes\"\n" + gonio;
  EXPECT_NE(refusal_here(mesh).find("open.obj: the mesh should be closed but has 3 open edges"),
            std::string::npos);
}

TEST_F(SceneFolder, TablesWithHolesOrTooMuchLightAreRefused) {
  const std::string head = "plane,theta_i_deg,angle_deg,wavelength_nm,m00\n";
  std::string planes = head;
  for (const int theta : {5, 60}) {
    for (int angle = -80; angle <= 80; angle += 20)
      planes += "in," + std::to_string(theta) + "," + std::to_string(angle) + ",555,0.31\n";
    for (int angle = 0; angle <= 80; angle += 20)
      planes += "across," + std::to_string(theta) + "," + std::to_string(angle) + ",555,0.31\n";
  }
  put("good.csv", planes);
  std::string bright = planes;
  for (std::size_t at = 0; (at = bright.find("0.31", at)) != std::string::npos;)
    bright.replace(at, 4, "0.45");
  put("bright.csv", bright);
  std::string holes = planes + "in,60,85,600,0.3\n";  // a wavelength that others lack
  put("holes.csv", holes);
  const auto scene = [&](const std::string& file) {
    return "[chamber]\ndiameter_mm = 43\nheight_mm = 20\nwall = { file = \"" + file + "\" }\n" +
           "[[source]]\nkind = \"disk\"\ndiameter_mm = 5\nflux_lm = 1\n" + gonio;
  };
  EXPECT_EQ(refusal_here(scene("good.csv")), "no error");
  EXPECT_NE(refusal_here(scene("bright.csv")).find("scene.toml:4: wall reflects 1.41"),
            std::string::npos)
      << refusal_here(scene("bright.csv"));
  // A factor of a tenth would no longer be this table.
  std::string scaled = scene("good.csv");
  scaled.replace(scaled.find("\" }"), 3, "\", total = 0.1 }");
  EXPECT_NE(
      refusal_here(scaled).find("scene.toml:4: wall gives 0.974 of the light that comes in at "
                                "0°, where 0.1 is due (check that `total`"),
      std::string::npos)
      << refusal_here(scaled);
  EXPECT_NE(refusal_here(scene("holes.csv")).find("holes.csv:"), std::string::npos);
}

TEST_F(SceneFolder, SourcesShineAsTheirPhotometricFilesSay) {
  put("spot.ies",
      "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0\n1 1 10\n0 20 40\n0\n100 50 0\n");
  const Job job = job_from_toml(
      "[[source]]\nkind = \"disk\"\ndiameter_mm = 5\ncentre_mm = [0, 0, 0]\nfile = "
      "\"spot.ies\"\n" +
          gonio,
      folder_ / "scene.toml");
  const Tracer tracer(job.luminaire);
  const Distribution d =
      intensity_distribution(tracer, {.rays = 400'000, .planes = 1, .angles = 91, .seed = 3});
  EXPECT_NEAR(d.intensity(0, 5), 75.0, 3.0 * d.intensity_se[5] + 0.1);
  EXPECT_EQ(d.intensity(0, 25), 0.0);
  EXPECT_NEAR(d.out_lm / d.source_lm, 1.0, 0.01);
}

TEST(SceneFile, ALuminaireIsBuiltWithDeparturesFromItsDescription) {
  const std::string loose =
      "[[source]]\nkind = \"rectangle\"\ncentre_mm = [0, 0, 5]\nedge_u_mm = [2, 0, 0]\n"
      "edge_v_mm = [0, 2, 0]\nflux_lm = 3\n";
  Departure d;
  d.shift_x_mm = 0.3;
  d.ring_mm = 0.4;
  d.depth_mm = -0.25;
  d.edge_rho = 0.2;
  d.view_deg = 1.5;
  d.excess = {0.0, 0.1, 0.0, 0.0, -1.0};
  const Job as_said = job_from_toml(chamber + loose + camera, "scene.toml");
  const Job job = job_from_toml(chamber + loose + camera, "scene.toml", d);
  EXPECT_TRUE(as_said.rings);
  EXPECT_EQ(as_said.least_depth_mm, 1.0);
  EXPECT_NEAR(job.luminaire.emitters[0].centre.x, 6.6 + 0.4 + 0.3, 1e-12);
  EXPECT_NEAR(job.luminaire.emitters[0].centre.z, -0.75, 1e-12);
  EXPECT_NEAR(job.luminaire.emitters[1].flux_lm, 0.96 * 1.1, 1e-12);
  EXPECT_EQ(job.luminaire.emitters[4].flux_lm, 0.0);
  EXPECT_EQ(job.luminaire.emitters[4].centre.x, 0.3);
  EXPECT_EQ(job.camera->view_deg, 56.5);
  // The hole moves with its source.
  EXPECT_NEAR(job.luminaire.scene.plates.back().holes[0].x, 7.3, 1e-12);
  double edge = 0.0;
  for (const auto& surface : job.luminaire.surfaces)
    if (surface->name() == "edge") edge = surface->reflectance(45.0);
  EXPECT_EQ(edge, 0.2);
  d.ring_mm = 20.0;
  EXPECT_NE(failure_of([&] {
              job_from_toml(chamber + camera, "scene.toml", d);
            }).find("puts a hole over the edge"),
            std::string::npos);
}

}  // namespace
}  // namespace umov::chamber
