// Matt faces, and [M]'s matt face with a mirrored share.
#pragma once

#include <optional>
#include <vector>

#include "host/chamber/facing.hpp"
#include "host/optics/angles.hpp"

namespace umov::chamber {

/// Everything is absorbed, or the share `rho` comes back in equal radiance everywhere.
struct Lambertian {
  double rho;

  class Facing {
   public:
    Facing(const Lambertian& surface, const Vec3& /*known*/, Sense /*sense*/) : rho_(surface.rho) {}
    double value(const Vec3& /*other*/) const { return rho_ / optics::pi; }
    double density(const Vec3& other) const { return rho_ > 0.0 ? other.z / optics::pi : 0.0; }
    std::optional<Drawn> draw(double u1, double u2, double /*u3*/) const {
      if (rho_ == 0.0) return std::nullopt;
      const Vec3 to = cosine_draw(u1, u2);
      return Drawn{to, rho_, to.z / optics::pi};
    }
    double mirror() const { return 0.0; }
    double mirror_probability() const { return 0.0; }

   private:
    double rho_;
  };
};

/// [M]'s diffuse/specular model: the share `specular` of the incidence is mirrored, the rest of
/// `total` leaves in equal radiance. Not reciprocal where `specular` changes with the incidence.
class DiffuseSpecular {
 public:
  /// `theta_i_deg` ascending, in [0, 90); `specular`, as many, at most `total`: linear between,
  /// constant beyond the ends. Surface() checks them.
  DiffuseSpecular(double total, std::vector<double> theta_i_deg, std::vector<double> specular);

  double total() const { return total_; }
  const std::vector<double>& theta_i_deg() const { return theta_i_deg_; }
  const std::vector<double>& specular() const { return specular_; }
  /// `specular` at the cosine of an incidence, resampled every .04°.
  double specular_at(double cosine) const {
    const double scaled = steps * std::sqrt(std::clamp(1.0 - cosine, 0.0, 1.0));
    const auto lower = static_cast<std::size_t>(scaled);
    const double low = table_[lower];
    return low + (scaled - static_cast<double>(lower)) * (table_[lower + 1] - low);
  }

  class Facing {
   public:
    Facing(const DiffuseSpecular& surface, const Vec3& known, Sense sense)
        : surface_(surface),
          known_(known),
          sense_(sense),
          specular_(surface.specular_at(known.z)),
          probability_(surface.total_ > 0.0 ? specular_ / surface.total_ : 0.0) {}
    double value(const Vec3& other) const {
      // The share that is mirrored is that of where the light comes from.
      const double specular =
          sense_ == Sense::with_light ? specular_ : surface_.specular_at(other.z);
      return (surface_.total_ - specular) / optics::pi;
    }
    double density(const Vec3& other) const {
      return surface_.total_ > 0.0 ? (1.0 - probability_) * other.z / optics::pi : 0.0;
    }
    std::optional<Drawn> draw(double u1, double u2, double u3) const {
      if (surface_.total_ == 0.0) return std::nullopt;
      if (u3 < probability_) return Drawn{mirrored(known_), surface_.total_, 0.0};
      const Vec3 to = cosine_draw(u1, u2);
      return Drawn{to, optics::pi * value(to) / (1.0 - probability_), density(to)};
    }
    double mirror() const { return specular_; }
    double mirror_probability() const { return probability_; }

   private:
    const DiffuseSpecular& surface_;
    const Vec3& known_;
    Sense sense_;
    double specular_, probability_;
  };

 private:
  // Uniform in √(1 − cosine), where the angle is smooth.
  static constexpr std::size_t steps = 2048;
  double total_;
  std::vector<double> theta_i_deg_, specular_;
  std::vector<double> table_;
};

}  // namespace umov::chamber
