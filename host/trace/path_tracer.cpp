#include "host/trace/path_tracer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/brdf/facet.hpp"
#include "host/trace/random_stream.hpp"
#include "host/trace/specular.hpp"

namespace umov::trace {

using optics::Beam;
using optics::cross;
using optics::dot;
using optics::Mueller;

namespace {

constexpr std::uint32_t endless_after = 1'000'000;
// Roulette plays for what is below this share of the launched power.
constexpr double roulette_below = 0.1;

// The unit vector across k and the normal; the present s where they are parallel.
Vec3 across(const Beam<double>& beam, const Vec3& normal) {
  const Vec3 n = cross(beam.k, normal);
  const double length2 = dot(n, n);
  return length2 > 1e-24 ? n / std::sqrt(length2) : beam.s;
}

// A unit vector across the unit vector n.
Vec3 any_across(const Vec3& n) {
  const Vec3 v = std::abs(n.z) < 0.9 ? Vec3(-n.y, n.x, 0.0) : Vec3(0.0, -n.z, n.y);
  return v / std::sqrt(dot(v, v));
}

}  // namespace

Ledger::Ledger(std::size_t wavelengths)
    : launched(wavelengths),
      above(wavelengths),
      below(wavelengths),
      absorbed(wavelengths),
      lost(wavelengths) {}

void Ledger::add(const Ledger& other) {
  for (std::size_t i = 0; i < launched.size(); ++i) {
    launched[i] += other.launched[i];
    above[i] += other.above[i];
    below[i] += other.below[i];
    absorbed[i] += other.absorbed[i];
    lost[i] += other.lost[i];
  }
  rays += other.rays;
  behind_opaque += other.behind_opaque;
  in_wrong_medium += other.in_wrong_medium;
  endless += other.endless;
  creases += other.creases;
}

PathTracer::PathTracer(const Scene& scene, const Geometry& geometry)
    : scene_(scene), geometry_(geometry) {
  const std::size_t count = scene.wavelengths_um.size();
  for (const Medium& medium : scene.media) {
    for (std::size_t i = 0; i < count; ++i) {
      attenuation_.push_back(4.0 * optics::pi * medium.kappa[i] / scene.wavelengths_um[i]);
    }
  }
  for (const Medium& a : scene.media) {
    for (const Medium& b : scene.media) {
      bool splits = false;
      for (std::size_t i = 1; i < count; ++i) {
        splits = splits || std::abs(a.n[i] * b.n[0] - a.n[0] * b.n[i]) > 1e-12 * a.n[0] * b.n[0];
      }
      dispersive_.push_back(splits);
    }
  }
}

PathTracer::Workspace::Workspace(const PathTracer& tracer)
    : weight(tracer.scene().wavelengths_um.size()),
      reflection(tracer.scene().wavelengths_um.size()) {
  open.reserve(weight.size());
}

// One launch on one thread.
struct PathTracer::Run {
  using Path = Workspace::Path;

  const PathTracer& tracer;
  std::uint64_t seed, sample;
  Workspace& space;
  Collector& collector;
  Ledger& ledger;

  Mueller<double>& weight(std::size_t wavelength) const { return space.weight[wavelength]; }

  // What `owner` takes of the light of a wavelength: all that is in `before` and not in `after`.
  void keep(std::size_t owner, std::size_t wavelength, const Mueller<double>& before,
            const Mueller<double>& after) const {
    ledger.absorbed[wavelength] += before[0][0] - after[0][0];
    if (!collector.watches_absorption()) return;
    collector.absorb({owner,
                      wavelength,
                      {before[0][0] - after[0][0], before[1][0] - after[1][0],
                       before[2][0] - after[2][0], before[3][0] - after[3][0]}});
  }

  // The path's light is lost; never silently.
  void lose(const Path& path, std::uint64_t& reason) const {
    ++reason;
    for (std::size_t i = path.first; i < path.first + path.count; ++i) {
      ledger.lost[i] += weight(i)[0][0];
    }
  }

  void leave(const Path& path) const {
    // No body reaches up to where light leaves.
    if (path.medium != vacuum && path.beam.k.z > 0.0) return lose(path, ledger.in_wrong_medium);
    const Beam<double> out = optics::beam_along(path.beam.k);
    const optics::DoubleAngle<double> turn = optics::rotation_to(path.beam, out.s);
    for (std::size_t i = path.first; i < path.first + path.count; ++i) {
      rotate(weight(i), turn.cos2, turn.sin2);
      (path.beam.k.z > 0.0 ? ledger.above : ledger.below)[i] += weight(i)[0][0];
      collector.collect({path.beam.k, i, path.meetings, weight(i)});
    }
  }

