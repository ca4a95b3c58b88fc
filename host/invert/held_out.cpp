#include "host/invert/held_out.hpp"

#include <set>
#include <vector>

#include "host/invert/starts.hpp"

namespace umov::invert {
namespace {

constexpr std::size_t held_out_stride = 5;

}  // namespace

std::optional<double> held_out_gap(const Layout& layout, const Observations& data,
                                   const Priors& priors, const Found& found,
                                   const Options& options) {
  std::vector<std::vector<bool>> kept, held;
  std::set<std::size_t> rows;
  for (const Spectrum& spectrum : data.spectra) {
    kept.emplace_back();
    held.emplace_back();
    for (const Observation& point : spectrum.points) {
      const bool out = point.row % held_out_stride == held_out_stride - 1;
      kept.back().push_back(!out);
      held.back().push_back(out);
      if (out) rows.insert(point.row);
    }
  }
  const Observations training = select(data, kept), test = select(data, held);
  for (const Spectrum& spectrum : training.spectra) {
    if (spectrum.points.size() < layout.size()) return std::nullopt;
  }
  if (rows.empty()) return std::nullopt;
  const Solution again =
      options.objective == Objective::paper
          ? paper_bfgs(layout, training, found.solution.x, options.max_iterations)
          : least_squares({layout,
                           training,
                           priors,
                           {.scale = found.scale, .huber_sigma = options.robust_sigma}},
                          found.solution.x, found.solution.c, linear_parameters(layout, data),
                          {.max_iterations = 40});
  double sum = 0;
  for (std::size_t w = 0; w < test.spectra.size(); ++w) {
    if (test.spectra[w].points.empty()) continue;
    sum += residuals(layout, test, w, again.x, again.c, {}, false).r.squaredNorm();
  }
  return sum / static_cast<double>(test.size()) - 1;
}

}  // namespace umov::invert
