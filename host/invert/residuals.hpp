// Normalised residuals (P12 and its noise-weighted sibling) with their exact derivatives.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "host/invert/layout.hpp"
#include "host/invert/observations.hpp"

namespace umov::invert {

/// How a deviation is weighed.
struct Weighting {
  bool relative = false;   ///< (P12): divide by the measured value instead of its uncertainty
  double scale = 1;        ///< uncertainties are multiplied by this
  double huber_sigma = 0;  ///< beyond this many (scaled) sigma a residual counts linearly; 0: never
};

/// Residuals r = (f · (1 + Σ c_k φ_k) + Σ c_k F_k − y)/u of one wavelength, in the order of its
/// points. Where asked for, dr/dx by the free parameters active at that wavelength (columns in the
/// order of Layout::active) and dr/dc by the factors. `x` has Layout::size() entries, `c` one a
/// factor.
struct SpectrumResiduals {
  Eigen::VectorXd r;
  Eigen::MatrixXd by_x;
  Eigen::MatrixXd by_c;
};
SpectrumResiduals residuals(const Layout& layout, const Observations& data, std::size_t wavelength,
                            std::span<const double> x, std::span<const double> c,
                            const Weighting& weighting, bool derivatives);

/// All wavelengths, one below the other; columns by free parameter.
struct Linearisation {
  Eigen::VectorXd r;
  Eigen::MatrixXd by_x;
  Eigen::MatrixXd by_c;
};
Linearisation linearise(const Layout& layout, const Observations& data, std::span<const double> x,
                        std::span<const double> c, const Weighting& weighting);

/// Square root of Huber's loss with the residual's sign, so that its square is the loss; `slope` is
/// its derivative. The identity for |r| <= k, and for k = 0.
double huber_root(double r, double k, double& slope);

/// Residual scale by Huber's second proposal: the s with mean(min(r²/s², k²)) · n/dof = 1. Up to
/// about one point in k² far off is told from the rest; more of them mean a model that does not
/// fit, and then s grows until they count as ordinary.
double residual_scale(const Eigen::VectorXd& r, double k, std::size_t free_parameters);

}  // namespace umov::invert
