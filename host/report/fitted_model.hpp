// A fitted model ready for evaluation at any geometry, wavelength by wavelength.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "host/brdf/model.hpp"
#include "host/formats/fit_file.hpp"

namespace umov::report {

/// Mueller BRDF row by row, 1/sr.
using MuellerRows = std::array<double, 16>;

class FittedModel {
 public:
  /// `solid_angle_sr` is the detector's, 0 where unknown: then the mirror part of a model is left
  /// out. Throws umov::Error where the fit names an unknown model or lacks parameters.
  FittedModel(const formats::FitResult& fit, double solid_angle_sr);

  /// Degrees; θr may be negative (retro side). `wavelength` counts in the fit's order.
  MuellerRows mueller(std::size_t wavelength, double theta_i_deg, double theta_r_deg,
                      double phi_r_deg) const;
  /// Share of the power that leaves exactly in the mirror direction, 0 … 1, unpolarised light.
  double mirror_reflectance(std::size_t wavelength, double theta_i_deg) const;

 private:
  brdf::Model model_;
  std::vector<double> wavelengths_um_;
  std::vector<std::vector<double>> values_;
  double solid_angle_sr_;
};

/// BRDF between polariser and analyser at these axes (degrees, formats::open_axis = open), 1/sr.
double contracted(const MuellerRows& mueller, double polarizer_deg, double analyzer_deg);
/// (PP − PS)/PU (P4); NaN where nothing is reflected.
double dolp_p4(const MuellerRows& mueller);
/// √(Q² + U²)/I of the light that leaves where P-polarised light comes in: the size of dolp_p4 in
/// the plane of incidence, and independent of the choice of basis outside it.
double linear_polarisation(const MuellerRows& mueller);

}  // namespace umov::report
