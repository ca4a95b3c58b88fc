#include "host/brdf/sampling_lobes.hpp"

#include <algorithm>
#include <numbers>

#include "host/brdf/visible_slope.hpp"

namespace umov::brdf {
namespace {

using optics::pi;
using optics::Vec3;

constexpr double root_pi_inverse = std::numbers::inv_sqrtpi;

/// Unit vector at the polar angle with 1 - cosine `versine` and azimuth 2π `turn` about the mirror
/// direction.
Vec3<double> about_mirror(const Incidence& in, double versine, double turn) {
  const double cosine = 1.0 - versine;
  const double sine = std::sqrt(std::max(0.0, versine * (2.0 - versine)));
  const double along = sine * std::cos(2.0 * pi * turn);
  const double across = sine * std::sin(2.0 * pi * turn);
  // Mirror direction (sin θi, 0, cos θi), beside it (cos θi, 0, -sin θi) and y.
  return {in.sine * cosine + in.cosine * along, across, in.cosine * cosine - in.sine * along};
}

/// 4 sin²(α/2) of the angle α to the mirror direction.
double squared_chord(const Incidence& in, const Exit& exit) {
  const double x = exit.direction.x - in.sine;
  const double z = exit.direction.z - in.cosine;
  return x * x + exit.direction.y * exit.direction.y + z * z;
}

/// t with 1 - (1 + t) e^(-t) = u.
double gamma2_quantile(double u) {
  // Small t: u ≈ t²/2 - t³/3. Large t: 1 - u ≈ t e^(-t).
  const double rest = 1.0 - u;
  double t = u < 0.3 ? std::sqrt(2.0 * u) * (1.0 + std::sqrt(2.0 * u) / 3.0)
                     : -std::log(rest) + std::log1p(-std::log(rest));
  for (int i = 0; i < 20; ++i) {
    const double e = std::exp(-t);
    if (!(t > 0.0) || !(e > 0.0)) break;
    // -expm1(-t) - t e^(-t) keeps its digits for small t down to t² of 1e-16.
    const double f = -std::expm1(-t) - t * e - u;
    const double newton = f / (t * e);
    const double step = newton / (1.0 - 0.5 * newton * (1.0 / t - 1.0));
    t = std::max(t - step, 0.1 * t);
    if (std::abs(step) < 1e-12 * t) break;
  }
  return t;
}

double groove_density(GrooveLobe::Law law, double width, double tan2) {
  const double w2 = width * width;
  switch (law) {
    case GrooveLobe::Law::gaussian:
      return std::exp(-0.5 * tan2 / w2) / (2.0 * pi * w2);
    case GrooveLobe::Law::exponential:
      return 1.5 * std::exp(-std::numbers::sqrt3 * std::sqrt(tan2) / width) / (pi * w2);
    case GrooveLobe::Law::trowbridge_reitz:
      return w2 / (pi * (w2 + tan2) * (w2 + tan2));
  }
  return 0.0;
}

}  // namespace

Vec3<double> CosineLobe::draw(const Incidence&, double u1, double u2, double) const {
  const double radius = std::sqrt(u1);
  return {radius * std::cos(2.0 * pi * u2), radius * std::sin(2.0 * pi * u2), std::sqrt(1.0 - u1)};
}

double CosineLobe::pdf(const Incidence&, const Exit& exit) const {
  return exit.direction.z / pi;
}

Vec3<double> UniformLobe::draw(const Incidence&, double u1, double u2, double) const {
  const double z = 1.0 - u1;
  const double radius = std::sqrt(u1 * (1.0 + z));
  return {radius * std::cos(2.0 * pi * u2), radius * std::sin(2.0 * pi * u2), z};
}

double UniformLobe::pdf(const Incidence&, const Exit&) const {
  return 0.5 / pi;
}

Vec3<double> GaussianFacetLobe::draw(const Incidence& in, double u1, double u2, double) const {
  const double unit_x = std::numbers::sqrt2 * slope_x;
  const double unit_y = std::numbers::sqrt2 * slope_y;
  return mirrored(in, unit_x * visible_slope(u1, unit_x * in.sine / in.cosine),
                  unit_y * visible_slope(u2, 0.0));
}

double GaussianFacetLobe::pdf(const Incidence& in, const Exit& exit) const {
  const double unit_x = std::numbers::sqrt2 * slope_x;
  const double unit_y = std::numbers::sqrt2 * slope_y;
  const double x = exit.half_x / unit_x;
  const double y = exit.half_y / unit_y;
  // cos θi (1 + Λ) = cos θi N(c) + sin θi unit_x e^(-c²)/2√π with c = cot θi/unit_x.
  const double shade = unit_x * in.sine;
  const double c = shade * 27.0 > in.cosine ? in.cosine / shade : 27.0;
  const double seen =
      in.cosine * 0.5 * std::erfc(-c) + 0.5 * shade * root_pi_inverse * std::exp(-c * c);
  const double cos2_h = exit.cos_h * exit.cos_h;
  return std::exp(-x * x - y * y) / (pi * unit_x * unit_y * 4.0 * cos2_h * cos2_h * seen);
}

Vec3<double> GgxFacetLobe::draw(const Incidence& in, double u1, double u2, double) const {
  // Towards the light, stretched so that the normals fill a unit sphere.
  double x = -alpha * in.sine;
  double z = in.cosine;
  const double length = std::hypot(x, z);
  x /= length;
  z /= length;
  const double height = (1.0 - u2) * (1.0 + z) - z;
  const double radius = std::sqrt(std::clamp(1.0 - height * height, 0.0, 1.0));
  const double normal_x = radius * std::cos(2.0 * pi * u1) + x;
  const double normal_y = radius * std::sin(2.0 * pi * u1);
  const double normal_z = height + z;
  return mirrored(in, alpha * normal_x / normal_z, alpha * normal_y / normal_z);
}

double GgxFacetLobe::pdf(const Incidence& in, const Exit& exit) const {
  const double alpha2 = alpha * alpha;
  const double root =
      std::sqrt(in.cosine * in.cosine + alpha2 * in.sine * in.sine);  // cos θi (1 + 2Λ)
  const double q = exit.cos_h * exit.cos_h * (alpha2 + exit.tan2_h);
  return alpha2 / (2.0 * pi * q * q * (in.cosine + root));
}

Vec3<double> GrooveLobe::draw(const Incidence& in, double u1, double u2, double u3) const {
  double slope = 0.0;
  switch (law) {
    case Law::gaussian:
      slope = width * std::sqrt(-2.0 * std::log1p(-u1));
      break;
    case Law::exponential:
      slope = width / std::numbers::sqrt3 * gamma2_quantile(u1);
      break;
    case Law::trowbridge_reitz:
      slope = width * std::sqrt(u1 / (1.0 - u1));
      break;
  }
  double half_x = slope * std::cos(2.0 * pi * u2);
  double half_y = slope * std::sin(2.0 * pi * u2);
  const double near = std::max(0.0, in.cosine - in.sine * half_x);
  const double far = std::max(0.0, in.cosine + in.sine * half_x);
  if (u3 * (near + far) >= near) {
    half_x = -half_x;
    half_y = -half_y;
  }
  return mirrored(in, half_x, half_y);
}

double GrooveLobe::pdf(const Incidence& in, const Exit& exit) const {
  const double near = std::max(0.0, in.cosine - in.sine * exit.half_x);
  const double far = std::max(0.0, in.cosine + in.sine * exit.half_x);
  return groove_density(law, width, exit.tan2_h) * 2.0 * near /
         ((near + far) * exit.sr_per_slope_area());
}

Vec3<double> CosinePowerLobe::draw(const Incidence& in, double u1, double u2, double) const {
  return about_mirror(in, -std::expm1(std::log1p(-u1) / (exponent + 1.0)), u2);
}

double CosinePowerLobe::pdf(const Incidence& in, const Exit& exit) const {
  const double versine = 0.5 * squared_chord(in, exit);
  if (!(versine < 1.0)) return 0.0;
  return (exponent + 1.0) / (2.0 * pi) * std::exp(exponent * std::log1p(-versine));
}

Vec3<double> ChordLobe::draw(const Incidence& in, double u1, double u2, double) const {
  const double w2 = width * width;
  return about_mirror(in, std::min(2.0, -w2 * std::log1p(u1 * std::expm1(-2.0 / w2))), u2);
}

double ChordLobe::pdf(const Incidence& in, const Exit& exit) const {
  const double w2 = width * width;
  return std::exp(-0.5 * squared_chord(in, exit) / w2) / (-2.0 * pi * w2 * std::expm1(-2.0 / w2));
}

}  // namespace umov::brdf
