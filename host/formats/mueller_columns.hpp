// The group /mueller of brdf.h5: its columns declared once, written, read and checked.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "host/formats/brdf_table.hpp"

namespace umov::formats {

class Hdf5Builder;
class Hdf5Reader;

struct MuellerColumn {
  enum class Shape { one, elements, packed };  ///< numbers a direction
  const char* name;
  const char* unit;
  Shape shape = Shape::one;
  bool gaps = false;  ///< NaN stands for an element that is not determined
  std::string path() const { return std::string("/mueller/") + name; }
};

/// Calls visit(column, values) in the order of the file.
template <class Mueller, class Visit>
void for_each_mueller_column(Mueller& m, Visit visit) {
  using Shape = MuellerColumn::Shape;
  visit(MuellerColumn{"theta_i_deg", "deg"}, m.theta_i_deg);
  visit(MuellerColumn{"theta_r_deg", "deg"}, m.theta_r_deg);
  visit(MuellerColumn{"phi_r_deg", "deg"}, m.phi_r_deg);
  visit(MuellerColumn{"wavelength_nm", "nm"}, m.wavelength_nm);
  visit(MuellerColumn{"mueller", "1/sr", Shape::elements, true}, m.mueller);
  visit(MuellerColumn{"mueller_u", "1/sr", Shape::elements, true}, m.mueller_u);
  visit(MuellerColumn{"covariance", "1/sr^2", Shape::packed, true}, m.covariance);
  visit(MuellerColumn{"condition", "1"}, m.condition);
  visit(MuellerColumn{"chi2", "1"}, m.chi2);
  visit(MuellerColumn{"degrees_of_freedom", "1"}, m.dof);
  visit(MuellerColumn{"realisable_z", "1", Shape::one, true}, m.realisable_z);
}

/// Throws umov::Error naming file `name` and column for a wrong length or a number that is not
/// finite (gaps excepted).
void check_mueller(const BrdfTable::Mueller& mueller, const std::string& name);

void write_mueller(Hdf5Builder& file, const BrdfTable::Mueller& mueller);

/// nullopt where the file has no such group.
std::optional<BrdfTable::Mueller> read_mueller(const Hdf5Reader& file);

/// Mueller elements as CSV: comment lines, then a row a direction with theta_i_deg, theta_r_deg,
/// phi_r_deg, wavelength_nm, m00 …, m00_u …, condition, chi2, degrees_of_freedom, realisable_z;
/// empty cells where an element is not determined.
std::string mueller_csv_text(const BrdfTable& table);

}  // namespace umov::formats
