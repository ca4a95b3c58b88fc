// True angles of a scan, as a fit of its lobes shows them.
#pragma once

#include "host/calibrate/declared_doubts.hpp"
#include "host/formats/fit_file.hpp"

namespace umov::calibrate {

/// By how much the arms' zeros stood beside the commanded angles, and how sample and standard leant
/// in the plane of incidence (towards +x: a lean adds to θi what it takes from θr), degrees.
struct Alignment {
  double theta_i_zero_deg = 0, theta_r_zero_deg = 0;
  double sample_lean_deg = 0, standard_lean_deg = 0;

  double theta_i_deg() const { return theta_i_zero_deg + sample_lean_deg; }  ///< true - commanded
  double theta_r_deg() const { return theta_r_zero_deg - sample_lean_deg; }
  Alignment& operator+=(const Alignment& more);
};

/// What a fit found for the doubts "incidence zero", "detector zero", "sample lean" and "standard
/// lean" that were declared; zero where they are not in the fit.
Alignment alignment_found(const formats::FitResult& fit, const DeclaredDoubts& declared);

}  // namespace umov::calibrate
