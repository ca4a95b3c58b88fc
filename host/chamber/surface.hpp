// What the faces of a luminaire do to light, in luminance alone: one number instead of a Mueller
// matrix. Right where the light is unpolarised at every bounce, as it is after any matt reflection.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "host/brdf/sampler.hpp"
#include "host/chamber/planes_surface.hpp"

namespace umov::chamber {

/// Everything is absorbed, or the share `rho` comes back in equal radiance everywhere.
struct Lambertian {
  double rho;
};

/// [M]'s diffuse/specular model: the share `specular` of the incidence is mirrored, the rest of
/// `total` leaves in equal radiance. Not reciprocal where `specular` changes with the incidence.
struct DiffuseSpecular {
  double total;
  std::vector<double> theta_i_deg;  ///< ascending, in [0, 90)
  std::vector<double> specular;     ///< at most `total`; linear between, constant beyond the ends
  /// `specular` at the cosine of an incidence.
  double specular_at(double cosine) const;
};

/// Any model of the library.
struct Modelled {
  brdf::Sampler sampler;
};

/// Which way paths run: with the light, or from the eye against it.
enum class Sense { with_light, against_light };

/// A direction that was drawn for a known one.
struct Drawn {
  Vec3 direction;
  double weight;  ///< BRDF · cosine of the drawn direction/density; mirror reflectance/probability
  double density;  ///< per steradian; 0: exactly the mirror direction
};

/// Directions are local unit vectors away from the face, z along the normal, above the horizon.
class Surface {
 public:
  using Kind = std::variant<Lambertian, DiffuseSpecular, PlanesSurface, Modelled>;
  /// Throws umov::Error, with `name` as its place, for reflectances outside 0 to 1, rows that do
  /// not rise, and a table or model that reflects more than it gets (1.001 at any incidence up to
  /// 89°).
  Surface(std::string name, Kind kind);

  /// BRDF in 1/sr without a mirror part; light comes from `from` and goes to `to`.
  double value(const Vec3& from, const Vec3& to) const;
  /// u1, u2, u3: uniform in [0, 1). Nothing where the draw led nowhere (it counts as 0).
  std::optional<Drawn> draw(const Vec3& known, Sense sense, double u1, double u2, double u3) const;
  /// Density of draw(), per steradian, other than exactly in the mirror direction.
  double density(const Vec3& known, const Vec3& drawn) const;

  /// Directional-hemispherical reflectance, mirror part included, by a fixed quadrature of 1e-4.
  double reflectance(double theta_i_deg) const;
  /// Nothing comes back.
  bool black() const;
  const std::string& name() const { return name_; }
  const Kind& kind() const { return kind_; }

 private:
  std::string name_;
  Kind kind_;
};

}  // namespace umov::chamber
