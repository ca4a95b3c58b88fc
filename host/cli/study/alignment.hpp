// True angles of a scan, as its lobes show them.
#pragma once

#include "host/formats/brdf_table.hpp"
#include "host/formats/fit_file.hpp"

namespace umov::study {

/// Angles by which the arms stood beside where they were commanded, zeros and the sample's lean
/// together, degrees: true = commanded + offset.
struct Alignment {
  double theta_i_deg = 0, theta_r_deg = 0;
};

/// What a fit found for the calibration's doubts "incidence zero" and "detector zero", of which one
/// standard deviation was declared as `theta_i_u_deg` and `theta_r_u_deg`. Zero where they are not
/// in the fit.
Alignment alignment_found(const formats::FitResult& fit, double theta_i_u_deg,
                          double theta_r_u_deg);

/// The points at their true angles, reduced with the true cosine. The doubts themselves enter a fit
/// by derivatives alone, which is too little for a lobe that is shifted by a tenth of a degree:
/// this leaves to them what is left. In-plane points only; others stay as they are.
formats::BrdfTable aligned(formats::BrdfTable table, const Alignment& alignment);

}  // namespace umov::study
