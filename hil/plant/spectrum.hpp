// A quantity over wavelength, as a sample file gives it.
#pragma once

#include <vector>

namespace umov::plant {

/// Linear between nodes, constant beyond the first and the last.
class Spectrum {
 public:
  Spectrum() = default;
  /// The same value everywhere.
  explicit Spectrum(double value) : wavelength_nm_{0.0}, value_{value} {}
  /// `wavelength_nm` ascending, same length as `value`, not empty.
  Spectrum(std::vector<double> wavelength_nm, std::vector<double> value)
      : wavelength_nm_(std::move(wavelength_nm)), value_(std::move(value)) {}

  double at(double wavelength_nm) const;
  /// Every value times `factor`.
  Spectrum scaled(double factor) const;

 private:
  std::vector<double> wavelength_nm_{0.0};
  std::vector<double> value_{0.0};
};

}  // namespace umov::plant
