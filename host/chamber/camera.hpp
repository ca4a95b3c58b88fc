// The luminance camera: a map of what an observer sees of a luminaire, with its standard errors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/chamber/tracer.hpp"
#include "host/parallel/team.hpp"

namespace umov::chamber {

/// A window of pixels across the view through a centre, as [M] puts it through the middle of the
/// opening. Parallel rays, or rays that meet in the eye.
struct Camera {
  Vec3 centre{0.0, 0.0, 0.0};  ///< mm
  double view_deg = 55.0;      ///< of the observer from +z
  double azimuth_deg = 270.0;  ///< of the observer; Y of the map then runs along +y
  double distance_mm = 0.0;    ///< of the eye from the centre; 0: far away
  std::size_t width = 300, height = 125;
  double pixel_mm = 0.2;

  /// Towards the observer; right and up in the map.
  Vec3 towards() const;
  Vec3 right() const;
  Vec3 up() const;
};

/// Row by row from below; pixel (0, 0) is at the lower left.
struct Map {
  std::size_t width = 0, height = 0;
  double pixel_mm = 1.0;
  std::vector<double> luminance_cd_m2, luminance_se;
  std::uint64_t rays_per_pixel = 0;
  /// Of a luminaire with bands: spectral radiance in W/(m² sr nm), band after band; the luminance
  /// is its V(λ)-weighted sum.
  std::vector<double> wavelengths_um, radiance, radiance_se;
  Work work;

  double at(std::size_t x, std::size_t y) const { return luminance_cd_m2[y * width + x]; }
};

struct MapRequest {
  std::uint64_t rays_per_pixel = 1000;  ///< at least 2
  Estimator estimator = Estimator::mis;
  std::uint64_t seed = 1;
  int threads = 0;                            ///< 0: all cores; the map does not depend on it
  std::function<void(double)> progress = {};  ///< share that is done; may throw to stop
  const Team* team = nullptr;  ///< all must make the same request; the map does not depend on it
};

/// Throws umov::Error for a window without pixels, a view from 90° or more, fewer than 2 rays.
Map luminance_map(const Tracer& tracer, const Camera& camera, const MapRequest& request);

}  // namespace umov::chamber
