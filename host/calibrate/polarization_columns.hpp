// The columns of a polarisation calibration in cal.h5, declared once for the writer and the reader.
#pragma once

#include "host/calibrate/polarization.hpp"

namespace umov::calibrate {

/// Calls visit(name, unit, member) for every number of a wavelength; `records` and `rejected` are
/// beside them. The `*_u` of the nine parameters are the roots of the covariance's diagonal.
template <class Visit>
void for_each_polarization_column(Visit visit) {
  using W = PolarizationWavelength;
  visit("wavelength_nm", "nm", &W::wavelength_nm);
  visit("polarizer_axis_deg", "deg", &W::polarizer_axis_deg);
  visit("polarizer_axis_u_deg", "deg", &W::polarizer_axis_u_deg);
  visit("analyzer_axis_deg", "deg", &W::analyzer_axis_deg);
  visit("analyzer_axis_u_deg", "deg", &W::analyzer_axis_u_deg);
  visit("polarizer_extinction", "1", &W::polarizer_extinction);
  visit("polarizer_extinction_u", "1", &W::polarizer_extinction_u);
  visit("analyzer_extinction", "1", &W::analyzer_extinction);
  visit("analyzer_extinction_u", "1", &W::analyzer_extinction_u);
  visit("detector_bias", "1", &W::detector_bias);
  visit("detector_bias_u", "1", &W::detector_bias_u);
  visit("monitor_bias", "1", &W::monitor_bias);
  visit("monitor_bias_u", "1", &W::monitor_bias_u);
  visit("source_q", "1", &W::source_q);
  visit("source_q_u", "1", &W::source_q_u);
  visit("source_u", "1", &W::source_u);
  visit("source_u_u", "1", &W::source_u_u);
  visit("leak_coherence", "1", &W::leak_coherence);
  visit("leak_coherence_u", "1", &W::leak_coherence_u);
  visit("index_n", "1", &W::index_n);
  visit("index_n_u", "1", &W::index_n_u);
  visit("index_kappa", "1", &W::index_kappa);
  visit("index_kappa_u", "1", &W::index_kappa_u);
  visit("slow_noise", "1", &W::slow_noise);
  visit("chi2", "1", &W::chi2);
  visit("degrees_of_freedom", "1", &W::dof);
}

/// The numbers that all wavelengths share, degrees.
template <class Visit>
void for_each_mirror_geometry(Visit visit) {
  using P = PolarizationCalibration;
  visit("incidence_offset_deg", &P::incidence_offset_deg);
  visit("incidence_offset_u_deg", &P::incidence_offset_u_deg);
  visit("tilt_out_of_plane_deg", &P::tilt_out_of_plane_deg);
  visit("tilt_out_of_plane_u_deg", &P::tilt_out_of_plane_u_deg);
  visit("azimuth_offset_deg", &P::azimuth_offset_deg);
  visit("azimuth_offset_u_deg", &P::azimuth_offset_u_deg);
  visit("polarizer_play_deg", &P::polarizer_play_deg);
  visit("polarizer_play_u_deg", &P::polarizer_play_u_deg);
  visit("analyzer_play_deg", &P::analyzer_play_deg);
  visit("analyzer_play_u_deg", &P::analyzer_play_u_deg);
}

}  // namespace umov::calibrate
