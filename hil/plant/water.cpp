#include "hil/plant/water.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "hil/plant/paint_sample.hpp"
#include "hil/plant/rough_surface.hpp"
#include "host/optics/fresnel.hpp"

namespace umov::plant {
namespace {

constexpr double pi = optics::pi;

/// A beam bent at a water surface, with the matrix from the basis outside to the one inside.
struct Refracted {
  Beam inside;
  Mueller transmission;
};

/// `beam` comes down on a surface with `normal`, from air into index n.
Refracted into_water(const Beam& beam, const Vec3& normal, double n) {
  const double cosine = std::min(1.0, -optics::dot(beam.k, normal));
  const double cos_inside = std::sqrt(1.0 - (1.0 - cosine * cosine) / (n * n));
  const Vec3 k = (1.0 / n) * beam.k + (cosine / n - cos_inside) * normal;
  Vec3 across = optics::cross(beam.k, normal);
  const double length2 = optics::dot(across, across);
  // At normal incidence both polarisations pass alike and any axis will do.
  across = length2 > 1e-24 ? across * (1.0 / std::sqrt(length2)) : beam.s;
  const double s = 1.0 - optics::reflectance_s(n, 0.0, cosine);
  const double p = 1.0 - optics::reflectance_p(n, 0.0, cosine);
  Mueller t = optics::zero_mueller<double>();
  optics::set_element(t, 0, 0, 0.5 * (s + p));
  optics::set_element(t, 1, 1, 0.5 * (s + p));
  optics::set_element(t, 0, 1, 0.5 * (s - p));
  optics::set_element(t, 1, 0, 0.5 * (s - p));
  optics::set_element(t, 2, 2, std::sqrt(s * p));
  optics::set_element(t, 3, 3, std::sqrt(s * p));
  const auto turn = optics::rotation_to(beam, across);
  return {{across, optics::cross(k, across), k},
          optics::product(t, optics::rotation(turn.cos2, turn.sin2))};
}

/// The way back: a beam inside that leaves as `beam`, matrix from the basis inside to the outside.
Refracted out_of_water(const Beam& beam, const Vec3& normal, double n) {
  const Beam reversed{beam.s, Vec3(-beam.p.x, -beam.p.y, -beam.p.z),
                      Vec3(-beam.k.x, -beam.k.y, -beam.k.z)};
  const Refracted entering = into_water(reversed, normal, n);
  const Vec3 k(-entering.inside.k.x, -entering.inside.k.y, -entering.inside.k.z);
  const Vec3 s = entering.inside.s;
  // Reversed light has the transposed matrix with U and V of both bases changed in sign.
  Mueller t = optics::zero_mueller<double>();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      const double sign = (row >= 2) == (column >= 2) ? 1.0 : -1.0;
      optics::set_element(t, row, column,
                          sign * optics::element(entering.transmission, column, row));
    }
  }
  return {{s, optics::cross(k, s), k}, t};
}

/// Share of the cap's surface that a direction sees, per area of its base and cosine.
double cap_masking(const std::vector<Vec3>& normals, const Vec3& towards, double base_share) {
  double sum = 0.0;
  for (const Vec3& n : normals) sum += std::max(0.0, optics::dot(towards, n));
  sum *= base_share / static_cast<double>(normals.size());
  return sum > 0.0 ? std::min(1.0, towards.z / sum) : 0.0;
}

}  // namespace

Wetted::Wetted(std::shared_ptr<const Sample> sample)
    : immersed_(std::move(sample)), water_(optics::IndexTable::embedded("H2O_Hale")) {
  constexpr double middle_of_spectrum_nm = 633.0;
  if (auto changed = immersed_->immersed(index(middle_of_spectrum_nm)))
    immersed_ = std::move(changed);
}

double Wetted::index(double wavelength_nm) const {
  return water_.n(1e-3 * wavelength_nm);
}

Mueller Wetted::through(const Beam& in, const Vec3& normal_i, const Beam& out, const Vec3& normal_r,
                        double wavelength_nm) const {
  const double n = index(wavelength_nm);
  const Refracted entry = into_water(in, normal_i, n);
  const Refracted exit = out_of_water(out, normal_r, n);
  if (entry.inside.k.z >= 0.0 || exit.inside.k.z <= 0.0) return optics::zero_mueller<double>();
  const Mueller inner = immersed_->brdf(entry.inside, exit.inside, wavelength_nm);
  return (1.0 / (n * n)) *
         optics::product(exit.transmission, optics::product(inner, entry.transmission));
}

