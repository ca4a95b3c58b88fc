// What the columns of an ASTM text mean, by their names in the line VARS.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace umov::formats::astm {

/// ASCII letters only.
std::string upper(std::string_view text);
std::string lower(std::string_view text);

enum class Role {
  theta_i,
  phi_i,
  theta_s,
  phi_s,
  wavelength,
  pol_i,
  pol_s,
  used,
  value,
  uncertainty,
  ignored
};

struct Column {
  Role role;
  bool times_cosine = false;                 ///< cosine-corrected: BRDF cos θs
  std::optional<double> wavelength_nm = {};  ///< of a spectral column
  std::string name;
  std::optional<std::size_t> uncertainty = {};  ///< column that belongs to this value
};

/// By a name in capitals; none for one that is not known.
std::optional<Column> column_of(const std::string& name);

}  // namespace umov::formats::astm
