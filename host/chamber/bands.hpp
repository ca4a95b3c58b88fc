// Wavelengths that a path carries side by side, and how bright they are.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace umov::chamber {

/// Spectra are taken as linear between the bands' wavelengths. Light before the first and beyond
/// the last does not count; a band alone stands for all light. Spectral quantities are W/nm and so
/// on, one number a band.
class Bands {
 public:
  static constexpr std::size_t most = 96;
  /// Wavelengths in µm, rising, within 0.36 to 0.83, at most `most`. Throws umov::Error.
  explicit Bands(std::vector<double> wavelengths_um);

  std::size_t size() const { return wavelengths_um_.size(); }
  const std::vector<double>& wavelengths_um() const { return wavelengths_um_; }

  /// lm of W/nm, cd/m² of W/(m² sr nm): 683 ∫ V(λ) times the spectrum, V the CIE 1924 curve.
  double luminous(std::span<const double> spectral) const;
  /// The same for a single band that is 1: luminous() is linear.
  const std::vector<double>& lumens() const { return lumens_; }

  /// Where means() wants a spectrum, in µm: from the first band to the last every nanometre, or a
  /// quarter of what lies between the closest bands.
  std::vector<double> fine_um() const;
  /// What each band has of a spectrum given at fine_um(): its mean about the band's wavelength,
  /// weighted by V(λ) and by how near it is, so that luminous() is right for lines as well.
  std::vector<double> means(std::span<const double> fine) const;

 private:
  /// Calls visit(band, share) for the bands that a wavelength belongs to.
  template <class Visitor>
  void belongs(double wavelength_um, const Visitor& visit) const;

  std::vector<double> wavelengths_um_, lumens_;
};

}  // namespace umov::chamber
