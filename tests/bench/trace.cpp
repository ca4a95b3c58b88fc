// Measures the ray engine: how much of Embree's own rate is left when its rays carry polarised
// light, and how long a hemisphere takes. Prints JSON.
//
//   bench_trace rate [LAUNCHES]         against bare Embree, on one thread, processor time
//   bench_trace hemisphere [LAUNCHES]   1,000 particles, 11 bands, all cores, wall clock
//   bench_trace threads [LAUNCHES]      the same on one thread and on two, wall clock
//   bench_trace glints [LAUNCHES]       mirror spheres against their closed form, by size of cell
//
// Bare Embree gets the very rays of the paths, in their order, in a scene of its own primitives
// (single precision spheres, triangles without a filter), and starts them behind what this engine
// begins before their start. Nothing else is done with what it finds.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/errors/error.hpp"
#include "host/trace/launch.hpp"
#include "host/trace/simulation.hpp"
#include "tests/bench/bare_embree.hpp"

namespace {

using namespace umov::trace;
using umov::bench::BareEmbree;
using umov::bench::processor_seconds;
using umov::optics::radians;

std::vector<double> bands(std::size_t count) {
  std::vector<double> wavelengths;
  for (std::size_t i = 0; i < count; ++i) {
    wavelengths.push_back(count == 1 ? 0.55 : 0.4 + 0.05 * static_cast<double>(i));
  }
  return wavelengths;
}

// Spheres that touch the ground and cover 30 % of it, moved at random in a square lattice, in no
// order.
void strew(Scene& scene, std::size_t side, MaterialId material) {
  const double cell = 1.0 / static_cast<double>(side);
  const double radius = cell * std::sqrt(0.3 / umov::optics::pi);
  const double play = cell - 2.0 * radius;
  for (std::size_t i = 0; i < side * side; ++i) {
    const auto u = uniforms(99, i, 0);
    const double x = static_cast<double>(i % side) * cell + radius + play * u[0];
    const double y = static_cast<double>(i / side) * cell + radius + play * u[1];
    scene.spheres.push_back({Vec3(x, y, radius), radius, material});
  }
  for (std::size_t i = scene.spheres.size(); i-- > 1;) {
    const double other = uniforms(97, i, 0)[0] * static_cast<double>(i + 1);
    std::swap(scene.spheres[i], scene.spheres[static_cast<std::size_t>(other)]);
  }
}

std::vector<double> spectrum(const Scene& scene, double value) {
  return std::vector<double>(scene.wavelengths_um.size(), value);
}

Scene soil(std::size_t side, std::size_t count) {
  Scene scene(bands(count));
  scene.add_plane(0.0, scene.add(Lambertian{spectrum(scene, 0.3)}));
  strew(scene, side, scene.add(Lambertian{spectrum(scene, 0.5)}));
  return scene;
}

Scene drops(std::size_t side, std::size_t count) {
  Scene scene(bands(count));
  scene.add_plane(0.0, scene.add(Lambertian{spectrum(scene, 0.04)}));
  Medium water;
  for (const double wavelength : scene.wavelengths_um) {
    water.n.push_back(1.324 + 0.0031 / (wavelength * wavelength));
    water.kappa.push_back(0.0);
  }
  strew(scene, side, scene.add(Interface{scene.add(std::move(water))}));
  return scene;
}

Scene rough(std::size_t side, std::size_t count) {
  Scene scene(bands(count));
  std::vector<double> heights;
  for (std::size_t i = 0; i < side * side; ++i) {
    heights.push_back(0.5 * uniforms(98, i, 0)[0] / static_cast<double>(side));
  }
  scene.add_height_field(side, side, heights,
                         scene.add(Conductor{spectrum(scene, 1.2), spectrum(scene, 7.0)}));
  return scene;
}

// Counts, so that the compiler cannot leave anything out.
class Sum : public Collector {
 public:
  void collect(const Exit& exit) override { sum += exit.weight[0][0]; }
  double sum = 0.0;
};

struct Traced {
  double seconds;
  std::uint64_t rays;
};

Traced trace(const PathTracer& tracer, std::uint64_t launches) {
  const Scene& scene = tracer.scene();
  PathTracer::Workspace workspace(tracer);
  Ledger ledger(scene.wavelengths_um.size());
  Sum sum;
  const auto beam = umov::optics::incident_beam(radians(30.0));
  const double start = processor_seconds();
  for (std::uint64_t i = 0; i < launches; ++i) {
    const auto at = launch_point(i, launches, uniforms(1, i, 0));
    tracer.trace(Vec3(at[0] * scene.size_x, at[1] * scene.size_y, tracer.geometry().top() + 1e-3),
                 beam, 1, i, workspace, sum, ledger);
  }
  return {processor_seconds() - start, ledger.rays};
}

void copy_faces(const Scene& scene, BareEmbree& bare) {
  for (const Triangles& mesh : scene.meshes) bare.add_triangles(mesh.vertices, mesh.faces);
  if (!scene.spheres.empty()) {
    std::vector<std::array<float, 4>> spheres;
    for (const Sphere& s : scene.spheres) {
      spheres.push_back({static_cast<float>(s.centre.x), static_cast<float>(s.centre.y),
                         static_cast<float>(s.centre.z), static_cast<float>(s.radius)});
    }
    bare.add_spheres(spheres);
  }
  bare.build();
}

// `launches`, or as many as there are faces where these are more: a block of a simulation of it.
nlohmann::json rate(const std::string& name, const Scene& scene, std::uint64_t launches) {
  launches = std::max(launches, scene.faces());
  const double before = processor_seconds();
  Geometry geometry(scene);
  const double build = processor_seconds() - before;
  const PathTracer tracer(scene, geometry);
  std::vector<Geometry::SingleRay> rays;
  geometry.record(&rays);
  trace(tracer, launches);
  geometry.record(nullptr);
  BareEmbree bare(geometry.head_start());
  copy_faces(scene, bare);
  double best = 1e300;
  double best_bare = 1e300;
  std::uint64_t hits = 0;
  for (int run = 0; run < 5; ++run) {  // in turn, so that both meet the same machine
    best = std::min(best, trace(tracer, launches).seconds);
    hits = 0;
    best_bare = std::min(best_bare, bare.shoot(rays, hits));
  }
  const double count = static_cast<double>(rays.size());
  return {{"scene", name},
          {"wavelengths", scene.wavelengths_um.size()},
          {"build_s", build},
          {"launches", launches},
          {"rays", rays.size()},
          {"rays_per_launch", count / static_cast<double>(launches)},
          {"hit_share_bare", static_cast<double>(hits) / count},
          {"rays_per_s", count / best},
          {"bare_rays_per_s", count / best_bare},
          {"share", best_bare / best}};
}

nlohmann::json hemisphere(const std::string& name, const Scene& scene, std::uint64_t launches) {
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  const Hemisphere cells(18, 180, radians(2.0));
  Request request;
  request.theta_i = radians(20.0);
  request.samples = launches;
  const auto start = std::chrono::steady_clock::now();
  const Result result = simulate(tracer, cells, request);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  double dhr = 0.0;
  std::vector<double> errors;
  for (std::size_t w = 0; w < scene.wavelengths_um.size(); ++w) {
    const MuellerEstimate all = result.hemispherical(w);
    dhr = std::max(dhr, all.error[0][0] / all.mean[0][0]);
    for (std::size_t cell = 0; cell < cells.cells(); ++cell) {
      const MuellerEstimate e = result.brdf(cell, w);
      errors.push_back(e.mean[0][0] > 0.0 ? e.error[0][0] / e.mean[0][0] : 1e3);
    }
  }
  std::sort(errors.begin(), errors.end());
  const double median = errors[errors.size() / 2];
  const Ledger& ledger = result.ledger();
  return {{"scene", name},
          {"launches", result.samples()},
          {"wall_s", taken.count()},
          {"dhr_relative_error", dhr},
          {"cell_relative_error_median", median},
          {"wall_s_to_dhr_1_percent", taken.count() * dhr * dhr / 1e-4},
          {"wall_s_to_cells_3_percent", taken.count() * median * median / 9e-4},
          {"lost_share", ledger.lost[0] / ledger.launched[0]}};
}

// Best of five in turn, so that both numbers of threads meet the same machine.
nlohmann::json threads(const std::string& name, const Scene& scene, std::uint64_t launches) {
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  const Hemisphere cells(18, 180, radians(2.0));
  double best[2] = {1e300, 1e300};
  for (int run = 0; run < 5; ++run) {
    for (int count = 1; count <= 2; ++count) {
      Request request;
      request.theta_i = radians(20.0);
      request.samples = launches;
      request.threads = count;
      const auto start = std::chrono::steady_clock::now();
      simulate(tracer, cells, request);
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
      best[count - 1] = std::min(best[count - 1], taken.count());
    }
  }
  return {{"scene", name}, {"one_s", best[0]}, {"two_s", best[1]}, {"gain", best[0] / best[1]}};
}

// Mirror spheres far from each other on black ground: each sends what it meets evenly all round, so
// that the mean BRDF of a cell (weighted by cos θr) is C/(4π cos θi) · ΔΩ/∫cos θr dΩ, C what they
// cover seen from above. Light that meets a second sphere is left out.
nlohmann::json glints(std::size_t rings, std::size_t strip, std::uint64_t launches) {
  Scene scene(bands(1));
  scene.add_plane(0.0, scene.add(Lambertian{{0.0}}));
  constexpr double radius = 0.08;
  scene.spheres.push_back({Vec3(0.5, 0.5, radius), radius, scene.add(Conductor{{1.0}, {1e7}})});
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  const Hemisphere cells(rings, strip, radians(2.0));
  Request request;
  request.theta_i = radians(20.0);
  request.samples = launches;
  request.most_meetings = 1;  // from one sphere to another is not in the formula
  const Result result = simulate(tracer, cells, request);
  const double power = radius * radius / (4.0 * std::cos(request.theta_i));  // πr²/(4π cos θi)
  // Up to 80°: beyond, neighbours are in the way.
  double weighted = 0.0;
  double weights = 0.0;
  double errors2 = 0.0;
  double squares = 0.0;
  int count = 0;
  double narrowest = 1e300;
  const std::size_t first = strip > 0 ? cells.cells() : 0;
  for (std::size_t i = first; i < (strip > 0 ? cells.size() : cells.cells()); ++i) {
    const Cell cell = cells.cell(i);
    if (std::max(std::abs(cell.theta_low), std::abs(cell.theta_high)) > radians(80.0)) continue;
    const MuellerEstimate found = result.brdf(i, 0);
    const double expected = power * cell.solid_angle / cell.projected;
    const double ratio = found.mean[0][0] / expected;
    // Weights from what is expected: from what was found they would favour cells that saw little.
    weighted += cell.solid_angle * ratio;
    weights += cell.solid_angle;
    errors2 += std::pow(cell.solid_angle * found.error[0][0] / expected, 2);
    if (found.error[0][0] > 0.0) {
      const double z = (found.mean[0][0] - expected) / found.error[0][0];
      squares += z * z;
      ++count;
    }
    narrowest = std::min(narrowest, cell.solid_angle);
  }
  return {{"cells", strip > 0 ? "strip" : "all round"},
          {"solid_angle_sr", narrowest},
          {"number", count},
          {"mean_ratio", weighted / weights},
          {"error", std::sqrt(errors2) / weights},
          {"chi2_per_cell", squares / count}};
}

int run(const std::string& what, std::uint64_t launches) {
  nlohmann::json rows = nlohmann::json::array();
  if (what == "rate") {
    for (const std::size_t count : {std::size_t{1}, std::size_t{11}}) {
      rows.push_back(rate("soil, 100 spheres", soil(10, count), launches));
      rows.push_back(rate("soil, 1,024 spheres", soil(32, count), launches));
      rows.push_back(rate("soil, 10⁴ spheres", soil(100, count), launches));
      if (count == 1) {
        rows.push_back(rate("soil, 10⁵ spheres", soil(316, count), launches));
        rows.push_back(rate("soil, 10⁶ spheres", soil(1000, count), launches));
      }
      rows.push_back(rate("drops of 180°, 1,024", drops(32, count), launches));
      rows.push_back(rate("rough metal, 131,072 triangles", rough(256, count), launches));
    }
  } else if (what == "hemisphere") {
    rows.push_back(hemisphere("soil, 1,024 spheres", soil(32, 11), launches));
    rows.push_back(hemisphere("drops of 180°, 1,024", drops(32, 11), launches));
  } else if (what == "threads") {
    rows.push_back(threads("soil, 1,024 spheres", soil(32, 11), launches));
    rows.push_back(threads("drops of 180°, 1,024", drops(32, 11), launches));
  } else if (what == "glints") {
    for (const std::size_t rings : {3, 9, 18, 45, 90}) rows.push_back(glints(rings, 0, launches));
    for (const std::size_t strip : {18, 90, 360}) rows.push_back(glints(1, strip, launches));
  } else {
    return 2;
  }
  std::puts(rows.dump(1).c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  const long launches = argc > 2 ? std::atol(argv[2]) : 300'000;
  if (launches < 1 || run(what, static_cast<std::uint64_t>(launches)) != 0) {
    std::fputs("bench_trace rate|hemisphere|threads|glints [LAUNCHES]\n", stderr);
    return 2;
  }
  return 0;
}