  // The basis of the path becomes that with `s`; its matrices follow.
  void turn_to(Path& path, const Vec3& s) const {
    const optics::DoubleAngle<double> turn = optics::rotation_to(path.beam, s);
    for (std::size_t i = path.first; i < path.first + path.count; ++i) {
      rotate(weight(i), turn.cos2, turn.sin2);
    }
    path.beam.s = s;
    path.beam.p = cross(path.beam.k, s);
  }

  void head(Path& path, const Vec3& s, const Vec3& k) const { path.beam = {s, cross(k, s), k}; }

  // A path may start just behind a face where two of them meet, for single precision chooses
  // between neighbours. It then leaves through that face as if it were not there.
  bool at_crease(const Path& path, const Hit& hit) const {
    const double cosine = dot(path.beam.k, hit.normal);
    return cosine > 0.0 && hit.distance * cosine <= 0.1 * tracer.geometry_.head_start() &&
           !std::holds_alternative<Interface>(tracer.scene_.materials[hit.material]);
  }

  // To the next face, over as many periods as it takes. Nothing: the path has ended.
  std::optional<Hit> advance(Path& path) const {
    const Scene& scene = tracer.scene_;
    if (!scene.periodic) {
      ++ledger.rays;
      auto hit = tracer.geometry_.nearest(path.origin, path.beam.k,
                                          std::numeric_limits<double>::infinity());
      if (hit) {
        fade(path, hit->distance);
        path.origin = hit->position;
      } else {
        leave(path);
      }
      return hit;
    }
    const Vec3& k = path.beam.k;
    for (;; ++path.periods) {  // crossings of creases count as periods too
      if (path.periods > endless_after) {
        lose(path, ledger.endless);
        return std::nullopt;
      }
      constexpr double never = std::numeric_limits<double>::infinity();
      const auto wall = [](double x, double slope, double size) {
        if (slope > 0.0) return std::max(0.0, (size - x) / slope);
        return slope < 0.0 ? std::max(0.0, -x / slope) : never;
      };
      const double wall_x = wall(path.origin.x, k.x, scene.size_x);
      const double wall_y = wall(path.origin.y, k.y, scene.size_y);
      const double edge = std::min(wall_x, wall_y);
      ++ledger.rays;
      auto hit = tracer.geometry_.nearest(path.origin, k, edge);
      if (hit && at_crease(path, *hit)) {
        ++ledger.creases;
        path.origin += hit->distance * k;
        continue;
      }
      if (hit) {
        fade(path, hit->distance);
        path.origin = hit->position;
        return hit;
      }
      // Above the highest face on the way up, below the lowest on the way down: out.
      const double z = path.origin.z + (edge < never ? edge * k.z : 0.0);
      if (edge == never || (k.z > 0.0 && z > tracer.geometry_.top()) ||
          (k.z < 0.0 && z < tracer.geometry_.bottom())) {
        leave(path);
        return std::nullopt;
      }
      fade(path, edge);
      path.origin += edge * k;
      if (wall_x <= wall_y) path.origin.x = k.x > 0.0 ? 0.0 : scene.size_x;
      if (wall_y <= wall_x) path.origin.y = k.y > 0.0 ? 0.0 : scene.size_y;
    }
  }

  void fade(const Path& path, double length) const {
    const double* rate = &tracer.attenuation_[path.medium * space.weight.size()];
    for (std::size_t i = path.first; i < path.first + path.count; ++i) {
      if (rate[i] == 0.0) continue;
      const Mueller<double> before = weight(i);
      weight(i) *= std::exp(-rate[i] * length);
      keep(tracer.scene_.materials.size() + path.medium, i, before, weight(i));
    }
  }

