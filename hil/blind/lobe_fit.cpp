#include "hil/blind/lobe_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>

#include "hil/plant/facet_sample.hpp"

namespace umov::blind {
namespace {

constexpr std::size_t thinning = 3;

std::shared_ptr<const plant::Sample> parts(double n, double slope, double weight, double d1,
                                           double d2) {
  plant::FacetParameters p;
  p.n = plant::Spectrum(n);
  p.lobes[0].slope = slope;
  p.lobes[0].weight = weight;
  p.rho_d1 = plant::Spectrum(d1);
  p.rho_d2 = plant::Spectrum(d2);
  return std::make_shared<plant::FacetSample>("lobe", p);
}

World thinned(const World& world) {
  World few = world;
  for (RowBlock& block : few.blocks) {
    std::vector<Row> kept;
    for (std::size_t i = 0; i < block.rows.size(); i += thinning) kept.push_back(block.rows[i]);
    block.rows = std::move(kept);
  }
  return few;
}

}  // namespace

double beyond_one_gaussian_lobe(const World& world) {
  if (world.material.one_gaussian_lobe) return 0.0;
  const ChangeMeter meter(thinned(world));
  const Signals nothing(meter.base_signals().size(), 0.0);
  const std::vector<double> data = meter.whitened(meter.base_signals(), nothing);
  std::vector<int> laser;
  for (const RowBlock& block : meter.world().blocks) {
    for (const Row& row : block.rows) laser.push_back(row.laser);
  }
  // Gain, ρ_d1 and ρ_d2 of each wavelength enter linearly: they are projected out, and index and
  // slope are searched.
  const auto add = [&](Subspace& space, const Signals& signals) {
    for (int l = 0; l < plant::laser_count; ++l) {
      Signals one = signals;
      for (std::size_t i = 0; i < laser.size(); ++i) {
        if (laser[i] != l) one[2 * i] = one[2 * i + 1] = 0.0;
      }
      space.add(meter.whitened(one, nothing));
    }
  };
  Subspace diffuse;
  add(diffuse, meter.signals_of(parts(1.5, 0.1, 0.0, 1.0, 0.0)));
  add(diffuse, meter.signals_of(parts(1.5, 0.1, 0.0, 0.0, 1.0)));
  const auto misfit = [&](double n, double slope) {
    Subspace all = diffuse;
    add(all, meter.signals_of(parts(n, slope, 1.0, 0.0, 0.0)));
    return length(all.rest(data));
  };
  // Steps in index and log slope that shrink about the best so far.
  double best_n = 1.5;
  double best_slope = std::clamp(meter.world().material.slope_rms(), 0.04, 0.5);
  double best = misfit(best_n, best_slope);
  double step_n = 0.1;
  double step_slope = 0.25;
  for (int round = 0; round < 8; ++round) {
    const double n = best_n;
    const double slope = best_slope;
    const std::array<std::pair<double, double>, 4> trials = {{{n + step_n, slope},
                                                              {n - step_n, slope},
                                                              {n, slope * std::exp(step_slope)},
                                                              {n, slope * std::exp(-step_slope)}}};
    for (const auto& [trial_n, trial_slope] : trials) {
      if (trial_n < 1.05 || trial_slope < 0.01 || trial_slope > 1.0) continue;
      const double value = misfit(trial_n, trial_slope);
      if (value < best) {
        best = value;
        best_n = trial_n;
        best_slope = trial_slope;
      }
    }
    if (best_n == n && best_slope == slope) {
      step_n *= 0.4;
      step_slope *= 0.4;
    }
  }
  return best * std::sqrt(static_cast<double>(thinning));
}

}  // namespace umov::blind
