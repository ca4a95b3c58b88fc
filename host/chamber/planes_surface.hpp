// A table of two planes made ready for millions of look-ups a second, with a lobe to draw from.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "host/brdf/planes_table.hpp"
#include "host/chamber/facing.hpp"

namespace umov::chamber {

/// brdf::PlanesTable at one of its wavelengths, unpolarised, with its energy kept: values are
/// scaled by a factor of the incidence. Two planes say nothing of the directions off them, and a
/// lobe that grows steeply to grazing would, interpolated, shine with more light than came in. With
/// `total`, a hemispherical reflectance measured otherwise, every incidence is scaled to that;
/// without it the reflectance between the rows and beyond the last one is the linear interpolation
/// of what the rows' own planes give.
///
/// Profiles are resampled to 1,024 slopes (uniform in t/(1/4 + t)), which follows them to 1e-3 of a
/// value where they bend, and far better elsewhere. Directions are local unit vectors, z along the
/// normal.
class PlanesSurface {
 public:
  /// `wavelength` is a number of the table's. Throws umov::Error, without a place, where an
  /// incidence would have to be scaled by less than 1/4 or more than 4.
  PlanesSurface(const brdf::PlanesTable& table, std::size_t wavelength,
                std::optional<double> total = {});
  /// At any wavelength: linear between the table's, constant beyond them.
  static PlanesSurface at_wavelength(const brdf::PlanesTable& table, double wavelength_um,
                                     std::optional<double> total = {});

  /// BRDF in 1/sr for light that comes from `from` and goes to `to`, both above the horizon.
  double value(const Vec3& from, const Vec3& to) const;

  class Facing;

 private:
  /// Part of the way from a wavelength of the table to the next.
  struct Between {
    std::size_t lower;
    double part;
  };
  PlanesSurface(const brdf::PlanesTable& table, const Between& wavelength,
                std::optional<double> total);

  /// At one slope of one incidence: in plane forwards and backwards, across to the right and left.
  using Values = std::array<float, 4>;
  struct Lobe {
    double share, width;
  };
  class Mixture;
  Lobe lobe_at(double cosine) const;
  double interpolated(const Vec3& from, const Vec3& to, double theta_deg) const;
  double factor_at(double theta_deg) const;
  double interpolated_reflectance(double theta_i_deg) const;
  void fit_lobes();
  void keep_energy(std::optional<double> total);

  std::vector<double> theta_i_deg_;  ///< of the slices
  std::vector<std::size_t> below_;   ///< by degree: slices up to it
  std::vector<Values> values_;       ///< [slope][slice]: neighbours are looked up together
  std::vector<Lobe> lobes_;          ///< at equally spaced cosines from 0 to 1
  std::vector<double> factors_;      ///< at every degree of incidence from 0
};

/// Draws from a mixture: the cosine, and facets mirroring (visible normals after Trowbridge and
/// Reitz). Density per steradian of a direction for a known one.
class PlanesSurface::Mixture {
 public:
  Mixture(const Lobe& lobe, const Vec3& known);
  double density(const Vec3& drawn) const;
  /// Below the horizon: nothing was drawn.
  Vec3 draw(double u1, double u2, double u3) const;

 private:
  Vec3 known_;
  double share_, width_, width2_less_1_;
  double diffuse_, facets_;  ///< factors of the two densities
};

class PlanesSurface::Facing {
 public:
  Facing(const PlanesSurface& surface, const Vec3& known, Sense sense);
  double value(const Vec3& other) const;
  double density(const Vec3& other) const { return mixture_.density(other); }
  std::optional<Drawn> draw(double u1, double u2, double u3) const;
  double mirror() const { return 0.0; }
  double mirror_probability() const { return 0.0; }

 private:
  const PlanesSurface& surface_;
  const Vec3& known_;
  Sense sense_;
  Mixture mixture_;
};

}  // namespace umov::chamber
