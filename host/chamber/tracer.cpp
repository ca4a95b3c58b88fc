#include "host/chamber/tracer.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "host/chamber/carried_light.hpp"
#include "host/errors/error.hpp"
#include "host/optics/frames.hpp"
#include "host/trace/random_stream.hpp"

namespace umov::chamber {

using optics::dot;
using trace::eight_uniforms;
using trace::uniforms;

namespace {

constexpr std::uint32_t endless_after = 100'000;
constexpr double forever = std::numeric_limits<double>::infinity();
// Roulette plays for what is below this share of what was launched.
constexpr double roulette_below = 0.1;
constexpr double mm2_per_m2 = 1e6;

/// Two axes across a unit normal (T. Duff et al., "Building an orthonormal basis, revisited", JCGT
/// 2017).
struct Frame {
  Vec3 x, y, z;
  explicit Frame(const Vec3& n) : z(n) {
    const double sign = std::copysign(1.0, n.z);
    const double a = -1.0 / (sign + n.z);
    const double b = n.x * n.y * a;
    x = Vec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    y = Vec3(b, sign + n.y * n.y * a, -n.y);
  }
  Vec3 local(const Vec3& v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  /// Of unit length but for rounding that a step of Newton's takes back.
  Vec3 world(const Vec3& v) const {
    const Vec3 w = v.x * x + v.y * y + v.z * z;
    return (1.5 - 0.5 * dot(w, w)) * w;
  }
};

double squared(double x) {
  return x * x;
}

/// Weight of a sample of density `own` where another way there has density `other` (Veach's power
/// heuristic).
double mis_weight(double own, double other) {
  return squared(own) / (squared(own) + squared(other));
}

}  // namespace

std::vector<double> Fate::numbers() const {
  std::vector<double> all{launched, out, absorbed, behind, lost, first_hit};
  for (const auto* part : {&incident, &taken, &spectrum_out})
    all.insert(all.end(), part->begin(), part->end());
  all.push_back(static_cast<double>(work.rays));
  all.push_back(static_cast<double>(work.endless));
  return all;
}

void Fate::add(std::span<const double> numbers) {
  auto next = numbers.begin();
  for (double* one : {&launched, &out, &absorbed, &behind, &lost, &first_hit}) *one += *next++;
  for (auto* part : {&incident, &taken, &spectrum_out})
    for (double& one : *part) one += *next++;
  work.rays += static_cast<std::uint64_t>(*next++);
  work.endless += static_cast<std::uint64_t>(*next++);
}

/// Where a path has met a face.
struct Tracer::Place {
  const Vec3& position;
  const Frame& frame;
  const Vec3& known;  ///< local direction to where the path came from
  const Surface& surface;
};

Tracer::Tracer(const Luminaire& luminaire)
    : luminaire_(luminaire), geometry_(luminaire.scene), choice_(luminaire.emitters) {
  for (const Emitter& emitter : luminaire.emitters) {
    const double area = emitter.area_mm2();
    sources_.push_back({area, mm2_per_m2 * emitter.flux_lm / area});
  }
  const std::size_t bands = luminaire.bands ? luminaire.bands->size() : 1;
  for (const auto& surface : luminaire.surfaces) {
    if (surface->bands() == 1 || surface->bands() == bands) continue;
    throw Error(fmt::format("surface {} has {} bands in a luminaire of {}", surface->name(),
                            surface->bands(), bands),
                "make it for the luminaire's wavelengths, or the same at all");
  }
  if (!luminaire.bands) return;
  for (const Emitter& emitter : luminaire.emitters) {
    if (emitter.spectrum.size() == bands) continue;
    throw Error(fmt::format("{} has a spectrum of {} bands in a luminaire of {}", emitter.name,
                            emitter.spectrum.size(), bands),
                "give it W/nm of a lumen at the luminaire's wavelengths");
  }
}

std::optional<trace::Hit> Tracer::nearest(const Vec3& origin, const Vec3& direction,
                                          double limit) const {
  auto hit = geometry_.nearest(origin, direction, limit);
  if (hit && luminaire_.inside_out[hit->material]) hit->normal = -hit->normal;
  return hit;
}

template <class Facing, class Light>
void Tracer::next_event(const Place& place, const Facing& facing, Estimator estimator, double u1,
                        double u2, double u3, Light& light, Work& work) const {
  const auto [chosen, choice] = choice_.choose(place.position, place.frame.z, u1);
  const Emitter& emitter = luminaire_.emitters[chosen];
  const Source& source = sources_[chosen];
  const Vec3 to = emitter.point(u2, u3) - place.position;
  const double distance2 = dot(to, to);
  if (!(distance2 > 0.0)) return;
  const double distance = std::sqrt(distance2);
  const Vec3 direction = to / distance;
  const double cosine = dot(direction, place.frame.z);
  const double cosine_there = -dot(direction, emitter.normal);
  if (!(cosine > 1e-9) || !(cosine_there > 1e-9)) return;
  const double shines = emitter.luminance(-direction, source.lm_per_m2);
  if (!(shines > 0.0)) return;
  const Vec3 from = place.frame.local(direction);
  if (!light.ask(place.surface, facing, place.known, from)) return;
  ++work.rays;
  const double reach = distance * (1.0 + 1e-6) + emitter.clearance_mm / cosine_there;
  const auto met = geometry_.nearest_material(place.position, direction, reach);
  if (!met || *met != emitter.material) return;
  const double density = choice * distance2 / (cosine_there * source.area_mm2);
  const double weight =
      estimator == Estimator::mis ? mis_weight(density, facing.density(from)) : 1.0;
  light.receive(emitter, weight * cosine * shines / density);
}

template <class Light>
void Tracer::see(const Vec3& origin, const Vec3& direction, Estimator estimator, std::uint64_t seed,
                 std::uint64_t path, Light& light, Work& work) const {
  Vec3 position = origin;
  Vec3 along = direction;
  Vec3 normal_before;
  double density_before = 0.0;  // of the direction; 0: no other way leads there
  const bool asks = estimator != Estimator::unidirectional && !luminaire_.emitters.empty();
  for (std::uint32_t meeting = 1; meeting <= endless_after; ++meeting) {
    ++work.rays;
    const auto hit = nearest(position, along, forever);
    if (!hit) return;
    const double cosine = -dot(along, hit->normal);
    if (!(cosine > 0.0)) return;
    const int number = luminaire_.emitter_of[hit->material];
    if (number >= 0) {
      const auto index = static_cast<std::size_t>(number);
      const Source& source = sources_[index];
      double weight = 1.0;
      if (density_before > 0.0 && estimator == Estimator::next_event) weight = 0.0;
      if (density_before > 0.0 && estimator == Estimator::mis) {
        const double other = choice_.probability(position, normal_before, index) *
                             squared(hit->distance) / (cosine * source.area_mm2);
        weight = mis_weight(density_before, other);
      }
      if (weight > 0.0) {
        const Emitter& emitter = luminaire_.emitters[index];
        light.meet(emitter, weight * emitter.luminance(-along, source.lm_per_m2));
      }
    }
    const Surface& surface = *luminaire_.surfaces[hit->material];
    if (surface.black()) return;
    const Frame frame(hit->normal);
    Vec3 known = frame.local(-along);
    known.z = cosine;
    const auto u = eight_uniforms(seed, path, meeting);
    const auto drawn = surface.facing(known, Sense::against_light, [&](const auto& facing) {
      if (asks) {
        const Place place{hit->position, frame, known, surface};
        next_event(place, facing, estimator, u[0], u[1], u[2], light, work);
      }
      return facing.draw(u[3], u[4], u[5]);
    });
    if (!drawn) return;
    light.scatter(surface, *drawn, known, Sense::against_light);
    const double strength = light.strength();
    if (!(strength > 0.0)) return;
    if (strength < roulette_below) {
      if (!(u[6] * roulette_below < strength)) return;
      light.scale(roulette_below / strength);
    }
    position = hit->position;
    normal_before = hit->normal;
    along = frame.world(drawn->direction);
    density_before = drawn->density;
  }
  ++work.endless;
}

double Tracer::luminance(const Vec3& origin, const Vec3& direction, Estimator estimator,
                         std::uint64_t seed, std::uint64_t path, Work& work) const {
  PlainLight light;
  see(origin, direction, estimator, seed, path, light, work);
  return light.seen();
}

void Tracer::radiance(const Vec3& origin, const Vec3& direction, Estimator estimator,
                      std::uint64_t seed, std::uint64_t path, std::span<double> bands,
                      Work& work) const {
  std::fill(bands.begin(), bands.end(), 0.0);
  BandedLight light(*luminaire_.bands, bands);
  see(origin, direction, estimator, seed, path, light, work);
}

Fate Tracer::empty_fate() const {
  Fate fate;
  fate.incident.assign(luminaire_.surfaces.size(), 0.0);
  fate.taken.assign(luminaire_.surfaces.size(), 0.0);
  fate.spectrum_out.assign(luminaire_.bands ? luminaire_.bands->size() : 0, 0.0);
  return fate;
}

template <class Light>
std::optional<Tracer::Exit> Tracer::follow(const Vec3& origin, const Vec3& direction,
                                           double launched_lm, std::uint64_t seed,
                                           std::uint64_t path, Light& light, Fate& fate) const {
  Vec3 position = origin;
  Vec3 along = direction;
  double flux = light.lumens();
  fate.launched += flux;
  for (std::uint32_t meeting = 1; meeting <= endless_after; ++meeting) {
    ++fate.work.rays;
    const auto hit = nearest(position, along, forever);
    if (!hit) {
      fate.out += flux;
      light.leave(fate.spectrum_out);
      return Exit{along, flux};
    }
    const double cosine = -dot(along, hit->normal);
    if (!(cosine > 0.0)) {
      fate.behind += flux;
      return std::nullopt;
    }
    const Surface& surface = *luminaire_.surfaces[hit->material];
    fate.incident[hit->material] += flux;
    if (meeting == 1 && !surface.black()) fate.first_hit += flux;
    const auto take = [&](double share) {
      fate.absorbed += share;
      fate.taken[hit->material] += share;
    };
    const Frame frame(hit->normal);
    Vec3 known = frame.local(-along);
    known.z = cosine;
    const auto u = uniforms(seed, path, meeting + 1);
    const auto drawn =
        surface.black() ? std::nullopt : surface.draw(known, Sense::with_light, u[0], u[1], u[2]);
    if (drawn) light.scatter(surface, *drawn, known, Sense::with_light);
    const double after = drawn ? light.lumens() : 0.0;
    take(flux - after);
    if (!(after > 0.0)) return std::nullopt;
    flux = after;
    if (flux < roulette_below * launched_lm) {
      // What is paid to survivors is taken from those that end here: right in the mean.
      if (!(u[3] * roulette_below * launched_lm < flux)) {
        take(flux);
        return std::nullopt;
      }
      take(flux - roulette_below * launched_lm);
      light.scale(roulette_below * launched_lm / flux);
      flux = roulette_below * launched_lm;
    }
    position = hit->position;
    along = frame.world(drawn->direction);
  }
  ++fate.work.endless;
  fate.lost += flux;
  return std::nullopt;
}

std::optional<Tracer::Exit> Tracer::launch(double flux_lm, const Stratum& stratum,
                                           std::uint64_t seed, std::uint64_t path,
                                           Fate& fate) const {
  const auto u = uniforms(seed, path, 0);
  const auto v = uniforms(seed, path, 1);
  const Emitter& emitter =
      luminaire_.emitters[choice_.by_flux(stratum.from + stratum.width * v[1])];
  const Vec3 position = emitter.point(u[0], u[1]) + emitter.clearance_mm * emitter.normal;
  const Emitter::Launch start = emitter.launch(u[2], u[3], v[0]);
  const auto follow_as = [&](auto light) {
    light.launch(emitter, flux_lm * start.weight);
    return follow(position, start.direction, flux_lm, seed, path, light, fate);
  };
  if (!luminaire_.bands) return follow_as(PlainLight());
  return follow_as(BandedLight(*luminaire_.bands, {}));
}

}  // namespace umov::chamber
