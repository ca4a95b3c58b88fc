#include "host/trace/round.hpp"

#include <algorithm>
#include <cmath>

namespace umov::trace {
namespace {

using Vec3 = optics::Vec3<double>;

// Of a face's size: faces that share an edge overlap by this much, and points lie inside by this
// much.
constexpr double margin = 1e-9;

}  // namespace

Box box_of(const Tube& t) {
  return {Vec3(t.x - t.radius, t.y - t.radius, t.bottom),
          Vec3(t.x + t.radius, t.y + t.radius, t.top)};
}

Box box_of(const Plate& p) {
  return {Vec3(p.x - p.radius, p.y - p.radius, p.z), Vec3(p.x + p.radius, p.y + p.radius, p.z)};
}

std::optional<double> meeting(const Tube& t, const Vec3& origin, const Vec3& direction,
                              double limit, double on_face) {
  const double across2 = direction.x * direction.x + direction.y * direction.y;
  if (!(across2 > 0.0)) return std::nullopt;
  const double ox = origin.x - t.x;
  const double oy = origin.y - t.y;
  const double b = ox * direction.x + oy * direction.y;
  const double power = ox * ox + oy * oy - t.radius * t.radius;
  double first = 0.0;
  double second = 0.0;
  if (std::abs(power) <= 2.0 * t.radius * on_face) {
    second = -2.0 * b / across2;  // the start is on the tube
  } else {
    // The distance of the ray's line from the axis, rather than b² - across2 · power, which loses
    // digits.
    const double moment = ox * direction.y - oy * direction.x;
    const double chord2 = across2 * t.radius * t.radius - moment * moment;
    if (chord2 < 0.0) return std::nullopt;
    const double half = std::sqrt(chord2);
    first = (-b - half) / across2;
    second = (-b + half) / across2;
  }
  const double reach = margin * (t.top - t.bottom);
  for (const double distance : {first, second}) {
    if (!(distance > 0.0) || distance > limit) continue;
    const double z = origin.z + distance * direction.z;
    if (z >= t.bottom - reach && z <= t.top + reach) return distance;
  }
  return std::nullopt;
}

std::optional<double> meeting(const Plate& p, const Vec3& origin, const Vec3& direction,
                              double limit, double on_face) {
  const double height = origin.z - p.z;
  if (std::abs(height) <= on_face) return std::nullopt;
  const double distance = -height / direction.z;
  if (!(distance > 0.0) || distance > limit) return std::nullopt;
  const double x = origin.x + distance * direction.x;
  const double y = origin.y + distance * direction.y;
  const auto within = [&](double cx, double cy, double radius) {
    return (x - cx) * (x - cx) + (y - cy) * (y - cy) <= radius * radius;
  };
  if (!within(p.x, p.y, p.radius * (1.0 + margin))) return std::nullopt;
  for (const Plate::Hole& hole : p.holes) {
    if (within(hole.x, hole.y, hole.radius * (1.0 - margin))) return std::nullopt;
  }
  return distance;
}

Vec3 normal_at(const Tube& t, const Vec3& position) {
  const double x = position.x - t.x;
  const double y = position.y - t.y;
  const double scale = (t.inward ? -1.0 : 1.0) / std::sqrt(x * x + y * y);
  return {x * scale, y * scale, 0.0};
}

Vec3 normal_at(const Plate& p, const Vec3&) {
  return {0.0, 0.0, p.upward ? 1.0 : -1.0};
}

Vec3 settled(const Tube& t, const Vec3& position) {
  const double x = position.x - t.x;
  const double y = position.y - t.y;
  const double scale = t.radius / std::sqrt(x * x + y * y);
  const double reach = margin * (t.top - t.bottom);
  return {t.x + x * scale, t.y + y * scale,
          std::clamp(position.z, t.bottom + reach, t.top - reach)};
}

Vec3 settled(const Plate& p, const Vec3& position) {
  Vec3 at(position.x, position.y, p.z);
  const auto move = [&](double cx, double cy, double radius, bool inside) {
    const double x = at.x - cx;
    const double y = at.y - cy;
    const double distance2 = x * x + y * y;
    if (inside ? distance2 <= radius * radius : distance2 >= radius * radius) return;
    const double scale = radius / std::sqrt(distance2);
    at.x = cx + x * scale;
    at.y = cy + y * scale;
  };
  move(p.x, p.y, p.radius * (1.0 - margin), true);
  for (const Plate::Hole& hole : p.holes) move(hole.x, hole.y, hole.radius * (1.0 + margin), false);
  return at;
}

}  // namespace umov::trace
