#include "host/trace/geometry.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host/errors/error.hpp"
#include "host/optics/frames.hpp"

namespace umov::trace {

using optics::cross;
using optics::dot;

namespace {

// Of the scene's extent: a start that near a face lies on it. Rounding of positions is 1e-15.
constexpr double on_face = 1e-12;
// Of the scene's extent: how far before its start Embree begins a ray, for single precision moves
// starts and faces by some 1e-7.
constexpr double single_precision = 1e-6;
// Farther than any face; a face parallel to the ray is at infinity.
constexpr double far_away = 1e30;

struct Device {
  RTCDevice device = rtcNewDevice("threads=1");
  Device() {
    if (device == nullptr) {
      throw Error("the ray tracing kernels do not start on this processor",
                  "Embree 3 needs at least SSE2; check the installation of libembree3");
    }
  }
  ~Device() { rtcReleaseDevice(device); }
};

}  // namespace

// What one search knows beside Embree's ray. Embree hands its first member to the callbacks.
struct Geometry::Search {
  RTCIntersectContext embree;
  Vec3 origin, direction;
  double nearest;  // distance of the best face so far, or the limit
  double extent;
  const void* owner = nullptr;
  std::uint32_t face = 0;

  static Search& of(RTCIntersectContext* context) { return *reinterpret_cast<Search*>(context); }
  // Embree's distance, a little more than the exact one so that near ties come to be decided here.
  float embree_distance(double distance) const {
    const double shifted = distance + 2.0 * single_precision * extent;
    return static_cast<float>(shifted * (1.0 + 1e-6));
  }
};

struct Geometry::Face {
  Vec3 corner, edge1, edge2;  // edges from the corner
  Vec3 normal;
  MaterialId material;
};

struct Geometry::Mesh {
  std::vector<Face> faces;

  static void decide(const RTCFilterFunctionNArguments* args);
  Vec3 inside(std::uint32_t face, const Vec3& position) const;
};

struct Geometry::Balls {
  std::vector<Sphere> spheres;
  double padding = 0.0;

  static void bounds(const RTCBoundsFunctionArguments* args);
  static void intersect(const RTCIntersectFunctionNArguments* args);
};

// Tubes, then plates, by number.
struct Geometry::Rounds {
  std::vector<Tube> tubes;
  std::vector<Plate> plates;
  double padding = 0.0;

