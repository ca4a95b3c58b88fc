// A BRDF known as numbers: what the model `tabulated` evaluates. Readers of files (host/formats)
// make tables; each keeps the sampling of its source and interpolates in it, so that writing the
// same format again gives the same numbers.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/brdf/facet.hpp"
#include "host/optics/mueller.hpp"

namespace umov::brdf {

/// Exit angles and azimuths, in radians and ascending, between whose neighbours a table is smooth.
struct ExitBreaks {
  std::vector<double> theta_r;  ///< from 0 to π/2
  std::vector<double> phi_r;    ///< the full circle, from some azimuth to the same plus 2π
};

/// Isotropic BRDF from stored values. Implementations are immutable and safe to share by threads.
class Table {
 public:
  virtual ~Table() = default;
  /// Mueller BRDF in 1/sr, conventions of host/brdf/evaluate.hpp; an unpolarised table fills m00
  /// only (a depolarising surface). 0 at or below the horizon. Between stored directions it
  /// interpolates, beyond the outermost ones it keeps the nearest value; wavelengths likewise.
  virtual optics::Mueller<double> at(double wavelength_um,
                                     const Geometry<double>& geometry) const = 0;
  /// Stored wavelengths, ascending, micrometres; never empty. Colour channels of formats without
  /// wavelengths stand at the wavelengths that the reader's documentation names.
  virtual const std::vector<double>& wavelengths_um() const = 0;
  /// More than m00 is known.
  virtual bool polarised() const = 0;
  /// What it is and where it came from, one sentence ("MERL 90 x 90 x 180, file x.binary").
  virtual std::string description() const = 0;
  /// For tables sampled in θr and φ: lets dhr() integrate exactly what is interpolated. Empty
  /// otherwise; dhr() then refines until its estimate settles.
  virtual ExitBreaks exit_breaks() const { return {}; }
};

}  // namespace umov::brdf
