// Models with their parameters as users of SCATMECH and MIST write them: the class on a line of its
// own, then `name = value`, parameters of parameters with dots. What maps to what, and what does
// not: docs/formats/scatmech.md.
//
//   Shadowed_Facet_BRDF_Model
//   lambda = 0.6328
//   substrate = (1.5,0)
//   sdf = Gaussian_Slope_Distribution_Function
//   sdf.s = 0.2
//   shadow = Torrance_Sparrow_Shadow_Function
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/brdf/model.hpp"
#include "host/formats/table_file.hpp"

namespace umov::formats {

struct ScatmechModel {
  brdf::Model model;
  std::vector<double> values;  ///< in the model's order
  double wavelength_um;
  /// "name = value" of parameters that the file leaves out, in the order in which they were needed.
  std::vector<std::string> defaults;
};

/// Parameters left out have SCATMECH's own defaults. The last line needs its line end. Throws
/// umov::Error with line and parameter for classes and values without an exact counterpart here,
/// unknown or repeated parameters, and text that is none of this.
ScatmechModel parse_scatmech(std::string_view text, const std::string& file);

/// `comments` go to the top, one line each. Throws umov::Error for models, choices and values
/// without an exact counterpart, naming those that have one.
std::string scatmech_text(const brdf::Model& model, std::span<const double> values,
                          double wavelength_um, std::span<const std::string> comments);

/// For the list of table formats. Only a ModelTable can be written.
bool is_scatmech(std::string_view bytes);
TablePtr read_scatmech(std::string_view bytes, const std::string& file);
std::string write_scatmech(const brdf::Table& table, const TableWriting& writing);

}  // namespace umov::formats
