#include "host/chamber/tracer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/errors/error.hpp"
#include "host/optics/frames.hpp"
#include "host/trace/random_stream.hpp"

namespace umov::chamber {

using optics::dot;
using trace::uniforms;

namespace {

constexpr std::uint32_t endless_after = 100'000;
constexpr double forever = std::numeric_limits<double>::infinity();
// Roulette plays for what is below this share of what was launched.
constexpr double roulette_below = 0.1;
// With more sources than this they are chosen by flux alone.
constexpr std::size_t most_weighed = 16;

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
  Vec3 world(const Vec3& v) const {
    const Vec3 w = v.x * x + v.y * y + v.z * z;
    return w / std::sqrt(dot(w, w));
  }
};

double squared(double x) {
  return x * x;
}

/// Roughly in proportion to the irradiance that a source causes, if nothing is in between; never
/// so low that a wrong guess costs much.
double closeness(const Vec3& position, const Vec3& normal, const Emitter& emitter) {
  constexpr double least = 0.1;
  const Vec3 to = emitter.centre - position;
  const double distance2 = std::max(1e-12, dot(to, to));
  const double distance = std::sqrt(distance2);
  const double here = std::max(least, dot(to, normal) / distance);
  const double there = std::max(least, -dot(to, emitter.normal) / distance);
  return emitter.flux_lm * here * there / distance2;
}

}  // namespace

/// Where a path has met a face.
struct Tracer::Place {
  const Vec3& position;
  const Frame& frame;
  const Vec3& known;  ///< local direction to where the path came from
  const Surface& surface;
};

Tracer::Tracer(const Luminaire& luminaire) : luminaire_(luminaire), geometry_(luminaire.scene) {
  const double flux = luminaire.flux_lm();
  double sum = 0.0;
  for (const Emitter& emitter : luminaire.emitters) {
    sum += emitter.flux_lm;
    flux_up_to_.push_back(flux > 0.0 ? sum / flux : 1.0);
    area_mm2_.push_back(emitter.area_mm2());
  }
}

std::optional<trace::Hit> Tracer::nearest(const Vec3& origin, const Vec3& direction,
                                          double limit) const {
  auto hit = geometry_.nearest(origin, direction, limit);
  if (hit && luminaire_.inside_out[hit->material]) hit->normal = -hit->normal;
  return hit;
}

std::size_t Tracer::emitter_at(double share) const {
  const auto found = std::upper_bound(flux_up_to_.begin(), flux_up_to_.end(), share);
  return std::min(static_cast<std::size_t>(found - flux_up_to_.begin()), flux_up_to_.size() - 1);
}

double Tracer::choice_of(const Vec3& position, const Vec3& normal, std::size_t emitter) const {
  const auto& all = luminaire_.emitters;
  if (all.size() == 1) return 1.0;
  if (all.size() > most_weighed) {
    return flux_up_to_[emitter] - (emitter == 0 ? 0.0 : flux_up_to_[emitter - 1]);
  }
  double sum = 0.0;
  double own = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double weight = closeness(position, normal, all[i]);
    sum += weight;
    if (i == emitter) own = weight;
  }
  return own / sum;
}

double Tracer::next_event(const Place& place, Estimator estimator, const std::array<double, 4>& u,
                          Work& work) const {
  const auto& all = luminaire_.emitters;
  std::size_t chosen = 0;
  double choice = 1.0;
  if (all.size() > most_weighed) {
    chosen = emitter_at(u[0]);
    choice = choice_of(place.position, place.frame.z, chosen);
  } else if (all.size() > 1) {
    std::array<double, most_weighed> weight{};
    double sum = 0.0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      weight[i] = closeness(place.position, place.frame.z, all[i]);
      sum += weight[i];
    }
    double rest = u[0] * sum;
    while (chosen + 1 < all.size() && rest >= weight[chosen]) rest -= weight[chosen++];
    choice = weight[chosen] / sum;
  }
  const Emitter& emitter = all[chosen];
  const Vec3 to = emitter.point(u[1], u[2]) - place.position;
  const double distance2 = dot(to, to);
  if (!(distance2 > 0.0)) return 0.0;
  const double distance = std::sqrt(distance2);
  const Vec3 direction = to / distance;
  const double cosine = dot(direction, place.frame.z);
  const double cosine_there = -dot(direction, emitter.normal);
  if (!(cosine > 1e-9) || !(cosine_there > 1e-9)) return 0.0;
  const Vec3 from = place.frame.local(direction);
  const double f = place.surface.value(from, place.known);
  const double shines = emitter.luminance(-direction);
  if (!(f * shines > 0.0)) return 0.0;
  ++work.rays;
  const double reach = distance * (1.0 + 1e-6) + emitter.clearance_mm / cosine_there;
  const auto hit = nearest(place.position, direction, reach);
  if (!hit || hit->material != emitter.material) return 0.0;
  const double density = choice * distance2 / (cosine_there * area_mm2_[chosen]);
  double weight = 1.0;
  if (estimator == Estimator::mis) {
    weight =
        squared(density) / (squared(density) + squared(place.surface.density(place.known, from)));
  }
  return weight * f * cosine * shines / density;
}

