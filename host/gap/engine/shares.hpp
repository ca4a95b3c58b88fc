// What each of several effects contributes to what they close together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace umov::gap {

/// Effects of a set, one bit each.
using Subset = std::uint64_t;

/// Shapley's values of `parts` players (at most 63): the mean of what each adds over the orders of
/// taking them in. Over all orders for up to five; for more over the turns of one cyclic order and
/// its reverse, in which each has each place as often: the sum is exact, and parts² subsets do
/// instead of 2^parts.
/// `value_of` must be free of side effects: subsets are computed side by side on `threads` threads
/// (0: all cores).
std::vector<double> shapley_values(std::size_t parts, const std::function<double(Subset)>& value_of,
                                   int threads);

}  // namespace umov::gap
