// Embree by itself, shot with the very rays that the ray engine has found faces for. Nothing else
// is done with what it finds.
#pragma once

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <ctime>
#include <vector>

#include "host/trace/geometry.hpp"

namespace umov::bench {

inline double processor_seconds(clockid_t clock = CLOCK_THREAD_CPUTIME_ID) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// A scene of Embree's own primitives, robust and built for speed.
class BareEmbree {
 public:
  /// Rays start behind what the engine begins before their start.
  explicit BareEmbree(double head_start)
      : device_(rtcNewDevice("threads=1")),
        scene_(rtcNewScene(device_)),
        near_(static_cast<float>(2.0 * head_start)) {
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
  }
  ~BareEmbree() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  BareEmbree(const BareEmbree&) = delete;
  BareEmbree& operator=(const BareEmbree&) = delete;

  void add_triangles(const std::vector<std::array<float, 3>>& vertices,
                     const std::vector<std::array<std::uint32_t, 3>>& faces) {
    RTCGeometry g = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    fill(g, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, vertices);
    fill(g, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, faces);
    attach(g);
  }
  /// Centre and radius.
  void add_spheres(const std::vector<std::array<float, 4>>& spheres) {
    RTCGeometry g = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    fill(g, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, spheres);
    attach(g);
  }
  void build() { rtcCommitScene(scene_); }

  /// Processor seconds for all rays; the number of hits is added to `hits`.
  double shoot(const std::vector<trace::Geometry::SingleRay>& rays, std::uint64_t& hits) const {
    const double start = processor_seconds();
    for (const trace::Geometry::SingleRay& ray : rays) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      RTCRayHit r;
      r.ray.org_x = ray.origin[0];
      r.ray.org_y = ray.origin[1];
      r.ray.org_z = ray.origin[2];
      r.ray.dir_x = ray.direction[0];
      r.ray.dir_y = ray.direction[1];
      r.ray.dir_z = ray.direction[2];
      r.ray.tnear = near_;
      r.ray.tfar = std::max(near_, ray.limit);
      r.ray.time = 0.0F;
      r.ray.mask = ~0U;
      r.ray.id = 0;
      r.ray.flags = 0;
      r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene_, &context, &r);
      hits += r.hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
    }
    return processor_seconds() - start;
  }

 private:
  template <class Row>
  static void fill(RTCGeometry g, RTCBufferType type, RTCFormat format,
                   const std::vector<Row>& rows) {
    void* buffer = rtcSetNewGeometryBuffer(g, type, 0, format, sizeof(Row), rows.size());
    std::copy(rows.begin(), rows.end(), static_cast<Row*>(buffer));
  }
  void attach(RTCGeometry g) {
    rtcCommitGeometry(g);
    rtcAttachGeometry(scene_, g);
    rtcReleaseGeometry(g);
  }

  RTCDevice device_;
  RTCScene scene_;
  float near_;
};

}  // namespace umov::bench
