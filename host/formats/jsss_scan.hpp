// Reader of the JSSS mid-infrared in-plane goniometer scans and their emissivities.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "host/formats/brdf_table.hpp"

namespace umov::formats {

/// In-plane camera radiance, relative units of a BRDF times cos theta_i at best: the source's
/// irradiance was not recorded.
struct JsssScan {
  std::vector<std::string> material;  ///< one entry a row
  std::vector<double> theta_r_deg, theta_i_deg, radiance_w_m2_sr;
  std::size_t size() const { return material.size(); }
  std::vector<std::string> materials() const;  ///< in order of appearance
};

/// Independently measured directional emissivity; 1 - emissivity is the DHR at that angle.
struct JsssEmissivity {
  std::vector<std::string> material;
  std::vector<double> theta_deg, emissivity, standard_deviation;
  std::size_t size() const { return material.size(); }
};

JsssScan read_jsss_scan(const std::filesystem::path& path);
JsssScan read_jsss_scan(std::istream& in, const std::string& name);
JsssEmissivity read_jsss_emissivity(const std::filesystem::path& path);
JsssEmissivity read_jsss_emissivity(std::istream& in, const std::string& name);

/// One material's scan as unpolarised BRDF points in relative units (key `relative_units: 1`), with
/// DHR = 1 - emissivity where `emissivity` has the material. Throws umov::Error for an unknown one.
BrdfTable to_brdf_table(const JsssScan& scan, const std::string& material,
                        const JsssEmissivity* emissivity);

}  // namespace umov::formats
