// How surely the parameters of an explanation are known.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/gap/engine/forward_model.hpp"
#include "host/gap/engine/refit.hpp"

namespace umov::gap {

/// A value with its 95 % interval.
struct Interval {
  double value = 0, lo = 0, hi = 0;
};

struct NamedValue {
  std::string name, unit;
  Interval interval;
};

/// A value with its 95 % interval from one standard error, within the parameter's bounds.
NamedValue named_value(const Parameter& parameter, double value, double error);

/// The parameters of the effect that is the `place`-th of a fitted explanation, with 95 % intervals
/// from the fit's curvature. That of the first parameter (structure apart) is better than that
/// where the curvature misleads:
/// - beside a parameter that shapes the effect it is where the profile likelihood, all others
///   fitted anew, has risen by 3.84: a narrow deep shadow and a broad shallow one may fit as well;
/// - where the opposite sign fits as well (a small turn of a polariser acts by its square), it
///   holds that too.
std::vector<NamedValue> effect_parameters(const ForwardModel& model, const Refit& fit,
                                          std::size_t place, const Whitening& whitening);

}  // namespace umov::gap