  // Everything but m00 … m03 goes; what leaves is unpolarised whatever comes in.
  bool meet(const Lambertian& material, Path& path, const Hit& hit,
            const std::array<double, 4>& u) const {
    if (dot(path.beam.k, hit.normal) >= 0.0) return behind(path);
    for (std::size_t i = path.first; i < path.first + path.count; ++i) {
      Mueller<double>& m = weight(i);
      const Mueller<double> before = m;
      const double albedo = material.albedo[i];
      for (int c = 0; c < 4; ++c) m[c] = optics::Stokes<double>(albedo * m[c][0], 0.0, 0.0, 0.0);
      keep(hit.material, i, before, m);
    }
    const Vec3 x = any_across(hit.normal);
    const Vec3 y = cross(hit.normal, x);
    const double sine = std::sqrt(u[0]);
    const double phi = 2.0 * optics::pi * u[1];
    const double cosine = std::sqrt(1.0 - u[0]);
    const Vec3 k = sine * std::cos(phi) * x + sine * std::sin(phi) * y + cosine * hit.normal;
    const Vec3 s = -std::sin(phi) * x + std::cos(phi) * y;
    head(path, s, k);
    return true;
  }

  bool meet(const Conductor& material, Path& path, const Hit& hit,
            const std::array<double, 4>&) const {
    const double cosine = -dot(path.beam.k, hit.normal);
    if (cosine <= 0.0) return behind(path);
    turn_to(path, across(path.beam, hit.normal));
    const Medium& medium = tracer.scene_.media[path.medium];
    for (std::size_t i = path.first; i < path.first + path.count; ++i) {
      const RelativeIndex index =
          relative_index(medium.n[i], medium.kappa[i], material.n[i], material.kappa[i]);
      const Mueller<double> before = weight(i);
      weight(i) = specular_product(
          optics::fresnel_reflection(index.n, index.kappa, std::min(1.0, cosine)), 1.0, before);
      keep(hit.material, i, before, weight(i));
    }
    reflect(path, hit.normal, cosine);
    return true;
  }

  void reflect(Path& path, const Vec3& normal, double cosine) const {
    const Vec3 k = path.beam.k + (2.0 * cosine) * normal;
    head(path, path.beam.s, k / std::sqrt(dot(k, k)));
  }

  bool behind(const Path& path) const {
    lose(path, ledger.behind_opaque);
    return false;
  }

  static MediumId uppermost(const Path& path) {
    MediumId medium = most_media - 1;
    while (medium > vacuum && path.inside[medium] == 0) --medium;
    return medium;
  }

  // Reflection or transmission, in proportion to their powers for unpolarised launched light: that
  // of one wavelength then keeps its m00 exactly, and no element of its matrix can exceed it.
  bool meet(const Interface& face, Path& path, const Hit& hit,
            const std::array<double, 4>& u) const {
    const bool from_front = dot(path.beam.k, hit.normal) < 0.0;
    std::uint16_t& bodies = path.inside[face.inside];
    if (!from_front && bodies == 0) {
      lose(path, ledger.in_wrong_medium);
      return false;
    }
    const std::uint16_t bodies_here = bodies;
    bodies = static_cast<std::uint16_t>(from_front ? bodies + 1 : bodies - 1);
    const MediumId here = path.medium;
    const MediumId there = uppermost(path);
    if (here == there) return true;  // covered by another body
    const Vec3 normal = from_front ? hit.normal : -hit.normal;
    const double cosine = std::min(1.0, -dot(path.beam.k, normal));
    turn_to(path, across(path.beam, normal));
    const Medium& a = tracer.scene_.media[here];
    const Medium& b = tracer.scene_.media[there];
    double reflected = 0.0;
    double total = 0.0;
    for (std::size_t i = path.first; i < path.first + path.count; ++i) {
      const RelativeIndex index = relative_index(a.n[i], a.kappa[i], b.n[i], b.kappa[i]);
      space.reflection[i] = optics::fresnel_reflection(index.n, index.kappa, cosine);
      reflected += specular_intensity(space.reflection[i], weight(i));
      total += weight(i)[0][0];
    }
    const double share = std::clamp(reflected / total, 0.0, 1.0);
    if (u[0] < share) {
      for (std::size_t i = path.first; i < path.first + path.count; ++i) {
        weight(i) = specular_product(space.reflection[i], 1.0 / share, weight(i));
      }
      bodies = bodies_here;
      reflect(path, normal, cosine);
      return true;
    }
    for (std::size_t i = path.first; i < path.first + path.count; ++i) {
      weight(i) =
          specular_product(transmission(space.reflection[i]), 1.0 / (1.0 - share), weight(i));
      // Where reflection is total but for absorption, nothing travels on the other side.
      const double ratio = a.n[i] / b.n[i];
      if (ratio * ratio * (1.0 - cosine * cosine) >= 1.0) {
        keep(tracer.scene_.materials.size() + there, i, weight(i), Mueller<double>(0.0));
        weight(i) = Mueller<double>(0.0);
      }
    }
    path.medium = there;
    const Beam<double> arriving = path.beam;
    const auto send = [&](Path& part, std::size_t i) {
      head(part, arriving.s, refracted(arriving.k, normal, cosine, a.n[i] / b.n[i]));
    };
    if (path.count > 1 && tracer.dispersive_[here * tracer.scene_.media.size() + there] != 0) {
      for (std::size_t i = path.first; i < path.first + path.count; ++i) {
        if (!(weight(i)[0][0] > 0.0)) continue;
        Path part = path;
        part.first = i;
        part.count = 1;
        send(part, i);
        space.open.push_back(part);
      }
      return false;
    }
    send(path, path.first);
    return weight(path.first)[0][0] > 0.0;
  }

