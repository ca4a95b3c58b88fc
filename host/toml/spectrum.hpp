// Spectra of scene files: a number, one number a wavelength, a table, a column of a CSV file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace umov {

/// Values over wavelengths in µm, ascending; in between linear.
struct Spectrum {
  std::vector<double> wavelength_um, value;

  /// Throws umov::Error outside the wavelengths. `name` says whose spectrum it is.
  double at(double wavelength, const std::string& name) const;
};

/// A column of a CSV file with a header line and a column `wavelength_um` or `wavelength_nm`;
/// lines that begin with # are notes. Throws umov::Error with file and line, and for a file beyond
/// 8 MiB.
Spectrum read_spectrum(const std::filesystem::path& path, const std::string& column);

/// The same from text; `name` names it in errors.
Spectrum parse_spectrum(const std::string& text, const std::string& name,
                        const std::string& column);

}  // namespace umov
