// Polariser, analyser and photodiodes as Stokes and row vectors in the {s, p} basis of their beam.
#pragma once

#include "hil/plant/sample.hpp"

namespace umov::plant {

using Stokes = optics::Stokes<double>;

/// A polariser or analyser carrier turned to this angle or beyond has its element out of the beam.
inline constexpr double open_from_deg = 195.0;

/// Light of unit power and the given degree of linear polarisation, axis from p towards s.
Stokes source_stokes(double degree, double axis_deg);

/// A dichroic polariser at `axis_deg`: passes 1 along the axis and `extinction` across.
Mueller polarizer_mueller(double axis_deg, double extinction);

/// A linear retarder: fast axis at `axis_deg` from p towards s.
Mueller retarder_mueller(double axis_deg, double retardance_deg);

/// Row vector of a photodiode that answers I + bias·Q.
Stokes photodiode_row(double bias);

/// rowᵀ · m.
Stokes row_times(const Stokes& row, const Mueller& m);

}  // namespace umov::plant
