// A table of two planes made ready for millions of look-ups a second, with a lobe to draw from.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/brdf/planes_table.hpp"

namespace umov::chamber {

using Vec3 = optics::Vec3<double>;

/// brdf::PlanesTable at one of its wavelengths, unpolarised, with its energy kept: values are
/// scaled by a factor of the incidence. Two planes say nothing of the directions off them, and a
/// lobe that grows steeply to grazing would, interpolated, shine with more light than came in. With
/// `total`, a hemispherical reflectance measured otherwise, every incidence is scaled to that;
/// without it the reflectance between the rows and beyond the last one is the linear interpolation
/// of what the rows' own planes give.
///
/// Profiles are resampled to 4,096 slopes (uniform in t/(1 + t)), which follows them to 1e-3 of a
/// value where they bend, and far better elsewhere. Directions are local unit vectors, z along the
/// normal.
class PlanesSurface {
 public:
  /// `wavelength` is a number of the table's. Throws umov::Error, without a place, where an
  /// incidence would have to be scaled by less than 1/4 or more than 4.
  PlanesSurface(const brdf::PlanesTable& table, std::size_t wavelength,
                std::optional<double> total = {});

  /// BRDF in 1/sr for light that comes from `from` and goes to `to`, both above the horizon.
  double value(const Vec3& from, const Vec3& to) const;

  /// A direction for one that is known: a mixture of the cosine and of facets mirroring (visible
  /// normals after Trowbridge and Reitz). Below the horizon: nothing was drawn.
  Vec3 draw(const Vec3& known, double u1, double u2, double u3) const;
  /// Its density per steradian.
  double density(const Vec3& known, const Vec3& drawn) const;

 private:
  /// One incidence: in plane forwards and backwards, across to the right and to the left.
  struct Slice {
    double theta_i_deg;
    std::vector<float> forward, backward, right, left;
  };
  struct Lobe {
    double share, width;
  };
  double of_slice(const Slice& slice, double place, double in_plane_share, bool backward,
                  bool left) const;
  Lobe lobe_at(double cosine) const;
  double interpolated(const Vec3& from, const Vec3& to, double theta_deg) const;
  double factor_at(double theta_deg) const;
  double interpolated_reflectance(double theta_i_deg) const;
  void fit_lobes();
  void keep_energy(std::optional<double> total);
  static double mixture(const Lobe& lobe, const Vec3& known, const Vec3& drawn);

  std::vector<Slice> slices_;
  std::vector<Lobe> lobes_;      ///< at equally spaced cosines from 0 to 1
  std::vector<double> factors_;  ///< at every degree of incidence from 0
};

}  // namespace umov::chamber
