// The parts of the page's data, one function a figure or table. Included by .cpp files only.
//
// Numbers for figures are rounded to what a figure can show; numbers for tables are finished text.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "host/report/sample_view.hpp"

namespace umov::report {

using Json = nlohmann::ordered_json;

/// `value` to so many significant digits; null where not finite.
Json rounded(double value, int digits = 5);
Json rounded(std::span<const double> values, int digits = 5);

/// {"id","polarizer","analyzer"} for each.
Json states_json(const std::vector<State>& states);

/// BRDF in the plane of incidence: {log, theta_i_deg, states, curves:[{wavelength_nm, theta_i_deg,
/// state, x, y, u, flagged:{x,y}, model:{x,y}}]}; null where nothing was measured or fitted.
Json brdf_curves(const SampleView& view);
/// DOLP likewise, without states; null where there is none.
Json dolp_curves(const SampleView& view);
/// Where was measured, in direction cosines, for each wavelength and incidence.
Json directions(const SampleView& view);

/// {wavelengths_nm, grids:[{theta_i_deg, theta_deg, phi_deg, brdf:{nm: […]}, dolp:{nm: […]}}]},
/// values θ by θ, φ from 0 to 180°; null without a fit.
Json lobe(const SampleView& view);

/// Normalised residuals of in-plane points and, where directions out of the plane were measured,
/// {prediction}. Each null where it does not apply.
Json residuals(const SampleView& view);
Json prediction(const SampleView& view);

/// Tables of the fit; null without one.
Json fit_tables(const SampleView& view);
/// Measured and fitted reflectances; null where there are none.
Json dhr_table(const SampleView& view);
/// {rows, facts} of the head.
Json key_numbers(const SampleView& view);

Json scan_data(const ScanInput& scan);
Json calibration_data(const CalibrationInput& calibration);
/// [{name, kind, rows:[[key, value]]}] for every file of a sample.
Json provenance(const Sample& sample);

}  // namespace umov::report
