// The coordinates in which the fit moves: one for each free parameter, chosen so that the model is
// nearly linear in it.
#pragma once

#include <string>

namespace umov::invert {

/// How a parameter p becomes a coordinate x.
enum class Scale {
  linear,       ///< x = p
  logarithmic,  ///< x = ln p: lengths and widths that span decades
  square,       ///< x = p²: the extinction coefficient, in which reflection is even, so that its
                ///< derivative by p vanishes at 0 and a step along p would never leave it
};

/// "linear", "logarithmic", "square".
const char* scale_name(Scale scale);
/// The reverse; linear for other text.
Scale scale_named(const std::string& name);

/// A mapping with limits, in the parameter's unit.
struct Coordinate {
  Scale scale = Scale::linear;
  double lo = 0, hi = 1;

  double to_x(double parameter) const;
  /// Within the limits; `square` stays at 1e-5 or more, where its slope is still finite.
  double to_parameter(double x) const;
  /// dp/dx at x, finite everywhere.
  double slope(double x) const;
  double lo_x() const;
  double hi_x() const;
};

/// The scale that suits a parameter of this name and range.
Scale suitable_scale(const std::string& name, double lo, double hi);

/// Name without the number of the summand: "slope_rms" of "0.slope_rms".
std::string bare_name(const std::string& name);

}  // namespace umov::invert
