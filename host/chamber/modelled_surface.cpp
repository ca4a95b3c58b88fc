#include "host/chamber/modelled_surface.hpp"

#include <algorithm>
#include <cmath>

#include "host/brdf/evaluate.hpp"

namespace umov::chamber {
namespace {

// 90° itself is no incidence of a model.
constexpr double least_cosine = 1e-9;

double incidence(const Vec3& v) {
  return std::acos(std::clamp(v.z, least_cosine, 1.0));
}

/// The library's angles for light from `from` to `to`.
brdf::Geometry<double> geometry_of(const Vec3& from, const Vec3& to) {
  const double x = -(from.x * to.x + from.y * to.y);
  const double y = from.y * to.x - from.x * to.y;
  const double sine = std::hypot(from.x, from.y);
  const double phi = sine > 1e-12 ? std::atan2(y, x) : std::atan2(to.y, to.x);
  return {std::acos(std::min(1.0, from.z)), std::acos(std::min(1.0, to.z)), phi};
}

}  // namespace

double Modelled::Facing::value(const Vec3& other, std::size_t wavelength) const {
  const brdf::SpectralValues& s = surface_.sampler.spectrum()[wavelength];
  const auto geometry =
      sense_ == Sense::with_light ? geometry_of(known_, other) : geometry_of(other, known_);
  return brdf::evaluate<double>(surface_.sampler.model(), s.values, s.wavelength_um,
                                geometry)[0][0];
}

double Modelled::Facing::density(const Vec3& other) const {
  return surface_.sampler.pdf(geometry_of(known_, other));
}

std::optional<Drawn> Modelled::Facing::draw(double u1, double u2, double u3) const {
  const auto sample = surface_.sampler.sample(incidence(known_), u1, u2, u3);
  if (!sample) return std::nullopt;
  if (sample->mirror) return Drawn{mirrored(known_), sample->weight[0][0], 0.0};
  const double sine = std::hypot(known_.x, known_.y);
  const double ex = sine > 1e-12 ? -known_.x / sine : 1.0;
  const double ey = sine > 1e-12 ? -known_.y / sine : 0.0;
  const Vec3& d = sample->direction;
  const Vec3 to(d.x * ex - d.y * ey, d.x * ey + d.y * ex, d.z);
  const double weight =
      sense_ == Sense::with_light ? sample->weight[0][0] : value(to) * to.z / sample->density;
  return Drawn{to, weight, sample->density};
}

double Modelled::Facing::mirror(std::size_t wavelength) const {
  const brdf::SpectralValues& s = surface_.sampler.spectrum()[wavelength];
  return brdf::mirror_reflectance<double>(surface_.sampler.model(), s.values, s.wavelength_um,
                                          incidence(known_))[0][0];
}

double Modelled::Facing::mirror_probability() const {
  return surface_.sampler.mirror_probability(incidence(known_));
}

}  // namespace umov::chamber
