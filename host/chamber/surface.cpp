#include "host/chamber/surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/brdf/evaluate.hpp"
#include "host/chamber/fast_angle.hpp"
#include "host/errors/error.hpp"
#include "host/optics/frames.hpp"

namespace umov::chamber {
namespace {

using optics::pi;

// 90° itself is no incidence of a model.
constexpr double least_cosine = 1e-9;

Vec3 cosine_draw(double u1, double u2) {
  const double sine = std::sqrt(u1);
  const double phi = 2.0 * pi * u2;
  return {sine * std::cos(phi), sine * std::sin(phi), std::sqrt(1.0 - u1)};
}

Vec3 mirrored(const Vec3& v) {
  return {-v.x, -v.y, v.z};
}

/// The library's angles for light from `from` to `to`.
brdf::Geometry<double> geometry_of(const Vec3& from, const Vec3& to) {
  const double x = -(from.x * to.x + from.y * to.y);
  const double y = from.y * to.x - from.x * to.y;
  const double sine = std::hypot(from.x, from.y);
  const double phi = sine > 1e-12 ? std::atan2(y, x) : std::atan2(to.y, to.x);
  return {std::acos(std::min(1.0, from.z)), std::acos(std::min(1.0, to.z)), phi};
}

double model_value(const Modelled& m, const Vec3& from, const Vec3& to) {
  const brdf::SpectralValues& s = m.sampler.spectrum().front();
  return brdf::evaluate<double>(m.sampler.model(), s.values, s.wavelength_um,
                                geometry_of(from, to))[0][0];
}

std::optional<Drawn> draw_model(const Modelled& m, const Vec3& known, Sense sense, double u1,
                                double u2, double u3) {
  const auto sample =
      m.sampler.sample(std::acos(std::clamp(known.z, least_cosine, 1.0)), u1, u2, u3);
  if (!sample) return std::nullopt;
  if (sample->mirror) return Drawn{mirrored(known), sample->weight[0][0], 0.0};
  const double sine = std::hypot(known.x, known.y);
  const double ex = sine > 1e-12 ? -known.x / sine : 1.0;
  const double ey = sine > 1e-12 ? -known.y / sine : 0.0;
  const Vec3& d = sample->direction;
  const Vec3 to(d.x * ex - d.y * ey, d.x * ey + d.y * ex, d.z);
  const double weight = sense == Sense::with_light
                            ? sample->weight[0][0]
                            : model_value(m, to, known) * to.z / sample->density;
  return Drawn{to, weight, sample->density};
}

[[noreturn]] void refuse(const std::string& name, const std::string& problem,
                         const std::string& remedy) {
  throw Error(Place{name}, problem, remedy);
}

void check_share(const std::string& name, const char* what, double value) {
  if (value >= 0.0 && value <= 1.0) return;
  refuse(name, fmt::format("{} = {:g}", what, value), "a surface reflects between 0 and 1");
}

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};

}  // namespace

double DiffuseSpecular::specular_at(double cosine) const {
  const double theta = angle_deg(cosine);
  const auto above = std::upper_bound(theta_i_deg.begin(), theta_i_deg.end(), theta);
  if (above == theta_i_deg.begin()) return specular.front();
  if (above == theta_i_deg.end()) return specular.back();
  const auto i = static_cast<std::size_t>(above - theta_i_deg.begin());
  const double weight = (theta - theta_i_deg[i - 1]) / (theta_i_deg[i] - theta_i_deg[i - 1]);
  return specular[i - 1] + weight * (specular[i] - specular[i - 1]);
}

Surface::Surface(std::string name, Kind kind) : name_(std::move(name)), kind_(std::move(kind)) {
  if (const auto* plain = std::get_if<Lambertian>(&kind_)) {
    check_share(name_, "rho", plain->rho);
    return;
  }
  if (const auto* two = std::get_if<DiffuseSpecular>(&kind_)) {
    check_share(name_, "total", two->total);
    if (two->theta_i_deg.empty() || two->theta_i_deg.size() != two->specular.size()) {
      refuse(name_,
             fmt::format("{} incidences for {} specular reflectances", two->theta_i_deg.size(),
                         two->specular.size()),
             "give as many of one as of the other, one at least");
    }
    for (std::size_t i = 0; i < two->specular.size(); ++i) {
      const double theta = two->theta_i_deg[i];
      if (!(theta >= 0.0 && theta < 90.0) || (i > 0 && theta <= two->theta_i_deg[i - 1])) {
        refuse(name_, fmt::format("the incidence {:g}° does not rise or is not below 90°", theta),
               "list incidences in rising order");
      }
      if (!(two->specular[i] >= 0.0 && two->specular[i] <= two->total)) {
        refuse(name_, fmt::format("specular reflectance {:g} at {:g}°", two->specular[i], theta),
               fmt::format("it is a part of the total {:g}", two->total));
      }
    }
    return;
  }
  for (int theta = 1; theta <= 89; theta += 4) {
    const double r = reflectance(theta);
    if (r > 1.001) {
      refuse(name_, fmt::format("reflects {:.3f} of the light that comes in at {}°", r, theta),
             "scale its values down; where it is interpolated, add a row near that incidence");
    }
  }
}

