// Patch averages as a BRDF that models, integrals and exports can use.
#pragma once

#include <string>
#include <vector>

#include "host/brdf/table.hpp"
#include "host/formats/klems_matrix.hpp"

namespace umov::formats {

/// Constant over each pair of patches, as the format means its numbers, and averaged over the
/// azimuth of incidence, since the surface is isotropic. Unpolarised.
class KlemsTable final : public brdf::Table {
 public:
  /// Largest anisotropy() that still passes as noise of an isotropic surface.
  static constexpr double largest_anisotropy = 0.1;

  /// `band` is the file's word ("Visible"), `wavelength_um` stands for it (0.555). Throws
  /// umov::Error for a matrix whose size does not fit its bases and for an anisotropic surface.
  KlemsTable(KlemsMatrix matrix, std::string band, double wavelength_um, std::string description);

  optics::Mueller<double> at(double wavelength_um,
                             const brdf::Geometry<double>& geometry) const override;
  const std::vector<double>& wavelengths_um() const override { return wavelengths_um_; }
  bool polarised() const override { return false; }
  std::string description() const override { return description_; }
  brdf::ExitBreaks exit_breaks() const override;

  /// True where a direction's value comes from pairs of a patch with itself: those that hold what
  /// a mirror reflects.
  bool in_mirror_patch(const brdf::Geometry<double>& geometry) const;

  const KlemsMatrix& matrix() const { return matrix_; }
  const std::string& band() const { return band_; }

 private:
  KlemsMatrix matrix_;
  std::string band_;
  std::vector<double> wavelengths_um_;
  std::string description_;
};

}  // namespace umov::formats
