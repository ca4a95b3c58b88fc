#include "host/chamber/emitter.hpp"

#include <algorithm>
#include <cmath>

#include "host/optics/frames.hpp"

namespace umov::chamber {

using optics::dot;
using optics::pi;

namespace {

double length(const Vec3& v) {
  return std::sqrt(dot(v, v));
}

}  // namespace

double Emitter::area_mm2() const {
  const double product = length(half_u) * length(half_v);
  return disc ? pi * product : 4.0 * product;
}

Vec3 Emitter::point(double u1, double u2) const {
  if (!disc) return centre + (2.0 * u1 - 1.0) * half_u + (2.0 * u2 - 1.0) * half_v;
  const double r = std::sqrt(u1);
  const Turn phi = turn(u2);
  return centre + r * phi.cosine * half_u + r * phi.sine * half_v;
}

double Emitter::luminance(const Vec3& towards, double lm_per_m2) const {
  const double cosine = dot(towards, normal);
  if (!(cosine > 1e-9)) return 0.0;
  if (!table) return lm_per_m2 / pi;
  const Vec3 local(dot(towards, half_u) / length(half_u), dot(towards, half_v) / length(half_v),
                   cosine);
  return lm_per_m2 * table->intensity(local) / cosine;
}

Emitter::Launch Emitter::launch(double u1, double u2, double u3) const {
  Vec3 local;
  double weight = 1.0;
  if (table) {
    const IntensityTable::Launch drawn = table->launch(u1, u2, u3);
    local = drawn.direction;
    weight = drawn.weight;
  } else {
    local = cosine_draw(u1, u2);
  }
  const Vec3 direction =
      (local.x / length(half_u)) * half_u + (local.y / length(half_v)) * half_v + local.z * normal;
  return {direction / length(direction), weight};
}

}  // namespace umov::chamber
