// How large a change of a scan is once the base model has been refitted to it: ρ.
//
// The scan's signals X and Y (divided by the monitor) are taken without noise, with and without the
// change, and whitened with the instrument's noise. What a refit of the base could follow is
// projected out: numerical derivatives to every parameter of the material, and one gain a
// wavelength, known to the 1 % that a scan's heading states. ρ is the length of what is left: the
// square root of the drop in χ² that a perfect model of the change would give. Zeros of the stages
// are effects and not part of the base.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "hil/blind/bench.hpp"
#include "hil/blind/effect.hpp"
#include "hil/blind/material.hpp"

namespace umov::blind {

/// Relative uncertainty of the gain constants in a scan's heading.
inline constexpr double stated_gain_u = 0.01;

/// Signals of a scan: for each record X then Y, volts, referred to the base's monitor.
using Signals = std::vector<double>;

/// What stays the same while effects are tried on a case.
struct World {
  plant::PlantConfig config;  ///< without the effects
  Material material;
  std::vector<RowBlock> blocks;
  Acquisition acquisition;
  EffectContext context;
  std::uint64_t seed = 1;
};

/// Orthonormal directions, grown one by one.
class Subspace {
 public:
  /// Adds what is new in a direction; nothing where that is below 1e-9 of it.
  void add(std::vector<double> direction);
  /// What is left of a vector.
  std::vector<double> rest(std::vector<double> vector) const;
  std::size_t size() const { return basis_.size(); }

 private:
  std::vector<std::vector<double>> basis_;
};

double length(std::span<const double> vector);

class ChangeMeter {
 public:
  explicit ChangeMeter(World world);

  const World& world() const { return world_; }

  /// Noise-free signals with effects in the plant.
  Signals signals(std::span<const Effect> effects) const;
  /// Noise-free signals of another sample, without effects.
  Signals signals_of(const std::shared_ptr<const plant::Sample>& sample) const {
    return run(world_.config, sample);
  }
  /// Whitened difference of two scans; behind it the three gains' departures from what is stated,
  /// 0.
  std::vector<double> whitened(const Signals& with, const Signals& without) const;
  /// ρ of effects against the scan without any.
  double rho(std::span<const Effect> effects) const;
  /// Whitened and refitted: the vector whose length is ρ.
  std::vector<double> left(std::span<const Effect> effects) const;
  const Signals& base_signals() const { return base_; }
  const Subspace& refit() const { return refit_; }
  /// ρ of speckle, whose pattern no model knows: the expected significance of its excess variance,
  /// √(½ Σ (v/(1+v))²) with v its variance over the noise's.
  double rho_of_speckle(double contrast) const;

 private:
  Signals run(const plant::PlantConfig& config,
              const std::shared_ptr<const plant::Sample>& sample) const;

  World world_;
  std::vector<double> base_monitor_v_;
  Signals base_;
  std::vector<double> deviation_;  ///< standard deviation of each entry of Signals
  Subspace refit_;
};

}  // namespace umov::blind
