// What the base model itself lacks, found before small effects are looked for.
#pragma once

#include <cstddef>
#include <vector>

#include "host/gap/engine/forward_model.hpp"
#include "host/gap/engine/refit.hpp"
#include "host/gap/engine/search.hpp"

namespace umov::gap {

/// Observations that starts and structure are looked for with.
inline constexpr std::size_t most_to_find_the_way = 2400;

/// Takes structural effects in, one at a time, for as long as the best of them takes away what
/// dwarfs the noise: among small effects a search could not see the wood for the trees.
///
/// It stops where a few of the others together are the better explanation: a small effect far out
/// of its usual size is no reason to bend the model. `carrying`: those whose misfit was several
/// times the rest.
Refit with_structure(const ForwardModel& whole, Refit centre, const SearchOptions& options,
                     std::vector<std::size_t>& carrying);

}  // namespace umov::gap