double Tracer::luminance(const Vec3& origin, const Vec3& direction, Estimator estimator,
                         std::uint64_t seed, std::uint64_t path, Work& work) const {
  Vec3 position = origin;
  Vec3 along = direction;
  Vec3 normal_before;
  double density_before = 0.0;  // of the direction; 0: no other way leads there
  double throughput = 1.0;
  double seen = 0.0;
  for (std::uint32_t meeting = 1; meeting <= endless_after; ++meeting) {
    ++work.rays;
    const auto hit = nearest(position, along, forever);
    if (!hit) return seen;
    const double cosine = -dot(along, hit->normal);
    if (!(cosine > 0.0)) return seen;
    const int number = luminaire_.emitter_of[hit->material];
    if (number >= 0) {
      const auto index = static_cast<std::size_t>(number);
      double weight = 1.0;
      if (density_before > 0.0 && estimator == Estimator::next_event) weight = 0.0;
      if (density_before > 0.0 && estimator == Estimator::mis) {
        const double other = choice_of(position, normal_before, index) * squared(hit->distance) /
                             (cosine * area_mm2_[index]);
        weight = squared(density_before) / (squared(density_before) + squared(other));
      }
      if (weight > 0.0) {
        seen += throughput * weight * luminaire_.emitters[index].luminance(-along);
      }
    }
    const Surface& surface = *luminaire_.surfaces[hit->material];
    if (surface.black()) return seen;
    const Frame frame(hit->normal);
    Vec3 known = frame.local(-along);
    known.z = cosine;
    if (estimator != Estimator::unidirectional && !luminaire_.emitters.empty()) {
      const auto u = uniforms(seed, path, 2 * meeting);
      seen += throughput * next_event({hit->position, frame, known, surface}, estimator, u, work);
    }
    const auto u = uniforms(seed, path, 2 * meeting + 1);
    const auto drawn = surface.draw(known, Sense::against_light, u[0], u[1], u[2]);
    if (!drawn || !(drawn->weight > 0.0)) return seen;
    throughput *= drawn->weight;
    if (throughput < roulette_below) {
      if (!(u[3] * roulette_below < throughput)) return seen;
      throughput = roulette_below;
    }
    position = hit->position;
    normal_before = hit->normal;
    along = frame.world(drawn->direction);
    density_before = drawn->density;
  }
  ++work.endless;
  return seen;
}

Fate Tracer::empty_fate() const {
  Fate fate;
  fate.incident.assign(luminaire_.surfaces.size(), 0.0);
  fate.taken.assign(luminaire_.surfaces.size(), 0.0);
  return fate;
}

std::optional<Tracer::Exit> Tracer::launch(double flux_lm, const Stratum& stratum,
                                           std::uint64_t seed, std::uint64_t path,
                                           Fate& fate) const {
  const auto u = uniforms(seed, path, 0);
  const auto v = uniforms(seed, path, 1);
  const Emitter& emitter = luminaire_.emitters[emitter_at(stratum.from + stratum.width * v[1])];
  Vec3 position = emitter.point(u[0], u[1]) + emitter.clearance_mm * emitter.normal;
  const Emitter::Launch start = emitter.launch(u[2], u[3], v[0]);
  Vec3 along = start.direction;
  double flux = flux_lm * start.weight;
  fate.launched += flux;
  for (std::uint32_t meeting = 1; meeting <= endless_after; ++meeting) {
    ++fate.work.rays;
    const auto hit = nearest(position, along, forever);
    if (!hit) {
      fate.out += flux;
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
    const auto w = uniforms(seed, path, 2 * meeting + 1);
    const auto drawn =
        surface.black() ? std::nullopt : surface.draw(known, Sense::with_light, w[0], w[1], w[2]);
    if (!drawn || !(drawn->weight > 0.0)) {
      take(flux);
      return std::nullopt;
    }
    const double after = flux * drawn->weight;
    take(flux - after);
    flux = after;
    if (flux < roulette_below * flux_lm) {
      // What is paid to survivors is taken from those that end here: right in the mean.
      if (!(w[3] * roulette_below * flux_lm < flux)) {
        take(flux);
        return std::nullopt;
      }
      take(flux - roulette_below * flux_lm);
      flux = roulette_below * flux_lm;
    }
    position = hit->position;
    along = frame.world(drawn->direction);
  }
  ++fate.work.endless;
  fate.lost += flux;
  return std::nullopt;
}

}  // namespace umov::chamber
