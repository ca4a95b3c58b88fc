// cal.h5: a calibration in HDF5.
//
// Layout: root attributes format = "umov cal h5", program, command, created, solid_angle_sr,
// shape_u; /wavelengths/{…, one dataset a quantity}, /covariance/{nm_<nm>, ranges} (matrices: in
// the order ln C, instrument-function coefficients, bias; of the amplifier ranges' errors),
// /instrument_function/{degrees_<nm>,coefficients_<nm>}, /systematics/{kind,gain,shift_<nm>},
// /dark, /ranges, where there is a mirror scan /polarization, /mirror and
// /covariance/polarization (9 × wavelengths square, order of PolarizationParameter); /checks,
// /inputs, /header/{key,value}, /notes.
#pragma once

#include <filesystem>

#include "host/calibrate/calibration.hpp"
#include "host/formats/provenance.hpp"

namespace umov::calibrate {

/// Writes beside the target and renames; replaces an existing file.
void write_calibration(const std::filesystem::path& path, const Calibration& calibration,
                       const formats::Provenance& provenance);

/// Throws umov::Error for a file that is missing, corrupt, or no calibration.
Calibration read_calibration(const std::filesystem::path& path);

}  // namespace umov::calibrate
