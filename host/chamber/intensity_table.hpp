// The front half of a measured intensity distribution, to look up and to launch rays from.
#pragma once

#include <vector>

#include "host/chamber/planes_surface.hpp"
#include "host/formats/photometry.hpp"

namespace umov::chamber {

class IntensityTable {
 public:
  /// Scaled to 1 lm. Throws umov::Error naming `name` where more than 1 % of the light goes
  /// backwards or there is none.
  IntensityTable(const formats::Photometry& photometry, const std::string& name);

  /// cd per lumen. z along the axis, C0 along x.
  double intensity(const Vec3& direction) const;
  /// A direction in front, drawn by cells; `weight` is intensity/density, 1 in the mean.
  struct Launch {
    Vec3 direction;
    double weight;
  };
  Launch launch(double u1, double u2, double u3) const;

 private:
  formats::Photometry photometry_;
  double scale_ = 1.0;
  std::vector<double> edge_c_, edge_cos_;  ///< of cells: C in radians, cosines falling from 1
  std::vector<double> share_before_;       ///< of the light, cell by cell, with a last 1
};

}  // namespace umov::chamber
