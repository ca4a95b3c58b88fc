// A sample prepared for drawing: its points sorted by wavelength, incidence and state, its model
// ready.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/report/fitted_model.hpp"
#include "host/report/geometry.hpp"
#include "host/report/sample.hpp"

namespace umov::report {

/// Where a row of points or DOLP values belongs: positions in the lists of the view.
struct Place {
  std::size_t wavelength = 0, theta_i = 0, state = 0;
  bool in_plane = true;
};

struct SampleView {
  const Sample* sample = nullptr;
  const formats::FitResult* fit = nullptr;  ///< null where none
  std::optional<FittedModel> model;

  std::optional<formats::BrdfTable> table;  ///< DOLP filled in where the file had none
  std::vector<double> wavelengths_nm;       ///< measured or fitted, ascending
  std::vector<double> theta_i_deg;          ///< of the measurement; else those of the fitted DHR
  std::vector<State> states;
  std::vector<Place> point_place, dolp_place;
  std::vector<double> total_u;  ///< one sigma of each point, calibration factors included, 1/sr

  /// Position in the fit's wavelengths; nullopt where this one was not fitted.
  std::optional<std::size_t> fitted(std::size_t wavelength) const;
};

/// Throws umov::Error where the fit cannot be evaluated.
SampleView view_of(const Sample& sample);

/// The header key of a measurement; empty where absent.
std::string key_of(const formats::BrdfTable& table, const std::string& name);

}  // namespace umov::report
