// Statistics of samplers: counter-based random numbers, and the χ² test of drawn directions against
// a density.
#pragma once

#include <Random123/philox.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/brdf/sampler.hpp"

namespace umov::brdf::statistics {

/// Three uniform numbers in [0, 1), a function of seed and index alone.
inline std::array<double, 3> uniform(std::uint64_t seed, std::uint64_t index) {
  const r123::Philox4x64 generator;
  const auto bits = generator({{index, 0, 0, 0}}, {{seed, 0}});
  constexpr double step = 1.0 / 9007199254740992.0;  // 2^-53
  return {static_cast<double>(bits[0] >> 11) * step, static_cast<double>(bits[1] >> 11) * step,
          static_cast<double>(bits[2] >> 11) * step};
}

using Density = std::function<double(const Geometry<double>&)>;

/// Probability of a χ² at least as large as the one found, if directions follow the density.
struct Fit {
  double p = 0.0;
  double chi2 = 0.0;
  int bins = 0;
  double integral = 0.0;  ///< of the density over the hemisphere
  double nothing = 0.0;   ///< share of draws that gave no sample
};

/// How directions are sorted into bins: over θr and φ with 18 × 16 bins, or in rings about the
/// mirror direction that hold about equally many draws each, with 12 sectors: for lobes too narrow
/// for the former.
enum class Bins { polar, about_mirror };

/// Draws `count` samples and compares their numbers in each bin, and those of mirror samples and of
/// nothing, with what `density` and `mirror_probability` make one expect. Bins that expect fewer
/// than 10 are put together.
Fit chi_square(const Sampler& sampler, const Density& density, double mirror_probability,
               double theta_i, Bins bins, int count, std::uint64_t seed);

}  // namespace umov::brdf::statistics
