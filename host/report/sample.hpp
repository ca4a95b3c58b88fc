// What one part of a report is about: a measured sample with its fit, scans and calibration.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/brdf_h5.hpp"
#include "host/formats/fit_file.hpp"
#include "host/formats/scan_h5.hpp"

namespace umov::calibrate {
struct Calibration;
}

namespace umov::report {

/// Name and digest of a file as given.
struct Source {
  std::string name;    ///< file name without folders
  std::string sha256;  ///< of the file's bytes, 64 hexadecimal digits
};

struct BrdfInput {
  Source source;
  formats::BrdfFile file;
};

struct FitInput {
  Source source;
  formats::FitResult fit;
};

struct ScanInput {
  Source source;
  formats::ScanFile file;
};

struct CalibrationInput {
  Source source;
  std::shared_ptr<const calibrate::Calibration> calibration;
};

/// One section of the page. Every part may be absent.
struct Sample {
  std::string name;
  std::optional<BrdfInput> brdf;
  std::optional<FitInput> fit;
  std::optional<CalibrationInput> calibration;
  std::vector<ScanInput> scans;
  std::vector<std::string> warnings;  ///< sentences shown at its head
};

}  // namespace umov::report
