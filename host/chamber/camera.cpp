#include "host/chamber/camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/frames.hpp"
#include "host/trace/random_stream.hpp"

namespace umov::chamber {

using optics::radians;

namespace {

void check(const Camera& camera, const MapRequest& request) {
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
}

/// How far from the window's centre parallel rays start: outside of everything.
double beyond(const trace::Scene& scene, const Camera& camera) {
  double reach = 1.0;
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
  return reach + std::sqrt(optics::dot(camera.centre, camera.centre)) +
         camera.pixel_mm * static_cast<double>(camera.width + camera.height);
}

/// Sums of one quantity over the rays of a pixel.
struct Spread {
  double sum = 0.0, squares = 0.0;
  void add(double x) {
    sum += x;
    squares += x * x;
  }
  double error(double n) const {
    const double mean = sum / n;
    return std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1.0));
  }
};

/// The rows of a map. A row as numbers: rays, paths given up; then luminance and its error pixel by
/// pixel, then radiance and its error band by band, of each band pixel by pixel.
class Rows {
 public:
  Rows(const Tracer& tracer, const Camera& camera, const MapRequest& request)
      : tracer_(tracer),
        camera_(camera),
        request_(request),
        towards_(camera.towards()),
        right_(camera.right()),
        up_(camera.up()),
        reach_(beyond(tracer.luminaire().scene, camera)),
        bands_(tracer.luminaire().bands ? tracer.luminaire().bands->size() : 0) {}

  std::size_t numbers() const { return 2 + 2 * camera_.width * (1 + bands_); }
  std::size_t bands() const { return bands_; }

  void trace(std::size_t y, std::span<double> out) const {
    Work work;
    const double n = static_cast<double>(request_.rays_per_pixel);
    std::vector<double> radiance(bands_);
    std::vector<Spread> sums(1 + bands_);
    for (std::size_t x = 0; x < camera_.width; ++x) {
      std::fill(sums.begin(), sums.end(), Spread{});
      const std::uint64_t first = (y * camera_.width + x) * request_.rays_per_pixel;
      for (std::uint64_t ray = 0; ray < request_.rays_per_pixel; ++ray) {
        sums[0].add(look(x, y, first + ray, radiance, work));
        for (std::size_t b = 0; b < bands_; ++b) sums[1 + b].add(radiance[b]);
      }
      for (std::size_t k = 0; k <= bands_; ++k) {
        out[2 + 2 * k * camera_.width + x] = sums[k].sum / n;
        out[2 + (2 * k + 1) * camera_.width + x] = sums[k].error(n);
      }
    }
    out[0] = static_cast<double>(work.rays);
    out[1] = static_cast<double>(work.endless);
  }

 private:
  double look(std::size_t x, std::size_t y, std::uint64_t path, std::vector<double>& radiance,
              Work& work) const {
    const auto u = trace::uniforms(request_.seed, path, 0);
    const double across = static_cast<double>(x) + u[0] - 0.5 * static_cast<double>(camera_.width);
    const double high = static_cast<double>(y) + u[1] - 0.5 * static_cast<double>(camera_.height);
    const Vec3 point =
        camera_.centre + camera_.pixel_mm * across * right_ + camera_.pixel_mm * high * up_;
    Vec3 origin = point + reach_ * towards_;
    Vec3 direction = -towards_;
    if (camera_.distance_mm > 0.0) {
      origin = camera_.centre + camera_.distance_mm * towards_;
      direction = point - origin;
      direction /= std::sqrt(optics::dot(direction, direction));
    }
    if (bands_ == 0) {
      return tracer_.luminance(origin, direction, request_.estimator, request_.seed, path, work);
    }
    tracer_.radiance(origin, direction, request_.estimator, request_.seed, path, radiance, work);
    return tracer_.luminaire().bands->luminous(radiance);
  }

  const Tracer& tracer_;
  const Camera& camera_;
  const MapRequest& request_;
  Vec3 towards_, right_, up_;
  double reach_;
  std::size_t bands_;
};

/// Writes row `y` of each of a map's planes from the numbers of Rows.
void put_row(Map& map, std::size_t y, const double* numbers) {
  const auto width = static_cast<std::ptrdiff_t>(map.width);
  map.work.rays += static_cast<std::uint64_t>(numbers[0]);
  map.work.endless += static_cast<std::uint64_t>(numbers[1]);
  const double* next = numbers + 2;
  const auto put = [&](std::vector<double>& plane, std::size_t band) {
    const std::size_t at = (band * map.height + y) * map.width;
    std::copy(next, next + width, plane.begin() + static_cast<std::ptrdiff_t>(at));
    next += width;
  };
  put(map.luminance_cd_m2, 0);
  put(map.luminance_se, 0);
  for (std::size_t b = 0; b < map.wavelengths_um.size(); ++b) {
    put(map.radiance, b);
    put(map.radiance_se, b);
  }
}

}  // namespace

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
  check(camera, request);
  Map map;
  map.width = camera.width;
  map.height = camera.height;
  map.pixel_mm = camera.pixel_mm;
  map.rays_per_pixel = request.rays_per_pixel;
  map.luminance_cd_m2.assign(map.width * map.height, 0.0);
  map.luminance_se = map.luminance_cd_m2;
  if (tracer.luminaire().bands) map.wavelengths_um = tracer.luminaire().bands->wavelengths_um();
  const Rows rows(tracer, camera, request);
  map.radiance.assign(rows.bands() * map.width * map.height, 0.0);
  map.radiance_se = map.radiance;
  const std::size_t ranks = request.team == nullptr ? 1 : request.team->size();
  const std::size_t at_once = 8 * ranks;
  for (std::size_t start = 0; start < map.height; start += at_once) {
    if (request.progress) {
      request.progress(static_cast<double>(start) / static_cast<double>(map.height));
    }
    const std::size_t count = std::min(at_once, map.height - start);
    const std::vector<double> traced = for_each_index_of_team(
        count, rows.numbers(), request.threads, request.team,
        [&](std::size_t i, std::span<double> out) { rows.trace(start + i, out); });
    for (std::size_t i = 0; i < count; ++i)
      put_row(map, start + i, traced.data() + i * rows.numbers());
  }
  return map;
}

}  // namespace umov::chamber
