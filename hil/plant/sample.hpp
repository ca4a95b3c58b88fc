// What lies on the sample stage: a polarised BRDF and, for smooth surfaces, a mirror reflection.
//
// These are the world's own reflectance models, written from the formulas and independent of the
// host's model library, so that an inversion is never tested against itself. A contamination (dust,
// a water film) is a Sample that wraps another one.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/optics/frames.hpp"
#include "host/optics/mueller.hpp"

namespace umov::plant {

using Mueller = optics::Mueller<double>;
using Beam = optics::Beam<double>;
using Vec3 = optics::Vec3<double>;

/// A true parameter of a sample at one wavelength, under the name that the model vocabulary gives
/// it.
struct Truth {
  std::string name;  ///< "k_uds", "sigma_um", "dhr" …
  double value = 0.0;
  std::string unit;  ///< "1", "um", "deg", "1/sr"
};

/// A surface, isotropic unless it says otherwise. Beams are given in the sample frame (+z is the
/// true surface normal) with any transverse basis {s, p}; matrices come back in those bases,
/// element (row, column) = (out, in).
class Sample {
 public:
  virtual ~Sample() = default;

  /// Name as in the catalogue, or the file it came from.
  virtual const std::string& name() const = 0;

  /// Mueller BRDF in 1/sr. Zero where either beam is on the wrong side of the surface.
  virtual Mueller brdf(const Beam& in, const Beam& out, double wavelength_nm) const = 0;

  /// Mueller reflectance of the mirror part (no unit): the share of a collimated beam that leaves
  /// exactly in the mirror direction. `out` is a beam along that direction. Zero for diffuse
  /// surfaces.
  virtual Mueller mirror(const Beam& in, const Beam& out, double wavelength_nm) const;

  /// True parameters at one wavelength, empty where the sample is not made from a formula.
  virtual std::vector<Truth> truth(double wavelength_nm) const;

  /// Width in radians of the narrowest feature of brdf() in exit direction; quadratures resolve it.
  virtual double feature_width_rad() const { return 0.5; }

  /// Light emitted at longer wavelengths while `wavelength_nm` shines on the surface, as the BRDF
  /// in 1/sr that would give as much; unpolarised.
  virtual double emission(const Beam& in, const Beam& out, double wavelength_nm) const;

  /// 1-D rms slope of the rough interface and its refractive index; 0 and 1.5 where there is none.
  virtual double slope_rms() const { return 0.0; }
  virtual double surface_index(double wavelength_nm) const;

  /// The same sample with the slopes of its surface multiplied by `factor`; null where it has no
  /// rough interface.
  virtual std::shared_ptr<const Sample> with_slopes(double factor) const;

  /// The same sample under a medium of index `medium_n`, beams given inside it and wavelengths in
  /// vacuum; null where its reflectance does not know an index.
  virtual std::shared_ptr<const Sample> immersed(double medium_n) const;
};

/// Mueller BRDF at angles in degrees in the bases of docs/physics.md, section 1 (signed θr in
/// plane).
Mueller brdf_at(const Sample& sample, double theta_i_deg, double theta_r_deg, double phi_r_deg,
                double wavelength_nm);

/// One true parameter by name. Throws umov::Error listing the names where the sample has no such
/// one.
double truth_value(const Sample& sample, const std::string& name, double wavelength_nm);

/// Directional-hemispherical reflectance of the diffuse part alone and of the mirror part, for
/// unpolarised, s and p incident light.
struct HemisphericalReflectance {
  double unpolarized = 0.0, s = 0.0, p = 0.0;
};

/// DHR by quadrature over the hemisphere (P2), relative accuracy about 1e-5 for the shipped
/// samples; `with_mirror` adds the mirror part.
HemisphericalReflectance dhr(const Sample& sample, double theta_i_deg, double wavelength_nm,
                             bool with_mirror = true);

}  // namespace umov::plant
