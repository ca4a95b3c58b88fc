// What is known of parameters before the data speak: terms of the objective beside the residuals.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "host/invert/layout.hpp"
#include "host/invert/limited_profile.hpp"

namespace umov::invert {

/// The priors of a fit, bound to its parameters. Each term is one residual whose square joins the
/// objective; an order's term is there only while the order is violated.
class Priors {
 public:
  /// No prior.
  Priors() = default;
  /// Throws umov::Error for unknown or fixed parameters, widths that are not positive, and orders
  /// of a parameter that has not several values.
  Priors(const Layout& layout, const std::vector<Prior>& priors);

  bool empty() const { return terms_.empty(); }
  std::size_t size() const { return terms_.size(); }
  /// Sum of squares at x.
  double objective(std::span<const double> x) const;
  /// Residuals and dr/dx (size() rows, Layout::size() columns). A violated order has its slope, a
  /// kept one neither value nor slope.
  struct Rows {
    Eigen::VectorXd r;
    Eigen::MatrixXd by_x;
  };
  Rows rows(std::span<const double> x) const;

  /// The orders alone, kept and violated ones.
  std::vector<Hinge> hinges(std::span<const double> x) const;
  /// Rows of the normal priors only.
  Rows normal_rows(std::span<const double> x) const;

 private:
  struct Term {
    bool order = false;
    std::size_t free = 0;     ///< normal: the parameter; order: the one that should be small
    std::size_t greater = 0;  ///< order: the one that should be large
    double value = 0, u = 1, ratio = 1;
  };
  double signed_value(const Term& term, std::span<const double> x) const;
  Eigen::RowVectorXd slope(const Term& term, std::span<const double> x) const;

  const Layout* layout_ = nullptr;
  std::vector<Term> terms_;
};

/// From text: `NAME=VALUE±U` (also `+-`), `NAME@NM=VALUE±U`, or `kappa-order`, `kappa-order@NM`,
/// `kappa-order=RATIO`, `kappa-order@NM=RATIO` with NM the wavelength of strong absorption. Throws
/// umov::Error for text of another form.
Prior parse_prior(const std::string& text);

/// "n = 1.5 ± 0.02", "kappa at 532 nm at least 3 times the others".
std::string prior_text(const Prior& prior);

}  // namespace umov::invert
