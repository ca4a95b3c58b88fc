// What the faces of a luminaire do to light, in luminance alone: one number instead of a Mueller
// matrix. Right where the light is unpolarised at every bounce, as it is after any matt reflection.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "host/chamber/diffuse_surface.hpp"
#include "host/chamber/modelled_surface.hpp"
#include "host/chamber/planes_surface.hpp"

namespace umov::chamber {

/// Directions are local unit vectors away from the face, z along the normal, above the horizon.
class Surface {
 public:
  using Kind = std::variant<Lambertian, DiffuseSpecular, PlanesSurface, Modelled>;
  /// The same in all bands; or a model whose sampler holds one wavelength a band. Throws
  /// umov::Error, with `name` as its place, for reflectances outside 0 to 1, rows that do not
  /// rise, and a table or model that reflects more than it gets (1.001 at any incidence up to 89°).
  Surface(std::string name, Kind kind);
  /// One a band, all of one kind (not a model), of one mirrored share. Directions are drawn as in
  /// the band that reflects most. Throws umov::Error as above.
  Surface(std::string name, std::vector<Kind> bands);

  /// BRDF in 1/sr without a mirror part; light comes from `from` and goes to `to`.
  double value(const Vec3& from, const Vec3& to) const;
  /// u1, u2, u3: uniform in [0, 1). Nothing where the draw led nowhere (it counts as 0).
  std::optional<Drawn> draw(const Vec3& known, Sense sense, double u1, double u2, double u3) const;
  /// Density of draw(), per steradian, other than exactly in the mirror direction.
  double density(const Vec3& known, const Vec3& drawn) const;
  /// Calls work(facing) with the Facing of the surface's own kind.
  template <class Work>
  decltype(auto) facing(const Vec3& known, Sense sense, const Work& work) const {
    return std::visit(
        [&](const auto& kind) -> decltype(auto) {
          return work(typename std::decay_t<decltype(kind)>::Facing(kind, known, sense));
        },
        kind_);
  }

  /// value() of each band.
  void values(const Vec3& from, const Vec3& to, std::span<double> bands) const;
  /// Multiplies `bands` by the weights of a draw in each band.
  void weigh(const Drawn& drawn, const Vec3& known, Sense sense, std::span<double> bands) const;

  /// Directional-hemispherical reflectance, mirror part included, by a fixed quadrature of 1e-4;
  /// of the band that reflects most.
  double reflectance(double theta_i_deg) const;
  /// Nothing comes back.
  bool black() const;
  /// How many it was made for; 1: the same in all.
  std::size_t bands() const;
  const std::string& name() const { return name_; }
  /// The band that reflects most.
  const Kind& kind() const { return kind_; }

 private:
  void check() const;

  std::string name_;
  Kind kind_;
  std::vector<Kind> bands_;
};

}  // namespace umov::chamber
