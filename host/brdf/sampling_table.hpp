// A proposal tabulated from any BRDF: for lobes without a closed form to draw from.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "host/brdf/facet.hpp"
#include "host/brdf/sampling_directions.hpp"

namespace umov::brdf {

/// Cells in the facet slopes' polar coordinates, where a lobe about the mirror direction lies at
/// the origin whatever its width: azimuth ψ in [0, π] (both sides alike) and a radius that is
/// quadratic near the mirror direction, logarithmic beyond the lobe's own width and 1 on the
/// horizon. For each incidence of IncidenceGrid the cells are chosen to hold about equal shares of
/// the reflected light; in between, one of the two neighbours is drawn.
///
/// The density is that of the cells, exactly, so that the table decides only how much a weight
/// scatters. A share of 2 % is drawn from the cosine instead: no direction is left out, whatever
/// the cells missed.
class TableLobe {
 public:
  /// m00 of a BRDF; symmetric in ±φ or sampled as if it were.
  using Brdf = std::function<double(const Geometry<double>&)>;
  /// Evaluates `brdf` some 180 000 times.
  explicit TableLobe(const Brdf& brdf);

  /// Never below the horizon but by rounding.
  optics::Vec3<double> draw(const Incidence& in, double u1, double u2, double u3) const;
  double pdf(const Incidence& in, const Exit& exit) const;

 private:
  static constexpr std::size_t azimuths = 24;
  static constexpr std::size_t radii = 48;

  /// Borders of the cells and, for each, the share of light before it. All rise from 0 to 1, but
  /// psi to π.
  struct Node {
    std::vector<double> psi, psi_share;  ///< azimuths + 1
    std::vector<double> radius;          ///< radii + 1
    std::vector<double> radius_share;    ///< azimuths × (radii + 1)
    double log_width = 0.0;              ///< of the lobe, in slope
  };

  Node tabulate(const Brdf& brdf, double theta_i) const;

  std::vector<Node> nodes_;
};

}  // namespace umov::brdf
