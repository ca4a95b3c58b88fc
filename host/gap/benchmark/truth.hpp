// What is scored against: the withheld effects of each case, read from a truth file.
//
// The file is read here by itself, not through its maker's code: cases of another generator are
// scored the same way.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace umov::gap::benchmark {

struct TrueEffect {
  std::string name;
  bool enlarged = false;  ///< in a crowd: the one that was made large
  std::vector<std::pair<std::string, double>> parameters;  ///< the principal one first
  double rho = 0;                                          ///< alone
  double rho_given_others = 0;  ///< with the case's other effects refitted
};

struct TrueCase {
  std::string name;
  std::string kind;  ///< none, single, double, triple, foreign, confounded or crowded
  std::vector<TrueEffect> effects;
  double rho = 0;  ///< of all together
  std::vector<std::string> look_alikes;
  std::string family;  ///< of the material
  bool one_gaussian_lobe = true;
  std::string style;  ///< of the plan

  bool has(const std::string& effect) const;
};

/// The cases of a truth file's text. `name` is said in errors. Throws umov::Error where it is none.
std::vector<TrueCase> parse_truth(const std::string& text, const std::string& name);

}  // namespace umov::gap::benchmark
