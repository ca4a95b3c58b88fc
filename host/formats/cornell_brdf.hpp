// The text form in which the Cornell gonioreflectometer's paint measurements are distributed
// (`.brdf`): spectra at single directions, unpolarised. docs/formats/cornell-brdf.md.
//
//   # comment lines; the first ones name the sample
//   31                                   number of wavelengths
//   400 410 … 700                        nm, over one or more lines
//   0.872665 0 0.573513 0 0.023 0.013 …  theta_i phi_i theta_s phi_s in radians, then 1/sr
#pragma once

#include <string>
#include <string_view>

#include "host/formats/brdf_table.hpp"

namespace umov::formats {

bool is_cornell_brdf(std::string_view bytes);

/// Points with polariser and analyser open, φ = 0 forward (the file's specular direction is
/// phi_s - phi_i = 180 deg). The file states no uncertainties; each point gets 2.5 % (the
/// reciprocity scatter of these data) and a floor c/cos θi, c by wavelength from the values that
/// noise drove to zero. Zeros are kept with used = 0. Throws umov::Error with the line for angles
/// out of range, values that are negative or no numbers, incomplete records and repeated
/// directions.
BrdfTable read_cornell_brdf(std::string_view bytes, const std::string& file);

}  // namespace umov::formats
