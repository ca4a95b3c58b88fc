// A measured and fitted sample made from a model, for the tests of the report.
#pragma once

#include <string>

#include "host/report/sample.hpp"

namespace umov::report::synthetic {

/// Li–Torrance red gloss paint: 532, 633, 814 nm, θi 30, 45, 60° (and 0° for the DHR), six states,
/// noise of 1 % and a gain factor a wavelength; some points flagged. Fit: the truth with intervals.
Sample red_gloss(const std::string& name = "red gloss");

/// A nearly Lambertian standard measured over the hemisphere at 532 and 633 nm, unpolarised, θi 0,
/// 45, 75°; its model is 2 % low beyond the plane of incidence.
Sample diffuse_standard();

/// The raw scan that belongs to red_gloss(), one record a point.
ScanInput raw_scan();

/// A calibration with an instrument function for three wavelengths.
CalibrationInput calibration();

/// A measurement of one point and a scan without records: what is left when all goes wrong.
Sample nearly_nothing();

}  // namespace umov::report::synthetic