  /// Calls work(face) with the face of that number.
  template <class Work>
  auto with(std::uint32_t number, const Work& work) const {
    return number < tubes.size() ? work(tubes[number]) : work(plates[number - tubes.size()]);
  }
  static void bounds(const RTCBoundsFunctionArguments* args);
  static void intersect(const RTCIntersectFunctionNArguments* args);
};

// Called for each triangle that Embree's ray meets before the best one so far.
void Geometry::Mesh::decide(const RTCFilterFunctionNArguments* args) {
  const auto& mesh = *static_cast<const Mesh*>(args->geometryUserPtr);
  const auto* hit = reinterpret_cast<const RTCHit*>(args->hit);
  Search& search = Search::of(args->context);
  const Face& face = mesh.faces[hit->primID];
  const double height = dot(face.normal, search.origin - face.corner);
  const double distance = -height / dot(face.normal, search.direction);
  if (std::abs(height) > on_face * search.extent && distance > 0.0 && distance <= search.nearest) {
    search.nearest = distance;
    search.owner = &mesh;
    search.face = hit->primID;
  } else {
    args->valid[0] = 0;
  }
}

// The point moved along the face until it is inside by 1e-6 of the face's size. Single precision
// may choose the neighbour of the right face; a start outside its face could then lie below that
// neighbour.
Vec3 Geometry::Mesh::inside(std::uint32_t index, const Vec3& position) const {
  constexpr double margin = 1e-6;
  const Face& f = faces[index];
  const Vec3 p = position - f.corner;
  const double a = dot(f.edge1, f.edge1);
  const double b = dot(f.edge1, f.edge2);
  const double c = dot(f.edge2, f.edge2);
  const double d1 = dot(p, f.edge1);
  const double d2 = dot(p, f.edge2);
  const double scale = 1.0 / (a * c - b * b);
  double u = (c * d1 - b * d2) * scale;
  double v = (a * d2 - b * d1) * scale;
  if (u >= margin && v >= margin && u + v <= 1.0 - margin) return position;
  u = std::clamp(u, margin, 1.0 - 3.0 * margin);
  v = std::clamp(v, margin, 1.0 - margin - u);
  return f.corner + u * f.edge1 + v * f.edge2;
}

void Geometry::Balls::bounds(const RTCBoundsFunctionArguments* args) {
  const auto& balls = *static_cast<const Balls*>(args->geometryUserPtr);
  const Sphere& s = balls.spheres[args->primID];
  const double reach = s.radius + balls.padding;
  const double bottom = std::max(s.centre.z - s.radius, s.base_z) - balls.padding;
  *args->bounds_o = {static_cast<float>(s.centre.x - reach),
                     static_cast<float>(s.centre.y - reach),
                     static_cast<float>(bottom),
                     0.0F,
                     static_cast<float>(s.centre.x + reach),
                     static_cast<float>(s.centre.y + reach),
                     static_cast<float>(s.centre.z + reach),
                     0.0F};
}

void Geometry::Balls::intersect(const RTCIntersectFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const auto& balls = *static_cast<const Balls*>(args->geometryUserPtr);
  const Sphere& s = balls.spheres[args->primID];
  Search& search = Search::of(args->context);
  const Vec3 from_centre = search.origin - s.centre;
  const double b = dot(from_centre, search.direction);
  const double radius2 = s.radius * s.radius;
  const double power = dot(from_centre, from_centre) - radius2;
  double first = 0.0;
  double second = 0.0;
  if (std::abs(power) <= 2.0 * s.radius * on_face * search.extent) {
    second = -2.0 * b;  // the start is on the sphere
  } else {
    const Vec3 across = from_centre - b * search.direction;
    const double chord2 = radius2 - dot(across, across);
    if (chord2 < 0.0) return;
    const double half = std::sqrt(chord2);
    first = -b - half;
    second = -b + half;
  }
  for (const double distance : {first, second}) {
    if (!(distance > 0.0) || distance > search.nearest) continue;
    if (search.origin.z + distance * search.direction.z < s.base_z) continue;
    search.nearest = distance;
    search.owner = &balls;
    search.face = args->primID;
    auto* rayhit = reinterpret_cast<RTCRayHit*>(args->rayhit);
    rayhit->ray.tfar = std::min(rayhit->ray.tfar, search.embree_distance(distance));
    rayhit->hit.geomID = args->geomID;
    rayhit->hit.primID = args->primID;
    return;
  }
}

void Geometry::Rounds::bounds(const RTCBoundsFunctionArguments* args) {
  const auto& rounds = *static_cast<const Rounds*>(args->geometryUserPtr);
  const Box box = rounds.with(args->primID, [](const auto& face) { return box_of(face); });
  const double pad = rounds.padding;
  *args->bounds_o = {static_cast<float>(box[0].x - pad), static_cast<float>(box[0].y - pad),
                     static_cast<float>(box[0].z - pad), 0.0F,
                     static_cast<float>(box[1].x + pad), static_cast<float>(box[1].y + pad),
                     static_cast<float>(box[1].z + pad), 0.0F};
}

void Geometry::Rounds::intersect(const RTCIntersectFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const auto& rounds = *static_cast<const Rounds*>(args->geometryUserPtr);
  Search& search = Search::of(args->context);
  const auto distance = rounds.with(args->primID, [&](const auto& face) {
    return meeting(face, search.origin, search.direction, search.nearest, on_face * search.extent);
  });
  if (!distance) return;
  search.nearest = *distance;
  search.owner = &rounds;
  search.face = args->primID;
  auto* rayhit = reinterpret_cast<RTCRayHit*>(args->rayhit);
  rayhit->ray.tfar = std::min(rayhit->ray.tfar, search.embree_distance(*distance));
  rayhit->hit.geomID = args->geomID;
  rayhit->hit.primID = args->primID;
}

Geometry::Geometry(const Scene& scene)
    : balls_(std::make_unique<Balls>()), rounds_(std::make_unique<Rounds>()) {
  scene.check();
  const double width = std::max(scene.size_x, scene.size_y);
  extent_ = width;
  bool empty = true;
  const auto include = [&](double low, double high) {
    bottom_ = empty ? low : std::min(bottom_, low);
    top_ = empty ? high : std::max(top_, high);
    empty = false;
  };

  for (const Triangles& mesh : scene.meshes) {
    auto& faces = meshes_.emplace_back(std::make_unique<Mesh>())->faces;
    faces.reserve(mesh.faces.size());
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      Vec3 corner[3];
      for (int k = 0; k < 3; ++k) {
        const auto& v = mesh.vertices[mesh.faces[i][static_cast<std::size_t>(k)]];
        corner[k] = Vec3(v[0], v[1], v[2]);
        include(corner[k].z, corner[k].z);
        extent_ = std::max({extent_, std::abs(corner[k].x), std::abs(corner[k].y)});
      }
      const Vec3 normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
      const double length = std::sqrt(dot(normal, normal));
      if (!(length > 0.0)) {
        throw Error(Place{"scene"}, "face " + std::to_string(i) + " of a mesh has no area",
                    "leave it out");
      }
      faces.push_back({corner[0], corner[1] - corner[0], corner[2] - corner[0], normal / length,
                       mesh.materials[i]});
    }
  }
  for (const Sphere& sphere : scene.spheres) {
    include(std::max(sphere.centre.z - sphere.radius, sphere.base_z),
            sphere.centre.z + sphere.radius);
    if (!scene.periodic) {
      balls_->spheres.push_back(sphere);
      extent_ = std::max({extent_, std::abs(sphere.centre.x) + sphere.radius,
                          std::abs(sphere.centre.y) + sphere.radius});
      continue;
    }
    const double reach = sphere.radius + 1e-6 * width;
    for (int i = -1; i <= 1; ++i) {
      for (int j = -1; j <= 1; ++j) {
        Sphere image = sphere;
        image.centre.x += i * scene.size_x;
        image.centre.y += j * scene.size_y;
        if (image.centre.x + reach < 0.0 || image.centre.x - reach > scene.size_x ||
            image.centre.y + reach < 0.0 || image.centre.y - reach > scene.size_y) {
          continue;
        }
        balls_->spheres.push_back(image);
      }
    }
  }
  rounds_->tubes = scene.tubes;
  rounds_->plates = scene.plates;
  const auto round_faces = static_cast<std::uint32_t>(scene.tubes.size() + scene.plates.size());
  for (std::uint32_t i = 0; i < round_faces; ++i) {
    const Box box = rounds_->with(i, [](const auto& face) { return box_of(face); });
    include(box[0].z, box[1].z);
    for (const Vec3& corner : box) {
      extent_ = std::max({extent_, std::abs(corner.x), std::abs(corner.y)});
    }
  }
  extent_ = std::max({extent_, std::abs(top_), std::abs(bottom_)});
  balls_->padding = rounds_->padding = 2.0 * single_precision * extent_;

