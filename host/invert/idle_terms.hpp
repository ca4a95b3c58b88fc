// Terms that an optimum does without: are they idle in every shape, or only in the one they have?
#pragma once

#include <cstddef>
#include <vector>

#include "host/invert/minimise.hpp"

namespace umov::invert {

/// A linear weight of the model and the shape parameters that mean nothing without it, such as k_fs
/// with the width and polarisation of its lobe. By index in the model's list.
struct Term {
  std::size_t weight = 0;
  std::vector<std::size_t> shapes;
};

/// Found by comparing derivatives with the weight at nought and above, so it holds for any model.
std::vector<Term> terms_with_shapes(const Layout& layout, const Observations& data,
                                    const std::vector<bool>& linear);

/// Where a term's weight is nought, or so small that the data hardly ask for it, the objective has
/// no slope towards another shape, and one local optimum for every bump of the noise. So each such
/// term is offered a grid of its shapes; a quadratic in everything else foretells the gain, and the
/// most promising shapes are followed to their optimum. The best solution is returned.
Solution with_idle_terms_offered(const Problem& problem, const std::vector<bool>& linear,
                                 const std::vector<Term>& terms, Solution found, const Stop& stop);

}  // namespace umov::invert
