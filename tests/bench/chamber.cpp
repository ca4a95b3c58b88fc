// Measures the luminance camera and the goniophotometer on the mixing chamber. Prints JSON.
//
//   bench_chamber rate [PATHS]    against bare Embree, one thread, processor time
//   bench_chamber map [RAYS]      the paper's map with so many rays a pixel, all cores
//   bench_chamber lid [RAYS]      a distribution, all cores
//   bench_chamber noise [RAYS]    spread of the three estimators for the same number of rays
//
// Bare Embree gets the very rays of the paths, shadow rays included, in their order, in the same
// chamber made of triangles (it has no faces with an exact circle): cylinders of 24 or 256 sides,
// once for each. Nothing else is done with what it finds.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/chamber/figures.hpp"
#include "host/chamber/goniophotometer.hpp"
#include "host/chamber/mixing_chamber.hpp"
#include "host/chamber/synthetic_mcpet.hpp"
#include "host/optics/angles.hpp"
#include "host/trace/random_stream.hpp"
#include "tests/bench/bare_embree.hpp"

namespace {

using namespace umov::chamber;
using umov::bench::processor_seconds;
using umov::optics::pi;

struct Wall {
  std::string name;
  std::shared_ptr<const Surface> surface;
};

std::vector<Wall> walls() {
  const auto table = synthetic_mcpet(mcpet_theta_i_deg, 2.5);
  return {
      {"diffuse", std::make_shared<const Surface>("diffuse", Lambertian{mcpet_total})},
      {"diffuse/specular", std::make_shared<const Surface>("two", mcpet_diffuse_specular())},
      {"tabular", std::make_shared<const Surface>("table", PlanesSurface(table, 0, mcpet_total))}};
}

MixingChamber chamber_of(const Wall& wall) {
  MixingChamber c;
  c.wall = wall.surface;
  return c;
}

// The chamber of triangles.
class TriangleChamber {
 public:
  TriangleChamber(const umov::trace::Scene& scene, int sides, double head_start)
      : bare_(head_start) {
    for (const auto& tube : scene.tubes) {
      for (int i = 0; i < sides; ++i) {
        const auto corner = [&](int k, double z) {
          const double a = 2.0 * pi * k / sides;
          return std::array<double, 3>{tube.x + tube.radius * std::cos(a),
                                       tube.y + tube.radius * std::sin(a), z};
        };
        quad(corner(i, tube.bottom), corner(i + 1, tube.bottom), corner(i + 1, tube.top),
             corner(i, tube.top));
      }
    }
    for (const auto& plate : scene.plates) {
      const int rings = plate.holes.empty() ? 1 : sides / 4;
      for (int r = 0; r < rings; ++r) {
        for (int i = 0; i < sides; ++i) {
          const auto corner = [&](int ring, double k) {
            const double a = 2.0 * pi * k / sides;
            const double at = plate.radius * ring / rings;
            return std::array<double, 3>{plate.x + at * std::cos(a), plate.y + at * std::sin(a),
                                         plate.z};
          };
          const auto middle = corner(r, i + 0.5);
          const bool in_hole =
              std::any_of(plate.holes.begin(), plate.holes.end(), [&](const auto& hole) {
                return std::hypot(middle[0] - hole.x, middle[1] - hole.y) < hole.radius;
              });
          if (!in_hole)
            quad(corner(r, i), corner(r + 1, i), corner(r + 1, i + 1), corner(r, i + 1));
        }
      }
    }
    bare_.add_triangles(vertices_, faces_);
    bare_.build();
  }

  std::size_t triangles() const { return faces_.size(); }

  double shoot(const std::vector<umov::trace::Geometry::SingleRay>& rays,
               std::uint64_t& hits) const {
    return bare_.shoot(rays, hits);
  }