double Wetted::diffuse(double cos_i, double cos_r, double wavelength_nm) const {
  const double n = index(wavelength_nm);
  const double inside = 1.0 - mean_transmittance(n, 0.0) / (n * n);
  // Far from the mirror direction there is nothing but diffuse light.
  const Beam probe = optics::incident_beam(optics::radians(45.0));
  double albedo = 0.0;
  constexpr int directions = 4;
  for (int i = 0; i < directions; ++i) {
    const double phi = optics::radians(75.0 + 30.0 * i);
    albedo += pi / directions *
              optics::element(immersed_->brdf(probe, optics::exit_beam(optics::radians(40.0), phi),
                                              wavelength_nm),
                              0, 0);
  }
  albedo = std::min(albedo, 1.0);
  return optics::transmittance(n, 0.0, cos_i) * optics::transmittance(n, 0.0, cos_r) /
         (pi * n * n) * albedo * albedo * inside / (1.0 - albedo * inside);
}

WaterFilm::WaterFilm(std::shared_ptr<const Sample> below, const FilmConfig& config)
    : Coating(below), wetted_(std::move(below)), config_(config) {}

Mueller WaterFilm::brdf(const Beam& in, const Beam& out, double wavelength_nm) const {
  const double cos_i = -in.k.z;
  const double cos_r = out.k.z;
  if (cos_i <= 0.0 || cos_r <= 0.0) return optics::zero_mueller<double>();
  const Vec3 up(0.0, 0.0, 1.0);
  Mueller wet = wetted_.through(in, up, out, up, wavelength_nm);
  wet += facet_factor(config_.slope_rms, in.k, out.k) *
         facet_reflection(wetted_.index(wavelength_nm), 0.0, in, out);
  optics::set_element(wet, 0, 0,
                      optics::element(wet, 0, 0) + wetted_.diffuse(cos_i, cos_r, wavelength_nm));
  return (1.0 - config_.coverage) * below().brdf(in, out, wavelength_nm) + config_.coverage * wet;
}

Mueller WaterFilm::mirror(const Beam& in, const Beam& out, double wavelength_nm) const {
  return (1.0 - config_.coverage) * below().mirror(in, out, wavelength_nm);
}

WaterDrops::WaterDrops(std::shared_ptr<const Sample> below, const DropsConfig& config)
    : Coating(below), wetted_(std::move(below)), config_(config) {
  // A spiral of equal solid angles over the cap.
  constexpr int count = 40;
  const double rim = std::cos(optics::radians(config.contact_angle_deg));
  const double golden = pi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (1.0 - rim) * (i + 0.5) / count;
    const double r = std::sqrt(1.0 - z * z);
    normals_.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
}

Mueller WaterDrops::brdf(const Beam& in, const Beam& out, double wavelength_nm) const {
  const double cos_i = -in.k.z;
  const double cos_r = out.k.z;
  if (cos_i <= 0.0 || cos_r <= 0.0) return optics::zero_mueller<double>();
  const Vec3 towards_source(-in.k.x, -in.k.y, -in.k.z);
  const double rim_sine2 = std::pow(std::sin(optics::radians(config_.contact_angle_deg)), 2.0);
  const double rim_cosine = std::cos(optics::radians(config_.contact_angle_deg));

  // Through the drop: each part of the cap that the light enters by with one that it leaves by,
  // weighted with the flux it takes.
  constexpr std::size_t stride = 17;  // pairs entries with exits that lie elsewhere on the cap
  Mueller wet = optics::zero_mueller<double>();
  double weight = 0.0;
  for (std::size_t i = 0; i < normals_.size(); i += 4) {
    const Vec3& entry = normals_[i];
    const Vec3& exit = normals_[(i + stride) % normals_.size()];
    const double flux =
        std::max(0.0, optics::dot(towards_source, entry)) * std::max(0.0, optics::dot(out.k, exit));
    if (flux <= 0.0) continue;
    weight += flux;
    wet += flux * wetted_.through(in, entry, out, exit, wavelength_nm);
  }
  if (weight > 0.0) wet *= 1.0 / weight;
  optics::set_element(wet, 0, 0,
                      optics::element(wet, 0, 0) + wetted_.diffuse(cos_i, cos_r, wavelength_nm));

  // Off the cap: its normals fill a cone evenly, 1/(π sin² rim) per area of its base.
  const Vec3 v = out.k - in.k;
  const double cos_h = v.z / std::sqrt(optics::dot(v, v));
  if (cos_h > rim_cosine) {
    const double base_share = 2.0 * pi * (1.0 - rim_cosine) / (pi * rim_sine2);
    const double seen = cap_masking(normals_, towards_source, base_share) *
                        cap_masking(normals_, out.k, base_share);
    wet += seen / (4.0 * pi * rim_sine2 * cos_i * cos_r) *
           facet_reflection(wetted_.index(wavelength_nm), 0.0, in, out);
  }
  return (1.0 - config_.coverage) * below().brdf(in, out, wavelength_nm) + config_.coverage * wet;
}

Mueller WaterDrops::mirror(const Beam& in, const Beam& out, double wavelength_nm) const {
  return (1.0 - config_.coverage) * below().mirror(in, out, wavelength_nm);
}

}  // namespace umov::plant
