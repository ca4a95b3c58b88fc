#include "host/formats/astm_columns.hpp"

#include <cctype>
#include <map>

#include "host/formats/decimal.hpp"

namespace umov::formats::astm {

std::string upper(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return out;
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

namespace {

/// "632.8NM" -> 632.8
std::optional<double> wavelength_in(std::string_view name) {
  double value = 0;
  if (name.ends_with("NM") && !read_decimal(name.substr(0, name.size() - 2), value)) return value;
  return std::nullopt;
}

}  // namespace

std::optional<Column> column_of(const std::string& name) {
  static const std::map<std::string, Role> plain{{"THETA_I", Role::theta_i},
                                                 {"PHI_I", Role::phi_i},
                                                 {"THETA_S", Role::theta_s},
                                                 {"THETA_R", Role::theta_s},
                                                 {"PHI_S", Role::phi_s},
                                                 {"PHI_R", Role::phi_s},
                                                 {"WAVELENGTH_NM", Role::wavelength},
                                                 {"POL_I", Role::pol_i},
                                                 {"POL_S", Role::pol_s},
                                                 {"USED", Role::used},
                                                 {"BRDF", Role::value},
                                                 {"BSDF", Role::value},
                                                 {"BRDF_U", Role::uncertainty},
                                                 {"BSDF_U", Role::uncertainty}};
  if (const auto found = plain.find(name); found != plain.end())
    return Column{found->second, false, {}, name};
  if (name == "CCBRDF" || name == "CCBSDF") return Column{Role::value, true, {}, name};
  if (name == "CCBRDF_U" || name == "CCBSDF_U") return Column{Role::uncertainty, true, {}, name};
  if (auto nm = wavelength_in(name)) return Column{Role::value, false, nm, name};
  if (name.starts_with("U_"))
    if (auto nm = wavelength_in(std::string_view(name).substr(2)))
      return Column{Role::uncertainty, false, nm, name};
  return std::nullopt;
}

}  // namespace umov::formats::astm
