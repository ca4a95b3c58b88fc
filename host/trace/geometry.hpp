// The nearest face along a ray.
//
// Embree, in single precision, proposes faces; each is decided in double precision: a ray starts
// exactly where it starts, so no offset along it is needed and none is used. A face on which the
// start lies (within 1e-12 of the scene's extent) is not met again at the start: a plane not at
// all, a sphere at its far side only.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "host/trace/scene.hpp"

struct RTCSceneTy;

namespace umov::trace {

struct Hit {
  double distance;
  Vec3 position;
  Vec3 normal;  ///< unit length, towards the front of the face
  MaterialId material;
};

class Geometry {
 public:
  /// Builds the search tree (about 1 µs a face), on one thread, so that it is the same each time.
  /// In a periodic scene, spheres over an edge are there a second time on the other side.
  explicit Geometry(const Scene& scene);
  ~Geometry();
  Geometry(const Geometry&) = delete;
  Geometry& operator=(const Geometry&) = delete;

  /// The nearest face at a distance above 0 and up to `limit`. `direction` has unit length.
  std::optional<Hit> nearest(const Vec3& origin, const Vec3& direction, double limit) const;

  /// The material of that face, without where it was met: less work for those who only ask
  /// whether something is in between.
  std::optional<MaterialId> nearest_material(const Vec3& origin, const Vec3& direction,
                                             double limit) const;

  double top() const { return top_; }        ///< no face is higher
  double bottom() const { return bottom_; }  ///< no face is lower

  /// A ray as Embree gets it.
  struct SingleRay {
    float origin[3], direction[3], limit;
  };
  /// From now on every ray is also written down, for measurements of speed; one thread only.
  /// Nothing: no longer.
  void record(std::vector<SingleRay>* rays) { record_ = rays; }
  /// How far before its start Embree begins a ray.
  double head_start() const;

 private:
  struct Search;
  struct Face;
  struct Mesh;
  struct Balls;
  struct Rounds;

  void find(const Vec3& origin, const Vec3& direction, double limit, Search& search) const;

  RTCSceneTy* embree_ = nullptr;
  std::unique_ptr<Balls> balls_;
  std::unique_ptr<Rounds> rounds_;
  std::vector<std::unique_ptr<Mesh>> meshes_;
  double top_ = 0.0;
  double bottom_ = 0.0;
  double extent_ = 0.0;
  std::vector<SingleRay>* record_ = nullptr;
};

}  // namespace umov::trace
