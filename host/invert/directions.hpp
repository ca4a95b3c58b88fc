// Predictions in chosen directions: which ones, in what file.
#pragma once

#include <string>
#include <vector>

#include "host/invert/fitted_model.hpp"

namespace umov::invert {

/// One direction of a prediction, angles in degrees.
struct Direction {
  double wavelength_nm = 0, theta_i_deg = 0, theta_r_deg = 0, phi_r_deg = 0;
};
struct DirectionPrediction {
  Direction direction;
  Predicted brdf;  ///< unpolarised light, no analyser
  Predicted dolp;
};
/// In the order of the directions, on `threads` threads (0: all cores). The mirror part, which has
/// no finite BRDF, is not in it.
std::vector<DirectionPrediction> predict_directions(const FittedModel& model,
                                                    const std::vector<Direction>& directions,
                                                    int threads);

/// `in-plane` or `out-of-plane`: a grid at every wavelength and the given incidences (θr −75 … 75
/// by 5; or θr 10 … 70 by 10 at φ 30 … 150 by 30). Throws umov::Error for other text.
std::vector<Direction> direction_grid(const std::string& name,
                                      const std::vector<double>& wavelengths_nm,
                                      const std::vector<double>& theta_i_deg);
/// CSV with the columns theta_i_deg, theta_r_deg, phi_r_deg, and optionally wavelength_nm before
/// them; without it every row is asked for at each of `wavelengths_nm`.
/// Throws umov::Error naming file, line and column.
std::vector<Direction> read_directions(const std::string& path,
                                       const std::vector<double>& wavelengths_nm);
/// CSV: wavelength_nm, theta_i_deg, theta_r_deg, phi_r_deg, brdf_per_sr, brdf_u, brdf_lo, brdf_hi,
/// dolp, dolp_u, dolp_lo, dolp_hi.
std::string directions_csv(const std::vector<DirectionPrediction>& predictions);

}  // namespace umov::invert