double Surface::value(const Vec3& from, const Vec3& to) const {
  return std::visit(
      Overloaded{[](const Lambertian& s) { return s.rho / pi; },
                 [&](const DiffuseSpecular& s) { return (s.total - s.specular_at(from.z)) / pi; },
                 [&](const PlanesSurface& s) { return s.value(from, to); },
                 [&](const Modelled& s) { return model_value(s, from, to); }},
      kind_);
}

std::optional<Drawn> Surface::draw(const Vec3& known, Sense sense, double u1, double u2,
                                   double u3) const {
  return std::visit(
      Overloaded{[&](const Lambertian& s) -> std::optional<Drawn> {
                   if (s.rho == 0.0) return std::nullopt;
                   const Vec3 to = cosine_draw(u1, u2);
                   return Drawn{to, s.rho, to.z / pi};
                 },
                 [&](const DiffuseSpecular& s) -> std::optional<Drawn> {
                   if (s.total == 0.0) return std::nullopt;
                   const double specular = s.specular_at(known.z);
                   const double mirror = specular / s.total;
                   if (u3 < mirror) return Drawn{mirrored(known), s.total, 0.0};
                   const Vec3 to = cosine_draw(u1, u2);
                   const double diffuse = sense == Sense::with_light
                                              ? s.total - specular
                                              : s.total - s.specular_at(to.z);
                   return Drawn{to, diffuse / (1.0 - mirror), (1.0 - mirror) * to.z / pi};
                 },
                 [&](const PlanesSurface& s) -> std::optional<Drawn> {
                   const Vec3 to = s.draw(known, u1, u2, u3);
                   if (!(to.z > least_cosine)) return std::nullopt;
                   const double density = s.density(known, to);
                   const double f =
                       sense == Sense::with_light ? s.value(known, to) : s.value(to, known);
                   return Drawn{to, f * to.z / density, density};
                 },
                 [&](const Modelled& s) { return draw_model(s, known, sense, u1, u2, u3); }},
      kind_);
}

double Surface::density(const Vec3& known, const Vec3& drawn) const {
  return std::visit(
      Overloaded{[&](const Lambertian& s) { return s.rho > 0.0 ? drawn.z / pi : 0.0; },
                 [&](const DiffuseSpecular& s) {
                   return s.total > 0.0 ? (1.0 - s.specular_at(known.z) / s.total) * drawn.z / pi
                                        : 0.0;
                 },
                 [&](const PlanesSurface& s) { return s.density(known, drawn); },
                 [&](const Modelled& s) { return s.sampler.pdf(geometry_of(known, drawn)); }},
      kind_);
}

double Surface::reflectance(double theta_i_deg) const {
  const double cosine = std::max(least_cosine, std::cos(optics::radians(theta_i_deg)));
  if (const auto* s = std::get_if<Lambertian>(&kind_)) return s->rho;
  if (const auto* s = std::get_if<DiffuseSpecular>(&kind_)) return s->total;
  // The mean of weights over a lattice of draws: their scatter is small, for they follow the lobe.
  const Vec3 known(-std::sqrt(1.0 - cosine * cosine), 0.0, cosine);
  constexpr int count = 12'000;
  constexpr double golden = 0.6180339887498949;
  constexpr double plastic = 0.7548776662466927;
  double sum = 0.0;
  for (int i = 0; i < count; ++i) {
    const double u2 = std::fmod(golden * i, 1.0);
    const double u3 = std::fmod(plastic * i, 1.0);
    const auto drawn = draw(known, Sense::with_light, (i + 0.5) / count, u2, u3);
    if (drawn) sum += drawn->weight;
  }
  return sum / count;
}

bool Surface::black() const {
  const auto* s = std::get_if<Lambertian>(&kind_);
  return s != nullptr && s->rho == 0.0;
}

}  // namespace umov::chamber
