// A sample given by a table of its BRDF: scalar, or the full Mueller matrix.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hil/plant/sample.hpp"

namespace umov::plant {

/// Interpolates linearly in θi, θr, |φ| and wavelength, constant beyond the first and the last
/// entry.
///
/// CSV: comment lines with '#', then the header
/// `theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,` and either `brdf` or `m00,m01,…,m33` (1/sr,
/// row by row, bases of docs/physics.md section 1). Signed θr in plane is understood. Rows in any
/// order; together they must fill a grid: every combination of the θi, θr, |φ| and wavelengths that
/// occur. The surface has the mirror symmetry of an isotropic one: φ < 0 is the reflection of φ >
/// 0, in which U and V change sign.
class TableSample final : public Sample {
 public:
  /// Throws umov::Error with file, line and column for text that is not such a table, and for grids
  /// with holes or entries given twice.
  static TableSample from_text(std::string_view text, const std::string& origin);
  static TableSample from_file(const std::string& path);

  const std::string& name() const override { return name_; }
  Mueller brdf(const Beam& in, const Beam& out, double wavelength_nm) const override;

 private:
  struct Axis {
    std::vector<double> value;  ///< ascending
    struct Position {
      std::size_t index;
      double fraction;
    };
    Position locate(double x) const;
  };

  std::string name_;
  Axis theta_i_deg_, theta_r_deg_, phi_deg_, wavelength_nm_;
  std::vector<Mueller> grid_;  ///< [θi][θr][φ][wavelength]
};

}  // namespace umov::plant
