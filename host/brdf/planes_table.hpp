// A table measured in two planes: the plane of incidence, and the plane perpendicular to it through
// the mirror direction.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "host/brdf/table.hpp"

namespace umov::brdf {

/// Values along a line of directions, for each wavelength. `deg` rises strictly.
struct PlaneProfile {
  std::vector<double> deg;
  std::vector<std::vector<double>> brdf_per_sr;  ///< [wavelength][entry], m00
};

/// What was measured at one incidence. A direction that could not be measured (the detector in the
/// beam) is left out of the profile.
struct PlanesAtIncidence {
  double theta_i_deg = 0.0;  ///< [0, 90)
  PlaneProfile in_plane;     ///< by signed θr, within [-90, 90]; negative is the retro side
  PlaneProfile across;  ///< by the angle β from the mirror direction, within [-90, 90]; with no
                        ///< negative entry both sides are the same
};

/// The model [M] calls tabular (docs/physics.md, 3). Unpolarised.
///
/// A direction is named by the slope of the facet that mirrors the light into it: its tangent
/// tan θh and, between the planes, the share sin²ψ that the plane across has in it (0 in the plane
/// of incidence, 1 in the plane across). Its value is cos²ψ · in_plane + sin²ψ · across, each taken
/// where its plane has that tangent: exact in both planes, exact for a Lambertian surface and for
/// any function of θh, continuous everywhere. Both profiles meet in the mirror direction; where
/// only one has an entry there the other takes it over, where both have one each takes their mean.
/// Between incidences it interpolates linearly at equal slopes, so that peaks move with the mirror
/// direction. Beyond the last entry of a profile its value stays; where the plane of incidence lies
/// below the horizon it falls off as the plane across does. No value is above those it is made
/// from. Reciprocity is not imposed: reciprocity_violation() (host/brdf/checks.hpp) tells how far
/// it is off.
class PlanesTable : public Table {
 public:
  /// `origin` names the source in errors and in description(). Throws umov::Error with the place
  /// for incidences, profiles or wavelengths that do not rise or leave their range, a wrong number
  /// of values, and values that are negative or not finite.
  PlanesTable(std::vector<double> wavelengths_um, std::vector<PlanesAtIncidence> incidences,
              std::string origin);

  optics::Mueller<double> at(double wavelength_um, const Geometry<double>& geometry) const override;
  const std::vector<double>& wavelengths_um() const override { return wavelengths_um_; }
  bool polarised() const override { return false; }
  std::string description() const override;

  /// As given, without what the mirror direction added.
  std::span<const PlanesAtIncidence> incidences() const { return given_; }
  const std::string& origin() const { return origin_; }

  /// The facet that mirrors into a direction, as seen from the two planes.
  struct Facet {
    double tangent;         ///< tan θh
    double in_plane_share;  ///< cos²ψ
    bool backward;          ///< on the retro side of the plane across
    bool left;              ///< y < 0
  };
  /// The value at a stored wavelength and incidence, by number; also for facets that mirror below
  /// the horizon there, which neighbouring incidences ask for.
  double at_facet(std::size_t wavelength, std::size_t incidence, const Facet& facet) const {
    return value(wavelength, joined_[incidence], facet);
  }

 private:
  double value(std::size_t wavelength, const PlanesAtIncidence& slice, const Facet& facet) const;

  std::vector<double> wavelengths_um_;
  std::vector<PlanesAtIncidence> given_;
  std::vector<PlanesAtIncidence> joined_;  ///< both profiles meet in the mirror direction
  std::string origin_;
};

}  // namespace umov::brdf
