// Luminous intensity distributions and their two file formats: IES LM-63 and EULUMDAT.
//
// C is the azimuth of a half plane through the optical axis, γ the angle from the axis (0: along
// it). Only type C photometry is read and written.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace umov::formats {

struct Photometry {
  std::string maker, name, number;
  std::string report;             ///< where the numbers come from: a test's number, "simulated"
  std::vector<double> c_deg;      ///< ascending from 0 to below 360; one alone: the same all around
  std::vector<double> gamma_deg;  ///< ascending within [0, 180]; nothing beyond the ends
  std::vector<double> candela;    ///< [c][gamma]
  /// Of the lamps, for formats that relate to it; 0: absolute photometry.
  double lamp_lm = 0.0;
  double watts = 0.0;
  /// Luminous opening, mm; width 0: circular of diameter `length_mm`.
  double length_mm = 0.0, width_mm = 0.0, height_mm = 0.0;

  /// Bilinear, periodic in C; 0 outside of the range of γ.
  double intensity(double at_c_deg, double at_gamma_deg) const;
  /// Lumens from γ = `from_deg` to `to_deg`: intensities linear in γ and C, sin γ exact.
  double zonal_lm(double from_deg = 0.0, double to_deg = 180.0) const;
};

/// By content. Throws umov::Error with line for a damaged file, types A and B, TILT tables,
/// intensities below 0, angles that do not rise.
Photometry read_photometry(const std::filesystem::path& path);
Photometry parse_photometry(std::string_view text, const std::string& file);
Photometry parse_ies(std::string_view text, const std::string& file);
Photometry parse_eulumdat(std::string_view text, const std::string& file);

/// Does it begin as an intensity distribution of either format does?
bool looks_like_photometry(std::string_view text);

/// LM-63-2002 (absolute photometry where lamp_lm is 0) and EULUMDAT text. The latter relates to
/// 1000 lm where lamp_lm is 0, and refuses more than 721 planes or angles and fewer than two
/// angles. Candela carry seven digits.
std::string ies_text(const Photometry& photometry);
std::string eulumdat_text(const Photometry& photometry);

}  // namespace umov::formats
