// What is known beforehand of a white standard: its reflectance, or a table of its own BRDF.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/brdf_table.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::calibrate {

/// A Lambertian standard of stated directional-hemispherical reflectance, or a tabulated one. A
/// real standard is neither Lambertian nor free of polarisation: sintered PTFE at normal incidence
/// falls from 1.06 (5 degrees) to .82 (80 degrees) of 1/pi and keeps some 3 % of linear
/// polarisation.
class ReferenceStandard {
 public:
  /// From the header keys of the white scan: `reference_dhr_<nm>`, `reference_dhr_u` (absolute, one
  /// sigma, default .005) or `reference_dhr_relative_u`, `reference_shape_u` (default .15: relative
  /// amplitude of a departure from Lambert's law that keeps the reflectance, see `shape`),
  /// `reference_retention_u` (default .03: part of the incident linear polarisation that survives),
  /// `reference_polarization_u` (default .01: Q/I that the standard gives to the light by itself).
  /// Throws umov::Error where a wavelength of the scan has no key.
  static ReferenceStandard from_keys(const formats::ScanTable& scan);

  /// From a table of the standard's BRDF; `keys` of the scan give `reference_dhr_relative_u` (scale
  /// of the table) or it is taken from the table's own uncertainties. Points of the states
  /// open/open only mean a depolarising standard. Throws umov::Error for an empty table.
  static ReferenceStandard from_table(const formats::BrdfTable& table,
                                      const formats::ScanTable& scan);

  bool tabulated() const { return table_ != nullptr; }
  /// BRDF in 1/sr seen by polariser and analyser (open_axis = open): half of the total behind an
  /// analyser if the standard depolarises. Tables: interpolation linear in incidence and
  /// wavelength, cubic in the exit angle; nullopt outside.
  std::optional<double> brdf(double theta_i_deg, double theta_r_deg, double phi_r_deg,
                             double wavelength_nm, double polarizer_deg, double analyzer_deg) const;
  /// d ln(f cosθr)/dθr per degree: what a step of the detector does to the standard's signal. Only
  /// the cosine's part at the edges of a table.
  double log_slope_per_deg(double theta_i_deg, double theta_r_deg, double phi_r_deg,
                           double wavelength_nm, double polarizer_deg, double analyzer_deg) const;
  /// Stated reflectance; nullopt where only a table is known.
  std::optional<double> dhr(double wavelength_nm) const;
  /// Relative one-sigma uncertainty of the scale, common to all wavelengths.
  double relative_u(double wavelength_nm) const;
  double shape_u() const { return shape_u_; }
  /// Amplitude of `shape` that the standard is taken to have; 0 = Lambert's law.
  double shape_amplitude() const { return shape_amplitude_; }
  /// Replaces Lambert's law by an amplitude found elsewhere, with its uncertainty. A tabulated
  /// standard stays as it is.
  void set_shape(double amplitude, double u);
  double retention_u() const { return retention_u_; }
  /// One-sigma Q/I of the standard's light; 0 where a polarised table tells it.
  double polarization_u() const { return polarised() ? 0.0 : polarization_u_; }
  /// States of polariser and analyser carry information of their own (a polarised table).
  bool polarised() const;

  /// Departure from Lambert's law of unit amplitude, .3764 - (theta/80 deg)²: its cosine-weighted
  /// mean over the hemisphere is zero. Sintered PTFE is close to an amplitude of .2.
  static double shape(double theta_r_deg);

 private:
  struct Stated {
    double wavelength_nm, dhr, relative_u;
  };
  class Table;
  std::vector<Stated> stated_;
  std::shared_ptr<const Table> table_;
  double table_relative_u_ = 0;
  double shape_amplitude_ = 0;
  double shape_u_ = 0;
  double retention_u_ = 0;
  double polarization_u_ = 0;
};

}  // namespace umov::calibrate
