#include "host/chamber/camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/frames.hpp"
#include "host/parallel/for_each_index.hpp"
#include "host/trace/random_stream.hpp"

namespace umov::chamber {

using optics::radians;

Vec3 Camera::towards() const {
  const double s = std::sin(radians(view_deg));
  const double a = radians(azimuth_deg);
  return {s * std::cos(a), s * std::sin(a), std::cos(radians(view_deg))};
}

Vec3 Camera::right() const {
  const double a = radians(azimuth_deg);
  return {-std::sin(a), std::cos(a), 0.0};
}

Vec3 Camera::up() const {
  return optics::cross(towards(), right());
}

Map luminance_map(const Tracer& tracer, const Camera& camera, const MapRequest& request) {
  if (camera.width == 0 || camera.height == 0 || !(camera.pixel_mm > 0.0)) {
    throw Error(fmt::format("a map of {} × {} pixels of {:g} mm", camera.width, camera.height,
                            camera.pixel_mm),
                "give it pixels");
  }
  if (!(camera.view_deg >= 0.0 && camera.view_deg < 90.0)) {
    throw Error(fmt::format("an observer at {:g}° from the axis", camera.view_deg),
                "choose 0 to below 90°");
  }
  if (request.rays_per_pixel < 2) {
    throw Error(fmt::format("{} rays a pixel", request.rays_per_pixel),
                "an error needs two at least");
  }
  Map map;
  map.width = camera.width;
  map.height = camera.height;
  map.pixel_mm = camera.pixel_mm;
  map.rays_per_pixel = request.rays_per_pixel;
  map.luminance_cd_m2.assign(map.width * map.height, 0.0);
  map.luminance_se = map.luminance_cd_m2;
  const Vec3 towards = camera.towards();
  const Vec3 right = camera.right();
  const Vec3 up = camera.up();
  // Outside of everything.
  double reach = 1.0;
  const auto& scene = tracer.luminaire().scene;
  for (const auto& tube : scene.tubes) {
    reach += std::abs(tube.x) + std::abs(tube.y) + 2.0 * tube.radius + std::abs(tube.top) +
             std::abs(tube.bottom);
  }
  for (const auto& plate : scene.plates) {
    reach += std::abs(plate.x) + std::abs(plate.y) + 2.0 * plate.radius + std::abs(plate.z);
  }
  for (const auto& mesh : scene.meshes) {
    for (const auto& v : mesh.vertices) {
      reach = std::max(reach,
                       2.0 * static_cast<double>(std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2])));
    }
  }
  reach += std::sqrt(optics::dot(camera.centre, camera.centre)) +
           camera.pixel_mm * static_cast<double>(camera.width + camera.height);
  const Vec3 eye = camera.centre + camera.distance_mm * towards;
  const std::size_t rows = camera.height;
  std::vector<Work> work(rows);
  constexpr std::size_t rows_at_once = 8;
  for (std::size_t start = 0; start < rows; start += rows_at_once) {
    if (request.progress) {
      request.progress(static_cast<double>(start) / static_cast<double>(rows));
    }
    const std::size_t count = std::min(rows_at_once, rows - start);
    for_each_index(count, request.threads, [&](std::size_t number) {
      const std::size_t y = start + number;
      for (std::size_t x = 0; x < map.width; ++x) {
        const std::uint64_t pixel = y * map.width + x;
        double sum = 0.0;
        double squares = 0.0;
        for (std::uint64_t ray = 0; ray < request.rays_per_pixel; ++ray) {
          const std::uint64_t path = pixel * request.rays_per_pixel + ray;
          const auto u = trace::uniforms(request.seed, path, 0);
          const double across =
              static_cast<double>(x) + u[0] - 0.5 * static_cast<double>(map.width);
          const double high = static_cast<double>(y) + u[1] - 0.5 * static_cast<double>(map.height);
          const Vec3 point =
              camera.centre + map.pixel_mm * across * right + map.pixel_mm * high * up;
          Vec3 origin = point + reach * towards;
          Vec3 direction = -towards;
          if (camera.distance_mm > 0.0) {
            origin = eye;
            direction = point - eye;
            direction /= std::sqrt(optics::dot(direction, direction));
          }
          const double seen = tracer.luminance(origin, direction, request.estimator, request.seed,
                                               path, work[start + number]);
          sum += seen;
          squares += seen * seen;
        }
        const double n = static_cast<double>(request.rays_per_pixel);
        const double mean = sum / n;
        map.luminance_cd_m2[pixel] = mean;
        map.luminance_se[pixel] = std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1.0));
      }
    });
  }
  for (const Work& one : work) {
    map.work.rays += one.rays;
    map.work.endless += one.endless;
  }
  return map;
}

}  // namespace umov::chamber
