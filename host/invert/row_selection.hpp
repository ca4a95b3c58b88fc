// Which points of a measurement a model is fitted to, and how well it foretells the others.
#pragma once

#include <string>
#include <vector>

#include "host/formats/brdf_table.hpp"
#include "host/formats/fit_file.hpp"

namespace umov::invert {

/// Keeps a point for the fit. Made from text:
///   in-plane                the exit direction lies in the plane of incidence, within 0.5 degrees
///   COLUMN=A,B,…            the column has one of these values (within 0.01)
///   COLUMN=LO:HI            the column lies in this range
///   COLUMN!=…               the opposite
/// COLUMN is theta_i_deg, theta_r_deg, phi_r_deg or wavelength_nm.
struct RowCondition {
  enum class Column { in_plane, theta_i, theta_r, phi_r, wavelength };
  Column column = Column::in_plane;
  bool negated = false;
  std::vector<double> values;
  bool range = false;  ///< values are {LO, HI}
};

/// Throws umov::Error for text of another form.
RowCondition parse_row_condition(const std::string& text);

/// A copy of the table in which points that fail any condition are not used. Throws umov::Error
/// where no used point is left.
formats::BrdfTable select_rows(const formats::BrdfTable& table,
                               const std::vector<RowCondition>& conditions);

/// Relative error model/measured − 1 over a set of points, by size and with its sign.
struct PredictionError {
  std::string set;  ///< "fitted" or "withheld"
  double wavelength_nm = 0;
  std::size_t points = 0;
  double median_abs = 0;
  double p90_abs = 0;
  double mean = 0;
};

/// Over points that are used in `table`, for each fitted wavelength: those also used in `selected`
/// ("fitted") and the rest ("withheld"). Only points without polariser and analyser enter where
/// there are any, else all.
std::vector<PredictionError> prediction_errors(const formats::FitResult& fit,
                                               const formats::BrdfTable& table,
                                               const formats::BrdfTable& selected);

}  // namespace umov::invert
