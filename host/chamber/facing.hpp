// A meeting of light with a face, of which one direction is known; the other one is asked about or
// drawn. Each kind of surface has a class Facing that works out once what the known direction
// settles:
//
//   Facing(const Kind&, const Vec3& known, Sense)
//   value(other)         BRDF in 1/sr without a mirror part
//   density(other)       of draw(), per steradian, other than exactly in the mirror direction
//   draw(u1, u2, u3)     u1, u2 place the direction, u3 chooses among parts; uniform in [0, 1)
//   mirror()             share of the light that leaves exactly in the mirror direction
//   mirror_probability() with which draw() goes there
//
// Directions are local unit vectors away from the face, z along the normal, above the horizon.
#pragma once

#include <cmath>
#include <optional>

#include "host/chamber/fast_angle.hpp"
#include "host/optics/mueller.hpp"

namespace umov::chamber {

using Vec3 = optics::Vec3<double>;

/// Which way paths run: with the light, which comes from the known direction, or from the eye
/// against it, where it goes there.
enum class Sense { with_light, against_light };

/// A direction that was drawn for a known one.
struct Drawn {
  Vec3 direction;
  double weight;  ///< BRDF · cosine of the drawn direction/density; mirror reflectance/probability
  double density;  ///< per steradian; 0: exactly the mirror direction
};

/// Density cosine/π.
inline Vec3 cosine_draw(double u1, double u2) {
  const double sine = std::sqrt(u1);
  const Turn phi = turn(u2);
  return {sine * phi.cosine, sine * phi.sine, std::sqrt(1.0 - u1)};
}

inline Vec3 mirrored(const Vec3& v) {
  return {-v.x, -v.y, v.z};
}

}  // namespace umov::chamber
