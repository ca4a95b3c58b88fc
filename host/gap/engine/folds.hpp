// Withholding whole rows of a measurement.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace umov::gap {

/// Number of the fold, 0 … count - 1, of every observation: rows as a whole, in an order shuffled
/// by `seed`, spread evenly. Fewer folds where there are fewer rows.
std::vector<int> fold_of_observations(const std::vector<int>& row, int count, std::uint64_t seed);

}  // namespace umov::gap
