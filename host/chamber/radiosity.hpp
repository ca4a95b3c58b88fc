// The diffuse mixing chamber by radiosity: exchange of light between small patches, no rays. An
// answer to hold the ray tracer against; it shares no line with it.
#pragma once

#include <cstddef>
#include <vector>

namespace umov::chamber {

/// An open cylinder with a Lambertian wall and base. In the base black-edged holes, each with a
/// Lambertian disc of the same radius below it that shines up.
struct DiffuseChamber {
  double radius_mm, height_mm;
  double wall_rho, base_rho;
  struct Hole {
    double x_mm, y_mm, radius_mm, depth_mm, flux_lm;
  };
  std::vector<Hole> holes;
};

/// Wall from below, base from the axis. Edges of zones; the first is 0, the last height or radius.
struct Zones {
  std::vector<double> wall_mm, base_mm;
  std::size_t nodes = 6;    ///< Gauss points in each zone
  std::size_t around = 96;  ///< patches around the axis
};

struct Radiosity {
  std::vector<double> wall_lx, base_lx;  ///< mean irradiance of each zone, holes left out
  double out_lm = 0.0;
  double first_hit_lm = 0.0;  ///< of the sources on wall and base before any reflection
  double into_holes_lm = 0.0;
};

/// Patches see each other by point-to-point view factors, scaled so that what each sees of wall,
/// base and opening is what closed forms say. Iterates until nothing changes by 1e-10.
Radiosity solve_radiosity(const DiffuseChamber& chamber, const Zones& zones);

}  // namespace umov::chamber
