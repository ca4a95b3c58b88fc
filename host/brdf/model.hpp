// Reflectance models by name: what exists, which parameters each has, sums of them.
//
// A model is a description only. Its value comes from evaluate() (host/brdf/evaluate.hpp), its
// integral from dhr() (host/brdf/dhr.hpp). Formulas and their sources: docs/physics.md.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace umov::brdf {

class Table;  // host/brdf/table.hpp

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

/// A place of a model that takes a table of values instead of a number: the file of `tabulated`.
struct TableSlot {
  std::string name;      ///< "file"; in a sum "0.file"
  std::size_t part = 0;  ///< position in the sum
  bool filled = false;   ///< with_table() has been called
};

enum class Kind {
  lambertian,
  nef,
  microfacet,
  ggx,
  he_torrance,
  li_torrance,
  rayleigh_rice,
  beard_maxwell,
  subsurface,
  single_scatter,
  phong,
  ward,
  tabulated
};
enum class Shadowing { none, v_groove, smith, smith_correlated, maxwell_beard };
enum class Slopes {
  gaussian,
  exponential,
  angle  ///< Gaussian in the facet's angle, not its tangent; beard-maxwell only
};
enum class Psd { gaussian, abc };

/// A name under which users look for a model that exists under another.
struct Alias {
  std::string name;     ///< "torrance-sparrow"
  std::string model;    ///< "microfacet:shadowing=vgroove"
  std::string meaning;  ///< one sentence
};

/// One term of a sum. Its parameters are `count` numbers from `first` on.
struct Component {
  Kind kind = Kind::lambertian;
  Shadowing shadowing = Shadowing::smith;  ///< microfacet, ggx, beard-maxwell
  Slopes slopes = Slopes::gaussian;        ///< microfacet, beard-maxwell
  Psd psd = Psd::gaussian;                 ///< rayleigh-rice only
  std::shared_ptr<const Table> table;      ///< tabulated only; null until with_table()
  std::size_t first = 0;
  std::size_t count = 0;
};

class Model {
 public:
  /// `name` is a model ("microfacet"), a model with choices
  /// ("microfacet:shadowing=vgroove,slopes=exponential"), an alias ("torrance-sparrow") or a sum of
  /// them ("microfacet+nef").
  /// Throws umov::Error listing what exists.
  static Model by_name(const std::string& name);
  /// Names of all models, without sums.
  static std::vector<std::string> names();
  /// Further names that by_name() takes, alone or as parts of sums, with choices or without.
  static std::vector<Alias> aliases();
  /// What a model of names() is, in one sentence.
  static std::string description(std::string_view name);
  /// Where a model of names() has its formula: numbers in docs/physics.md, and the paper.
  static std::string formula(std::string_view name);
  /// How a model of names() stands to energy conservation and reciprocity, and where it fails.
  static std::string remarks(std::string_view name);

  /// Canonical name: parts joined by '+', with those choices that differ from their defaults.
  const std::string& name() const { return name_; }
  const std::vector<Parameter>& parameters() const { return parameters_; }
  const std::vector<Choice>& choices() const { return choices_; }
  const std::vector<Component>& components() const { return components_; }

  /// The same model with a choice made ("shadowing", "0.shadowing"). May change which parameters
  /// exist. Throws umov::Error listing what exists.
  Model with_choice(std::string_view choice, std::string_view value) const;
  bool has_choice(std::string_view choice) const;

  /// Where tables belong; empty for models that are formulas.
  const std::vector<TableSlot>& table_slots() const { return table_slots_; }
  /// A slot is still empty: evaluate() and dhr() would throw.
  bool needs_table() const;
  /// The same model with the values of its part number `part` (readers of files make them:
  /// formats::read_table). Throws umov::Error when that part takes no table or `table` is null.
  Model with_table(std::shared_ptr<const Table> table, std::size_t part = 0) const;

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
  std::vector<TableSlot> table_slots_;
};

/// Throws the umov::Error of a tabulated model that was given no table.
[[noreturn]] void refuse_missing_table(const Model& model);

}  // namespace umov::brdf
