// The measured points as the fit wants them: by wavelength, then by geometry, so that one
// evaluation of the model serves all polarisation states measured there.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host/formats/brdf_table.hpp"
#include "host/invert/kernel.hpp"

namespace umov::invert {

/// One measured value.
struct Observation {
  std::size_t table_index = 0;  ///< row of BrdfTable::points
  std::size_t row = 0;  ///< number of its scan row: same theta_i, wavelength, phi_r and states
  double brdf_per_sr = 0;
  double sigma = 1;  ///< independent one-sigma uncertainty, floor included
};

/// Points at one geometry: channels[i] belongs to points[i].
struct Site {
  View view;
  std::size_t first = 0, count = 0;  ///< range in Spectrum::points and Spectrum::channels
};

/// A calibration error common to many points. Where it is a relative one (a gain) it must scale the
/// model and not the noisy value: scaled data would prefer every gain that shrinks them.
struct CommonError {
  std::string name;
  bool relative = false;
  std::vector<double>
      per_point;  ///< by point of the Spectrum; 1 or 1/sr for one standard deviation
};

/// All points at one wavelength.
struct Spectrum {
  double wavelength_nm = 0;
  std::vector<Site> sites;
  std::vector<Observation> points;
  std::vector<Channel> channels;
  /// One for each factor of the table, in its order; empty per_point where it has no effect here.
  std::vector<CommonError> common;
};

struct Observations {
  std::vector<Spectrum> spectra;  ///< by ascending wavelength
  std::vector<std::string> factor_names;
  std::size_t rows = 0;
  std::size_t size() const;
  std::vector<double> wavelengths_nm() const;
};

/// Used points only. Throws umov::Error where none is left, where an uncertainty is not positive
/// and where a number is not finite. `floor_relative` is added in quadrature, times |brdf|.
Observations observations(const formats::BrdfTable& table, double floor_relative);

/// What a point is made of, for any point of a table (used or not).
Channel channel_of(double polarizer_deg, double analyzer_deg);
/// `solid_angle_sr` is that of the detector, 0 where unknown: then mirror parts are left out.
View view_of(const formats::BrdfTable::Points& points, std::size_t index, double solid_angle_sr);
/// The header key solid_angle_sr, or 0.
double solid_angle_sr(const formats::BrdfTable& table);

/// Only the points for which `keep(point)`; factors follow.
Observations select(const Observations& all, const std::vector<std::vector<bool>>& keep);

/// At most `per_scan` geometries for each wavelength and incidence, spread evenly along the curve
/// of log BRDF, so that lobes keep their shape; sigma raised by `floor_relative` of the value.
Observations thinned(const Observations& all, std::size_t per_scan, double floor_relative);

}  // namespace umov::invert
