// A BRDF sampled around the mirror direction, as Zemax' tabular BSDF files do it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "host/brdf/table.hpp"

namespace umov::formats {

/// Exit direction seen from the mirror direction of the incident beam.
struct SpecularAngles {
  double radial;   ///< angle from the mirror direction, [0, π]
  double azimuth;  ///< around it: 0 towards the surface normal, [0, 2π), right-handed about it
};

SpecularAngles specular_angles(const brdf::Geometry<double>& geometry);
/// The reverse. θr comes out above π/2 for directions below the horizon.
brdf::Geometry<double> geometry_of(double theta_i, const SpecularAngles& angles);

struct SpecularAxes {
  std::vector<double> theta_i_deg;  ///< rising, [0, 90)
  std::vector<double> azimuth_deg;  ///< rising, [0, 180] where symmetric, else [0, 360]
  std::vector<double> radial_deg;   ///< rising, [0, 180]
  bool symmetric = true;            ///< the same at azimuth and -azimuth
};

/// Linear in incidence (at equal radial and azimuth, so that peaks move with the mirror direction),
/// azimuth and radial angle. Entries that lie below the horizon take no part; where all neighbours
/// do, the nearest entry towards the mirror direction serves.
class SpecularTable final : public brdf::Table {
 public:
  /// `values` are BRDF in 1/sr and run wavelength (slowest), θi, azimuth, radial; `tis` (total
  /// integrated scatter: the DHR of the table) run wavelength, θi. Throws umov::Error for axes that
  /// do not rise or leave their range, wrong numbers of values, and values that are negative or not
  /// finite. `origin` names the source.
  SpecularTable(SpecularAxes axes, std::vector<double> wavelengths_um, std::vector<double> values,
                std::vector<double> tis, std::string origin);

  optics::Mueller<double> at(double wavelength_um,
                             const brdf::Geometry<double>& geometry) const override;
  const std::vector<double>& wavelengths_um() const override { return wavelengths_um_; }
  bool polarised() const override { return false; }
  std::string description() const override;

  const SpecularAxes& axes() const { return axes_; }
  std::span<const double> values() const { return values_; }
  std::span<const double> tis() const { return tis_; }
  const std::string& origin() const { return origin_; }

 private:
  double slice_value(std::size_t wavelength, std::size_t incidence, const SpecularAngles& at) const;

  SpecularAxes axes_;
  std::vector<double> wavelengths_um_;
  std::vector<double> values_;
  std::vector<double> tis_;
  std::string origin_;
  std::vector<unsigned char> above_;  ///< by θi, azimuth, radial
};

}  // namespace umov::formats