  static const Device shared;
  embree_ = rtcNewScene(shared.device);
  rtcSetSceneFlags(embree_, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST));
  rtcSetSceneBuildQuality(embree_, RTC_BUILD_QUALITY_HIGH);
  for (std::size_t m = 0; m < meshes_.size(); ++m) {
    const Triangles& mesh = scene.meshes[m];
    RTCGeometry geometry = rtcNewGeometry(shared.device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             sizeof(mesh.vertices[0]), mesh.vertices.size());
    void* faces = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          sizeof(mesh.faces[0]), mesh.faces.size());
    std::copy(mesh.vertices.begin(), mesh.vertices.end(),
              static_cast<std::array<float, 3>*>(vertices));
    std::copy(mesh.faces.begin(), mesh.faces.end(),
              static_cast<std::array<std::uint32_t, 3>*>(faces));
    rtcSetGeometryUserData(geometry, meshes_[m].get());
    rtcSetGeometryIntersectFilterFunction(geometry, Mesh::decide);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(embree_, geometry);
    rtcReleaseGeometry(geometry);
  }
  if (!balls_->spheres.empty()) {
    RTCGeometry geometry = rtcNewGeometry(shared.device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned int>(balls_->spheres.size()));
    rtcSetGeometryUserData(geometry, balls_.get());
    rtcSetGeometryBoundsFunction(geometry, Balls::bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, Balls::intersect);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(embree_, geometry);
    rtcReleaseGeometry(geometry);
  }
  if (round_faces > 0) {
    RTCGeometry geometry = rtcNewGeometry(shared.device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, round_faces);
    rtcSetGeometryUserData(geometry, rounds_.get());
    rtcSetGeometryBoundsFunction(geometry, Rounds::bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, Rounds::intersect);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(embree_, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(embree_);
  if (const RTCError error = rtcGetDeviceError(shared.device); error != RTC_ERROR_NONE) {
    rtcReleaseScene(embree_);
    throw Error(Place{"scene"}, "Embree refuses it with error " + std::to_string(error),
                "error 3 is a shortage of memory: use fewer faces");
  }
}

Geometry::~Geometry() {
  rtcReleaseScene(embree_);
}

double Geometry::head_start() const {
  return single_precision * extent_;
}

std::optional<MaterialId> Geometry::nearest_material(const Vec3& origin, const Vec3& direction,
                                                     double limit) const {
  Search search;
  find(origin, direction, limit, search);
  if (search.owner == nullptr) return std::nullopt;
  if (search.owner == balls_.get()) return balls_->spheres[search.face].material;
  if (search.owner == rounds_.get()) {
    return rounds_->with(search.face, [](const auto& face) { return face.material; });
  }
  return static_cast<const Mesh*>(search.owner)->faces[search.face].material;
}

void Geometry::find(const Vec3& origin, const Vec3& direction, double limit, Search& search) const {
  rtcInitIntersectContext(&search.embree);
  search.origin = origin;
  search.direction = direction;
  search.nearest = std::min(limit, far_away);
  search.extent = extent_;
  const Vec3 start = origin - head_start() * direction;
  RTCRayHit rayhit;
  rayhit.ray.org_x = static_cast<float>(start.x);
  rayhit.ray.org_y = static_cast<float>(start.y);
  rayhit.ray.org_z = static_cast<float>(start.z);
  rayhit.ray.dir_x = static_cast<float>(direction.x);
  rayhit.ray.dir_y = static_cast<float>(direction.y);
  rayhit.ray.dir_z = static_cast<float>(direction.z);
  rayhit.ray.tnear = 0.0F;
  rayhit.ray.tfar =
      limit < far_away ? search.embree_distance(limit) : std::numeric_limits<float>::infinity();
  rayhit.ray.time = 0.0F;
  rayhit.ray.mask = ~0U;
  rayhit.ray.id = 0;
  rayhit.ray.flags = 0;
  rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rayhit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  if (record_ != nullptr) {
    const RTCRay& r = rayhit.ray;
    record_->push_back({{r.org_x, r.org_y, r.org_z}, {r.dir_x, r.dir_y, r.dir_z}, r.tfar});
  }
  rtcIntersect1(embree_, &search.embree, &rayhit);
}

std::optional<Hit> Geometry::nearest(const Vec3& origin, const Vec3& direction,
                                     double limit) const {
  Search search;
  find(origin, direction, limit, search);
  if (search.owner == nullptr) return std::nullopt;

  Hit hit;
  hit.distance = search.nearest;
  hit.position = origin + search.nearest * direction;
  if (search.owner == balls_.get()) {
    const Sphere& s = balls_->spheres[search.face];
    const Vec3 out = hit.position - s.centre;
    hit.normal = out / std::sqrt(dot(out, out));
    hit.position = s.centre + s.radius * hit.normal;
    hit.material = s.material;
  } else if (search.owner == rounds_.get()) {
    rounds_->with(search.face, [&](const auto& face) {
      hit.position = settled(face, hit.position);
      hit.normal = normal_at(face, hit.position);
      hit.material = face.material;
    });
  } else {
    const auto& mesh = *static_cast<const Mesh*>(search.owner);
    hit.normal = mesh.faces[search.face].normal;
    hit.position = mesh.inside(search.face, hit.position);
    hit.material = mesh.faces[search.face].material;
  }
  return hit;
}

}  // namespace umov::trace
