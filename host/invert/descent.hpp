// One descent from one start, however far from the optimum that is.
#pragma once

#include <cstddef>
#include <vector>

#include "host/invert/idle_terms.hpp"
#include "host/invert/minimise.hpp"

namespace umov::invert {

/// Descents to the least objective from any point within the limits. A descent sees its own start
/// only, and keeps one point that it improves by
///   1. line searches: one shape parameter at a time (and the two lengths of a rough surface
///      together) over its whole range, the linear coefficients solved for at every trial; a narrow
///      lobe at a wrong width has no slope that a gradient could follow, but such a line finds it;
///   2. bounded Levenberg-Marquardt with the linear coefficients eliminated;
/// both on few points and with the model let off by 30 %, then 5 % of the BRDF (a blur in value:
/// the objective is smooth long before it is sharp), and at last on all points with their own
/// noise. In the end a term whose weight is nought is offered all its shapes again.
class Descent {
 public:
  /// `weighting` is that of the last stage. Refers to its arguments; they must outlive it.
  explicit Descent(const Problem& problem);

  Solution from(std::vector<double> x) const;

  /// The descent proper, for starts in the right basin: Levenberg-Marquardt on few points, then on
  /// all of them until `stop`. No line searches, no idle terms.
  Solution from_near(std::vector<double> x, std::vector<double> c, Stop stop) const;

  /// The line searches alone, on few points with 5 % let off; true where one of them gained.
  bool search_lines(std::vector<double>& x) const;

  const std::vector<bool>& linear() const { return linear_; }
  const std::vector<Term>& terms() const { return terms_; }

 private:
  /// Coordinates that move together, and the wavelengths that see them.
  struct Line {
    std::vector<std::size_t> members;
    std::vector<std::size_t> wavelengths;
    std::vector<double> values;  ///< trial coordinates; of several members, trial shifts
  };
  /// Linear coefficients of wavelength w at their best within the limits, in x; returns Σ r² there.
  double solve_linear(const Observations& data, std::size_t w, std::vector<double>& x) const;
  /// One line search along every shape parameter; true where one of them gained.
  bool sweep(const Observations& data, std::vector<double>& x) const;

  Problem problem_;
  std::vector<bool> linear_;
  std::vector<Term> terms_;
  std::vector<Observations> blurred_;
  Observations few_;
  std::vector<Line> lines_;
};

}  // namespace umov::invert
