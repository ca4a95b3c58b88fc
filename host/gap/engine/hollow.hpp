// Causes that stood in for something that is not constant.
#pragma once

#include <cstddef>
#include <set>

#include <Eigen/Core>

#include "host/gap/engine/refit.hpp"

namespace umov::gap {

/// Effects of a fit, structural ones apart, whose sizes would lie within √`needed` standard errors
/// of their absence if the whitened columns `varying` were fitted beside them, to first order. None
/// where there are no columns.
std::set<std::size_t> not_needed_beside(const ForwardModel& model, const Refit& fit,
                                        const Eigen::MatrixXd& varying, double needed);

}  // namespace umov::gap