  bool meet(const Modelled& material, Path& path, const Hit& hit,
            const std::array<double, 4>& u) const {
    const double cosine = -dot(path.beam.k, hit.normal);
    if (cosine <= 0.0) return behind(path);
    const Vec3 tangent = path.beam.k + cosine * hit.normal;
    const double sine = std::sqrt(dot(tangent, tangent));
    const Vec3 x = sine > 1e-12 ? tangent / sine : any_across(hit.normal);
    const Vec3 y = cross(hit.normal, x);
    turn_to(path, y - dot(y, path.beam.k) * path.beam.k);
    // 90° itself is no incidence of a model.
    const double theta = std::min(std::atan2(sine, cosine), 0.5 * optics::pi * (1.0 - 1e-12));
    const brdf::Sampler& sampler = material.in(path.medium);
    const auto drawn = sampler.sample(theta, u[0], u[1], u[2], path.first);
    for (std::size_t i = path.first; i < path.first + path.count; ++i) {
      const Mueller<double> before = weight(i);
      if (!drawn) {
        keep(hit.material, i, before, Mueller<double>(0.0));
        continue;
      }
      weight(i) =
          optics::product(i == path.first ? drawn->weight : sampler.weight(*drawn, i), before);
      keep(hit.material, i, before, weight(i));
    }
    if (!drawn) return false;
    const double phi = drawn->geometry.phi_r;
    const Vec3& d = drawn->direction;
    const Vec3 k = d.x * x + d.y * y + d.z * hit.normal;
    head(path, -std::sin(phi) * x + std::cos(phi) * y, k / std::sqrt(dot(k, k)));
    return true;
  }

  // Whether the path goes on.
  bool survives(const Path& path, double u) const {
    double largest = 0.0;
    for (std::size_t i = path.first; i < path.first + path.count; ++i) {
      largest = std::max(largest, weight(i)[0][0]);
    }
    if (largest >= roulette_below) return true;
    const double chance = largest / roulette_below;
    if (!(u < chance)) return false;
    for (std::size_t i = path.first; i < path.first + path.count; ++i) weight(i) *= 1.0 / chance;
    return true;
  }

  void follow(Path path) const {
    for (;;) {
      const std::optional<Hit> hit = advance(path);
      if (!hit) return;
      ++path.meetings;
      if (path.meetings > endless_after) {
        lose(path, ledger.endless);
        return;
      }
      const std::array<double, 4> u = uniforms(seed, sample, path.meetings);
      const bool goes_on =
          std::visit([&](const auto& material) { return meet(material, path, *hit, u); },
                     tracer.scene_.materials[hit->material]);
      if (!goes_on || !survives(path, u[3])) return;
    }
  }
};

void PathTracer::trace(const Vec3& origin, const Beam<double>& beam, std::uint64_t seed,
                       std::uint64_t sample, Workspace& workspace, Collector& collector,
                       Ledger& ledger) const {
  const std::size_t count = scene_.wavelengths_um.size();
  for (std::size_t i = 0; i < count; ++i) {
    workspace.weight[i] = optics::identity_mueller<double>();
    ledger.launched[i] += 1.0;
  }
  const Run run{*this, seed, sample, workspace, collector, ledger};
  workspace.open.clear();
  run.follow({origin, beam, vacuum, {}, 0, count, 0, 0});
  // What the trunk has split into; these split no further.
  while (!workspace.open.empty()) {
    const Workspace::Path part = workspace.open.back();
    workspace.open.pop_back();
    run.follow(part);
  }
}

}  // namespace umov::trace
