#include "host/gap/engine/gap_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "host/gap/engine/folds.hpp"
#include "host/gap/engine/linear_view.hpp"

namespace umov::gap {
namespace {

constexpr double two_sided_95 = 1.959964;
constexpr int most_blocks = 400;

/// Per cent of the signal that a G² stands for, as the diagnosis counts it.
double percent_of(double g2, const Refit& fit, const Whitening& whitening) {
  const double sharpness = fit.mean.cwiseQuotient(whitening.white_sigma()).squaredNorm() /
                           static_cast<double>(fit.residual.size());
  return 100 * std::sqrt(std::max(0.0, g2) / std::max(sharpness, 1e-300));
}

GapInterval interval_of(const GapSize& size, double below, double above, const Refit& fit,
                        const Whitening& whitening) {
  return {{size.g2, size.g2 - below, size.g2 + above},
          {size.percent, percent_of(size.g2 - below, fit, whitening),
           percent_of(size.g2 + above, fit, whitening)}};
}

}  // namespace

GapBounds gap_bounds(const ForwardModel& model, const Diagnosis& diagnosis, int draws,
                     std::uint64_t seed) {
  const Whitening& whitening = *diagnosis.search.whitening;
  const Refit& after = diagnosis.best;
  const Refit& base = diagnosis.search.hypotheses[diagnosis.search.base].refit;
  const std::vector<int>& row = model.observations().row;
  std::vector<int> rows = row;
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  const std::vector<int> block =
      fold_of_observations(row, std::min(most_blocks, static_cast<int>(rows.size())), seed);
  std::vector<double> size(static_cast<std::size_t>(*std::max_element(block.begin(), block.end())) +
                           1);
  for (const int b : block) size[static_cast<std::size_t>(b)] += 1;

  const auto drawn = [&](const Refit& fit, const Whitening& noise, const GapSize& gap,
                         std::uint64_t own_seed) {
    const std::vector<double> chi2 = LinearView(model, fit, noise, block, false).held_out_by_fold();
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < chi2.size(); ++i) {
      sum += chi2[i];
      count += size[i];
    }
    const double centre = sum / count - 1;
    std::mt19937_64 random(own_seed);
    std::vector<double> found;
    for (int d = 0; d < draws; ++d) {
      sum = count = 0;
      for (std::size_t i = 0; i < chi2.size(); ++i) {
        const std::size_t pick = random() % chi2.size();
        sum += chi2[pick];
        count += size[pick];
      }
      found.push_back(sum / count - 1);
    }
    std::sort(found.begin(), found.end());
    const std::size_t tail = found.size() / 40;
    return interval_of(gap, std::max(0.0, centre - found[tail]),
                       std::max(0.0, found[found.size() - 1 - tail] - centre), fit, noise);
  };
  const double chance =
      two_sided_95 * std::sqrt(2.0 / static_cast<double>(model.observations().value.size()));
  return {drawn(base, *diagnosis.base_whitening, diagnosis.before, seed + 1),
          drawn(after, whitening, diagnosis.after, seed + 2),
          interval_of(diagnosis.floor, chance, chance, after, whitening)};
}

}  // namespace umov::gap
