// Reflectance models by name: what exists, which parameters each has, sums of them.
//
// A model is a description only. Its value comes from evaluate() (host/brdf/evaluate.hpp), its
// integral from dhr() (host/brdf/dhr.hpp). Formulas and their sources: docs/physics.md.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace umov::brdf {

/// One number of a model, declared once, in host/brdf/catalogue.cpp.
struct Parameter {
  std::string name;  ///< "n"; in a sum "0.n", "1.rho", by position of the part
  std::string unit;  ///< "1", "um", "1/sr", "deg", "rad"
  double min, max;   ///< closed range; also the bounds of a fit
  double initial;    ///< value when none is given
  std::string meaning;
  std::string source;     ///< formula in docs/physics.md, or paper
  bool spectral = false;  ///< a fit over several wavelengths gives it one value per wavelength
  bool held =
      false;  ///< a fit keeps it at its value unless told otherwise (bias: confounded with n)
};

/// A choice between variants of a formula; not a number, never fitted.
struct Choice {
  std::string name;  ///< "shadowing"; in a sum "0.shadowing"
  std::vector<std::string> values;
  std::string value;  ///< the one chosen
  std::string meaning;
};

enum class Kind { lambertian, nef, microfacet, ggx, he_torrance, li_torrance, phong, ward };
enum class Shadowing { none, v_groove, smith, smith_correlated, maxwell_beard };
enum class Slopes { gaussian, exponential };

/// One term of a sum. Its parameters are `count` numbers from `first` on.
struct Component {
  Kind kind = Kind::lambertian;
  Shadowing shadowing = Shadowing::smith;  ///< microfacet and ggx only
  Slopes slopes = Slopes::gaussian;        ///< microfacet only
  std::size_t first = 0;
  std::size_t count = 0;
};

class Model {
 public:
  /// `name` is a model ("microfacet"), a model with choices
  /// ("microfacet:shadowing=vgroove,slopes=exponential") or a sum of them ("microfacet+nef").
  /// Throws umov::Error listing what exists.
  static Model by_name(const std::string& name);
  /// Names of all models, without sums.
  static std::vector<std::string> names();
  /// What a model of names() is, in one sentence.
  static std::string description(std::string_view name);

  /// Canonical name: parts joined by '+', with those choices that differ from their defaults.
  const std::string& name() const { return name_; }
  const std::vector<Parameter>& parameters() const { return parameters_; }
  const std::vector<Choice>& choices() const { return choices_; }
  const std::vector<Component>& components() const { return components_; }

  /// The same model with a choice made ("shadowing", "0.shadowing"). May change which parameters
  /// exist. Throws umov::Error listing what exists.
  Model with_choice(std::string_view choice, std::string_view value) const;
  bool has_choice(std::string_view choice) const;

  /// Position of a parameter. Throws umov::Error listing what exists.
  std::size_t index_of(std::string_view parameter) const;
  /// All initial values, in order.
  std::vector<double> initial_values() const;
  /// Throws umov::Error when the number of values is wrong or one is outside its range (or not a
  /// number).
  void check(std::span<const double> values) const;

 private:
  explicit Model(std::vector<Component> components);

  std::string name_;
  std::vector<Component> components_;
  std::vector<Parameter> parameters_;
  std::vector<Choice> choices_;
};

}  // namespace umov::brdf