 private:
  void quad(const std::array<double, 3>& a, const std::array<double, 3>& b,
            const std::array<double, 3>& c, const std::array<double, 3>& d) {
    const auto first = static_cast<std::uint32_t>(vertices_.size());
    for (const auto& p : {a, b, c, d}) {
      vertices_.push_back(
          {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    }
    faces_.push_back({first, first + 1, first + 2});
    faces_.push_back({first, first + 2, first + 3});
  }

  umov::bench::BareEmbree bare_;
  std::vector<std::array<float, 3>> vertices_;
  std::vector<std::array<std::uint32_t, 3>> faces_;
};

// Paths of the camera through random pixels of the map; one thread.
double trace(const Tracer& tracer, const Camera& camera, std::uint64_t paths, Work& work,
             double& sum) {
  const Vec3 towards = camera.towards();
  const Vec3 right = camera.right();
  const Vec3 up = camera.up();
  const double start = processor_seconds();
  for (std::uint64_t i = 0; i < paths; ++i) {
    const auto u = umov::trace::uniforms(1, i, 0);
    const double x = 60.0 * (u[0] - 0.5);
    const double y = 25.0 * (u[1] - 0.5);
    const Vec3 origin = camera.centre + x * right + y * up + 200.0 * towards;
    sum += tracer.luminance(origin, -towards, Estimator::mis, 1, i, work);
  }
  return processor_seconds() - start;
}

nlohmann::json rate(const Wall& wall, std::uint64_t paths) {
  const MixingChamber chamber = chamber_of(wall);
  const Luminaire luminaire = chamber.luminaire();
  Tracer tracer(luminaire);
  const Camera camera = chamber.camera();
  std::vector<umov::trace::Geometry::SingleRay> rays;
  double sum = 0.0;
  Work work;
  tracer.geometry().record(&rays);
  trace(tracer, camera, paths, work, sum);
  tracer.geometry().record(nullptr);
  const TriangleChamber coarse(luminaire.scene, 24, tracer.geometry().head_start());
  const TriangleChamber fine(luminaire.scene, 256, tracer.geometry().head_start());
  double best = 1e300, best_coarse = 1e300, best_fine = 1e300;
  std::uint64_t hits = 0;
  for (int run = 0; run < 5; ++run) {  // in turn, so that all meet the same machine
    best = std::min(best, trace(tracer, camera, paths, work, sum));
    hits = 0;
    best_coarse = std::min(best_coarse, coarse.shoot(rays, hits));
    best_fine = std::min(best_fine, fine.shoot(rays, hits));
  }
  const double count = static_cast<double>(rays.size());
  return {{"wall", wall.name},
          {"paths", paths},
          {"rays_per_path", count / static_cast<double>(paths)},
          {"rays_per_s", count / best},
          {"triangles", {coarse.triangles(), fine.triangles()}},
          {"bare_rays_per_s", {count / best_coarse, count / best_fine}},
          {"share", {best_coarse / best, best_fine / best}},
          {"mean_cd_m2", sum / (6.0 * static_cast<double>(paths))}};
}

template <class Work_>
nlohmann::json timed(const Work_& work) {
  const auto start = std::chrono::steady_clock::now();
  const double before = processor_seconds(CLOCK_PROCESS_CPUTIME_ID);
  nlohmann::json row = work();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  row["wall_s"] = wall.count();
  row["processor_s"] = processor_seconds(CLOCK_PROCESS_CPUTIME_ID) - before;
  return row;
}

nlohmann::json map(const Wall& wall, std::uint64_t rays) {
  const MixingChamber chamber = chamber_of(wall);
  const Luminaire luminaire = chamber.luminaire();
  const Tracer tracer(luminaire);
  return timed([&]() -> nlohmann::json {
    MapRequest request;
    request.rays_per_pixel = rays;
    const Map taken = luminance_map(tracer, chamber.camera(), request);
    return {{"wall", wall.name},
            {"paths", 37500 * rays},
            {"rays", taken.work.rays},
            {"mean_cd_m2", evenness(taken).mean}};
  });
}

nlohmann::json lid(const Wall& wall, std::uint64_t rays) {
  const MixingChamber chamber = chamber_of(wall);
  const Luminaire luminaire = chamber.luminaire();
  const Tracer tracer(luminaire);
  return timed([&]() -> nlohmann::json {
    const Distribution d = intensity_distribution(tracer, {.rays = rays, .planes = 8});
    return {{"wall", wall.name},
            {"launches", d.rays_launched},
            {"rays", d.fate.work.rays},
            {"efficiency", d.efficiency()}};
  });
}

nlohmann::json noise(const Wall& wall, std::uint64_t rays) {
  const MixingChamber chamber = chamber_of(wall);
  const Luminaire luminaire = chamber.luminaire();
  const Tracer tracer(luminaire);
  const Camera camera = chamber.camera(10);
  nlohmann::json row = {{"wall", wall.name}};
  const std::array names{"unidirectional", "next_event", "mis"};
  for (std::size_t e = 0; e < names.size(); ++e) {
    MapRequest request;
    request.rays_per_pixel = rays;
    request.estimator = static_cast<Estimator>(e);
    const Map taken = luminance_map(tracer, camera, request);
    double variance = 0.0;
    for (const double se : taken.luminance_se) variance += se * se;
    const double pixels = static_cast<double>(taken.luminance_se.size());
    // Of one pixel, if a thousand rays were spent on it.
    const double per_pixel = static_cast<double>(taken.work.rays) / pixels;
    row[names[e]] = std::sqrt(variance / pixels * per_pixel / 1000.0);
  }
  return row;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  const long given = argc > 2 ? std::atol(argv[2]) : 0;
  const auto number = [&](std::uint64_t preset) {
    return given > 0 ? static_cast<std::uint64_t>(given) : preset;
  };
  nlohmann::json rows = nlohmann::json::array();
  for (const Wall& wall : walls()) {
    if (what == "rate") rows.push_back(rate(wall, number(300'000)));
    if (what == "map") rows.push_back(map(wall, number(1000)));
    if (what == "lid") rows.push_back(lid(wall, number(2'000'000)));
    if (what == "noise") rows.push_back(noise(wall, number(3000)));
  }
  if (rows.empty()) {
    std::fputs("bench_chamber rate|map|lid|noise [NUMBER]\n", stderr);
    return 2;
  }
  std::puts(rows.dump(1).c_str());
  return 0;
}
