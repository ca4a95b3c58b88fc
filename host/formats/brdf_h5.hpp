// brdf.h5: a reduced measurement in HDF5 with units, provenance and a checksum.
//
// Layout: /points/{theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,polarizer_deg,analyzer_deg,
// brdf_per_sr,brdf_u,used}, /dolp/{theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,dolp,dolp_u},
// /dhr/{wavelength_nm,theta_i_deg,dhr,dhr_u}, /covariance/{name,per_point[factor,point]} where
// calibration couples points, /mueller/{theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,
// mueller[direction,9 or 16],mueller_u[…],covariance[direction,45 or 136] (upper triangle row by
// row; may be absent),condition,chi2,degrees_of_freedom,realisable_z} where Mueller elements are
// known, /header/{key,value}; root attributes as in scan.h5.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "host/formats/brdf_table.hpp"
#include "host/formats/provenance.hpp"

namespace umov::formats {

class Hdf5Builder;

struct BrdfFile {
  BrdfTable table;
  Provenance provenance;
  std::string content_sha256;  ///< of the table, 64 hexadecimal digits
};

/// Reads and verifies the checksum. Throws umov::Error for a file that is missing, truncated,
/// corrupt or foreign.
BrdfFile read_brdf_h5(const std::filesystem::path& path);

/// `more` may add groups of its own, which the content's checksum does not cover (the file's does).
/// Writes beside the target and renames. Replaces an existing file. Throws umov::Error for columns
/// of unequal length and for numbers that are not finite (open axes excepted).
void write_brdf_h5(const std::filesystem::path& path, const BrdfTable& table,
                   const Provenance& provenance,
                   const std::function<void(Hdf5Builder&)>& more = {});

/// SHA-256 of keys and columns, independent of the file that holds them.
std::string content_sha256(const BrdfTable& table);

}  // namespace umov::formats
