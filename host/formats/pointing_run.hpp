// Pointing runs of a telescope in the MMT Observatory's text form: where the encoders stood, and
// where the star was.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace umov::formats {

/// One entry a star. Altitudes from the horizon; azimuths as the source gives them (from north
/// through east, with a constant offset between encoder and sky).
struct PointingRun {
  std::vector<double> encoder_altitude_deg, encoder_azimuth_deg;  ///< RAA
  std::vector<double> true_altitude_deg, true_azimuth_deg;        ///< TAA
  std::size_t size() const { return encoder_altitude_deg.size(); }
};

/// Reads lines `RAA: altitude azimuth` and `TAA: altitude azimuth`, in that order for each star;
/// other lines are passed over. Throws umov::Error with file and line for numbers that are none,
/// altitudes outside 0 to 90 deg and a star that lacks one of the two.
PointingRun read_pointing_run(const std::filesystem::path& path);
PointingRun parse_pointing_run(std::string_view text, const std::string& name);

}  // namespace umov::formats
