// The goniophotometer: luminous intensity distribution of a luminaire by rays from its sources.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/chamber/tracer.hpp"
#include "host/formats/photometry.hpp"
#include "host/parallel/team.hpp"

namespace umov::chamber {

/// C is counted from +x to +y, γ from +z. Each direction stands for the cell that reaches half way
/// to its neighbours; at the poles the cell is a cap and all planes share it.
struct Distribution {
  std::vector<double> c_deg;                       ///< equally spaced from 0
  std::vector<double> gamma_deg;                   ///< equally spaced from 0 to 180
  std::vector<double> intensity_cd, intensity_se;  ///< [c][gamma]
  double source_lm = 0.0, out_lm = 0.0, out_se = 0.0;
  double first_hit_fraction = 0.0;  ///< met a face that is not black before anything else
  double absorbed_fraction = 0.0, behind_fraction = 0.0, lost_fraction = 0.0;
  std::uint64_t rays_launched = 0;
  Fate fate;                           ///< sums over all launches
  std::vector<double> wavelengths_um;  ///< of fate.spectrum_out, in a luminaire with bands

  double efficiency() const { return out_lm / source_lm; }
  double intensity(std::size_t c, std::size_t gamma) const {
    return intensity_cd[c * gamma_deg.size() + gamma];
  }
  /// For the writers of photometric files.
  formats::Photometry photometry() const;
};

struct DistributionRequest {
  std::uint64_t rays = 2'000'000;
  std::size_t planes = 24;  ///< of C over 360°
  std::size_t angles = 37;  ///< of γ from 0 to 180°
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: all cores; the result does not depend on it
  std::function<void(double)> progress = {};
  const Team* team = nullptr;  ///< all must make the same request; the result does not depend on it
};

/// Throws umov::Error for a luminaire without light and fewer planes than 1 or angles than 3.
Distribution intensity_distribution(const Tracer& tracer, const DistributionRequest& request);

}  // namespace umov::chamber
