// How far a table is off another: what a format's own grid and interpolation cost.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "host/brdf/table.hpp"

namespace umov::formats {

/// Relative differences of m00 over directions with θi and θr up to `most_deg`: half of them
/// anywhere, half within 20 degrees of the mirror direction. Values below 1e-4 of the largest at
/// their wavelength count as that much.
struct TableDifference {
  static constexpr double most_deg = 80.0;
  std::size_t directions = 0;
  double median = 0.0, p95 = 0.0, worst = 0.0;
  /// "differs from its source by 0.12 % (median), 1.3 % (95 % of 2000 directions), …".
  std::string sentence(std::string_view from = "its source") const;
};

/// The directions are the same at every call. Wavelengths are not empty; those of the reference
/// belong to the table's one by one and are the same where none are given (channels of a format
/// without wavelengths stand elsewhere than what was written to them). Directions that `left_out`
/// tells are not compared.
TableDifference compare_tables(
    const brdf::Table& table, const brdf::Table& reference,
    const std::vector<double>& wavelengths_um,
    const std::vector<double>& reference_wavelengths_um = {},
    const std::function<bool(const brdf::Geometry<double>&)>& left_out = {});

/// Directional-hemispherical reflectances of unpolarised light, in which a lost or widened peak
/// shows that few directions see.
struct ReflectanceDifference {
  static constexpr std::array<double, 3> theta_i_deg{10.0, 45.0, 70.0};
  std::array<double, 3> found{}, expected{};
  double largest() const;  ///< |found - expected|
  /// "DHR at 10, 45, 70 deg: .5001, .5102, .5401; of the source: .5000, …".
  std::string sentence(std::string_view whose = "the source") const;
};

/// Each table at a wavelength of its own. `mirror_taken`: the table holds what a ModelTable as
/// reference reflects exactly in the mirror direction; KlemsMeans as reference always count it, and
/// are means over the ring of incidence. Integrals are good to some 1e-4.
ReflectanceDifference compare_reflectances(const brdf::Table& table, double wavelength_um,
                                           const brdf::Table& reference,
                                           double reference_wavelength_um, bool mirror_taken);

}  // namespace umov::formats
