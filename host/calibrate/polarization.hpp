// What a calibration knows of polariser, analyser, detector and source polarisation, per
// wavelength, found from the reflection of a smooth wafer (P7).
//
// Vectors in the {s, p} basis of each beam, α the commanded axis from p towards +s (degrees), ε an
// axis error, e an extinction ratio, n(α) = (-cos 2α, sin 2α) an axis in the plane of (Q, U):
// - source behind the polariser, for light (1, q, u, 0) before it, n = n(α + ε_p), ν = n·(q, u):
//     I = (1 + e_p)/2 + (1 - e_p)/2 ν
//     (Q, U) = [(1 - e_p)/2 + (1 + e_p)/2 ν] n + γ √e_p [(q, u) - ν n]
//   (a dichroic sheet, whose leakage interferes with what it passes; γ = 0: it does not);
// - the monitor stands behind the polariser and answers I + m Q, and what counts is the source per
//   monitor reading, (I, Q, U)/(I + m Q);
// - the detector answers I + δ Q behind the analyser, n = n(α + ε_a):
//     A = ((1 + e_a)/2 + (1 - e_a)/2 δ n_Q,
//          (1 - e_a)/2 n + δ [(1 + e_a)/2 n_Q n + √e_a ((1, 0) - n_Q n)]);
// - open: (1, q, u)/(1 + m q) on the source's side, (1, δ, 0) on the detector's.
// With all errors zero these are the vectors of docs/physics.md, section 1.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/dark.hpp"
#include "host/calibrate/gain_range.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::calibrate {

/// Order of the parameters of one wavelength, in vectors and covariances. Axis errors in degrees.
enum class PolarizationParameter : int {
  polarizer_axis_deg,    ///< ε_p: true axis = commanded + ε, from p of the wafer's plane to +s
  analyzer_axis_deg,     ///< ε_a
  polarizer_extinction,  ///< e_p: power ratio crossed/parallel
  analyzer_extinction,   ///< e_a
  detector_bias,         ///< δ
  monitor_bias,          ///< m
  source_q,              ///< q, u: light before the polariser
  source_u,
  leak_coherence,  ///< γ
};
inline constexpr Eigen::Index polarization_parameters = 9;
using PolarizationVector = Eigen::Matrix<double, polarization_parameters, 1>;
using PolarizationMatrix = Eigen::Matrix<double, polarization_parameters, polarization_parameters>;

constexpr Eigen::Index index_of(PolarizationParameter p) {
  return static_cast<Eigen::Index>(p);
}

/// Words for a parameter, such as "polarizer axis".
std::string name_of(PolarizationParameter p);

/// One wavelength of the result.
struct PolarizationWavelength {
  double wavelength_nm = 0;
  double polarizer_axis_deg = 0, polarizer_axis_u_deg = 0;
  double analyzer_axis_deg = 0, analyzer_axis_u_deg = 0;
  double polarizer_extinction = 0, polarizer_extinction_u = 0;
  double analyzer_extinction = 0, analyzer_extinction_u = 0;
  double detector_bias = 0, detector_bias_u = 0;
  double monitor_bias = 0, monitor_bias_u = 0;
  double source_q = 0, source_q_u = 0, source_u = 0, source_u_u = 0;
  double leak_coherence = 1, leak_coherence_u = 0;
  /// Index of the wafer as seen (an oxide film acts as a shift of both).
  double index_n = 0, index_n_u = 0, index_kappa = 0, index_kappa_u = 0;
  /// Relative scatter of a record beyond the noise of detector and monitor, learned from the
  /// residuals.
  double slow_noise = 0;
  double chi2 = 0, dof = 0;
  std::size_t records = 0, rejected = 0;

  /// Values in the order of PolarizationParameter.
  PolarizationVector values() const;
  void set_values(const PolarizationVector& values);
};

/// Result of a mirror scan. One-sigma uncertainties are the roots of the covariance's diagonal.
struct PolarizationCalibration {
  std::vector<PolarizationWavelength> wavelengths;  ///< ascending
  /// Of all wavelengths together, wavelength by wavelength in the order of PolarizationParameter:
  /// the wafer's tilt couples them. Side: 9 × number of wavelengths.
  Eigen::MatrixXd covariance;
  /// True angle of incidence minus the commanded one (zero error and tilt in plane together).
  double incidence_offset_deg = 0, incidence_offset_u_deg = 0;
  /// Lean of the wafer's normal towards +y, which turns its plane of incidence.
  double tilt_out_of_plane_deg = 0, tilt_out_of_plane_u_deg = 0;
  /// True azimuth of the arm minus the commanded one: it turns the analyser's frame.
  double azimuth_offset_deg = 0, azimuth_offset_u_deg = 0;
  /// Play of the drives: an element that came upwards stands half of it below its axis.
  double polarizer_play_deg = 0, polarizer_play_u_deg = 0;
  double analyzer_play_deg = 0, analyzer_play_u_deg = 0;
  std::string mirror;  ///< name of the sample
  std::string index;   ///< name of the index table
  std::vector<std::string> notes;

  /// Entry within 0.5 nm; nullptr where there is none.
  const PolarizationWavelength* find(double wavelength_nm) const;
  /// Covariance of entry `w`.
  PolarizationMatrix block(std::size_t w) const;
  /// Copies the roots of the covariance's diagonal into the entries' `*_u`.
  void set_uncertainties();
};

struct PolarizationOptions {
  /// Table of the optics library (IndexTable::embedded) or a `.yml` file.
  std::string index = "Ge_Jellison";
  /// Doubt of the wafer's index, one sigma: handbooks differ, and a native oxide acts as a change
  /// of n and, mostly, of κ.
  double n_relative_u = 0.01, kappa_u = 0.06;
  double incidence_offset_u_deg = 0.15;   ///< prior of the zero of incidence and the tilt in plane
  double tilt_out_of_plane_u_deg = 0.15;  ///< prior
  double azimuth_offset_u_deg = 0.1;      ///< prior of the azimuth drive's zero
  double bias_u = 0.05;                   ///< prior of δ and m
  double play_u_deg = 0.03;               ///< prior of both drives' play
  /// Drives stop within this of where they stopped in the mirror scan (gear error), one sigma. It
  /// and half of the play are part of the axes' uncertainty, the same for all wavelengths.
  double position_u_deg = 0.01;
  double range_tolerance = 1e-3;
};

/// Fits polariser, analyser, biases and geometry to a scan of role `mirror`; all wavelengths
/// jointly. The scale at each angle of incidence and block is free, so that footprint and drift do
/// not matter. `dark` and `ranges` complete what the scan itself does not say. Throws umov::Error
/// naming the states that are missing, for a scan of another role, and where no record is usable.
PolarizationCalibration find_polarization(const formats::ScanTable& mirror_scan,
                                          const PolarizationOptions& options = {},
                                          const Dark& dark = {}, const RangeErrors& ranges = {});

/// The true source (I, Q, U) per monitor reading of a polariser commanded to `axis_deg`
/// (formats::open_axis = open).
Eigen::Vector3d source_vector(const PolarizationVector& parameters, double axis_deg);

/// The true answer to (I, Q, U) of the detector behind an analyser at `axis_deg`.
Eigen::Vector3d analyzer_vector(const PolarizationVector& parameters, double axis_deg);

/// The same of ideal elements: (1, -cos 2α, sin 2α), ½ (1, -cos 2α, sin 2α), (1, 0, 0) open.
Eigen::Vector3d ideal_source_vector(double axis_deg);
Eigen::Vector3d ideal_analyzer_vector(double axis_deg);

}  // namespace umov::calibrate
