// A calibration campaign: all scans of an instrument together, each used for what it says.
//
// Scans find their part by the header key `role`:
//   white   gain, instrument function, radiometric check; reciprocity
//   mirror  axes and extinction of polariser and analyser, polarisation bias (P7)
//   dark    dark signal
//   sample  reciprocity; and, as every other scan, shutter-closed records (dark signal), power
//   steps
//           and range overlap (linearity), records without a sample (stray light)
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/calibrate/calibration.hpp"
#include "host/calibrate/reciprocity.hpp"

namespace umov::calibrate {

/// What campaign.toml says; see docs/calibration.md for its keys.
struct CampaignOptions {
  std::string file;  ///< it came from, for messages; empty = made in memory
  std::vector<std::filesystem::path> scans;
  std::string standard;  ///< name of the white standard that fixes the gain; empty = the first
  int max_degree = 8;
  CalibrateOptions::Bias bias = CalibrateOptions::Bias::automatic;
  LinearityOptions linearity;
  StrayOptions stray;
  DeclaredDoubts declared;
  PolarizationOptions polarization;
  /// Tables of the BRDF of white standards, by the name of the sample.
  std::vector<std::pair<std::string, std::filesystem::path>> reference_brdf;
  std::string reciprocity_scan;  ///< name of the sample that is tested; empty = the standard
  ReciprocityOptions reciprocity;
  /// Find how the standard departs from Lambert's law from its reciprocal pairs, where it has no
  /// table; false = its law is Lambert's, with a doubt.
  bool shape_from_reciprocity = false;
  double reciprocity_target = 0.01;  ///< mean absolute deviation that counts as passed
  /// Name of the standard -> row of the published table it is compared with
  /// (published_reflectance).
  std::vector<std::pair<std::string, std::string>> compare;
};

/// Reads campaign.toml; `scans` may hold patterns with `*` and `?` in the file name, and paths
/// count from the file's folder. Throws umov::Error with file, line and remedy.
CampaignOptions read_campaign(const std::filesystem::path& path);

/// Files that a pattern means, sorted; a path without `*` and `?` is taken as it is. Throws
/// umov::Error where nothing matches.
std::vector<std::filesystem::path> files_of(const std::filesystem::path& pattern);

/// One scan with where it came from.
struct CampaignScan {
  formats::ScanTable table;
  std::string file, name, role, sha256;
};

/// Reads all scans of a campaign and checks that they belong together. Throws umov::Error naming
/// the file: no or unknown `role`, the same file twice, two mirror scans, a dark scan with the
/// shutter open, scans of different instruments, no white standard.
std::vector<CampaignScan> read_campaign_scans(const CampaignOptions& options);

/// The same checks for scans in memory.
void check_campaign_scans(const std::vector<CampaignScan>& scans, const CampaignOptions& options);

/// Result of a campaign. What no scan says stays at its default with the tolerance as uncertainty,
/// and `missing` says so in a sentence each.
struct Campaign {
  Calibration calibration;
  Linearity linearity;
  std::optional<StandardShape> shape;  ///< of the standard, where reciprocity told it
  std::vector<std::string> missing;
};

struct CampaignSteps {
  bool checks = true;                   ///< reflectance of the standards, reciprocity
  std::vector<bool> bias_decided = {};  ///< as in CalibrateOptions
  /// Taken instead of the mirror scan's.
  std::optional<PolarizationCalibration> polarization = std::nullopt;
  /// Shape of the standard that was found before; nullopt = find it.
  std::optional<StandardShape> shape = std::nullopt;
  /// Taken by find_linearity instead of the campaign's own; nullptr = those.
  const std::vector<CampaignScan>* linearity_scans = nullptr;
};

/// Evaluates a campaign. Throws umov::Error where a scan contradicts the standard (wavelengths it
/// was not measured at) or cannot be used.
Campaign evaluate_campaign(const std::vector<CampaignScan>& scans, const CampaignOptions& options,
                           const CampaignSteps& steps = {});

/// What is known of a white scan's standard: a table of the options or of its key `reference_brdf`,
/// else its keys `reference_dhr_<nm>`. Throws umov::Error with the scan's file.
ReferenceStandard campaign_reference(const CampaignScan& scan, const CampaignOptions& options);

/// Number of the white scan that fixes the gain. Throws umov::Error where its name fits none or
/// two.
std::size_t standard_of(const std::vector<CampaignScan>& scans, const CampaignOptions& options);

}  // namespace umov::calibrate
