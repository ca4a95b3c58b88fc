// Refractive index tables n(λ), κ(λ) in the YAML form of the refractiveindex.info database.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace umov::optics {

/// Index of one material as a function of vacuum wavelength in µm. Understands the blocks
/// `tabulated nk`, `tabulated n`, `tabulated k` and `formula 1` to `formula 6`; interpolates tables
/// linearly; refuses wavelengths outside the data.
class IndexTable {
 public:
  /// `text` is the file's content, `origin` names it in errors. Throws umov::Error with line on bad
  /// text.
  static IndexTable from_text(std::string_view text, const std::string& origin);
  static IndexTable from_file(const std::string& path);
  /// One of embedded_names(), such as "Ge_Jellison". Throws umov::Error listing the names
  /// otherwise.
  static IndexTable embedded(std::string_view name);
  /// Names of the tables compiled into the program, sorted.
  static std::vector<std::string> embedded_names();

  /// Real part. Throws umov::Error outside the range of the data.
  double n(double wavelength_um) const;
  /// Imaginary part, >= 0; 0 where the file has none (a file with n only). Throws outside its
  /// range.
  double kappa(double wavelength_um) const;
  /// The same as kappa().
  double k(double wavelength_um) const { return kappa(wavelength_um); }

  /// Range in which both n and κ are defined, µm.
  double min_wavelength_um() const { return min_um_; }
  double max_wavelength_um() const { return max_um_; }
  const std::string& origin() const { return origin_; }

 private:
  struct Series {
    std::vector<double> wavelength_um, value;
    double at(double wavelength_um) const;
  };
  void check_range(double wavelength_um) const;

  std::string origin_;
  int formula_ = 0;  ///< 0 = n is tabulated
  std::vector<double> coefficients_;
  Series n_, kappa_;
  double min_um_ = 0.0, max_um_ = 0.0;
};

}  // namespace umov::optics
