#include "host/invert/idle_terms.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/invert/box_quadratic.hpp"
#include "host/invert/normal_equations.hpp"

namespace umov::invert {
namespace {

/// A term whose absence costs less than this in chi² (about seven sigma) is idle.
constexpr double idle_cost = 50;
/// Shapes that are followed to their optimum.
constexpr std::size_t followed = 3;

std::vector<std::size_t> slots_of(const Layout& layout, std::size_t parameter) {
  std::vector<std::size_t> out;
  for (std::size_t w = 0; w < layout.wavelengths_nm().size(); ++w) {
    const auto slot = layout.slot(w, parameter);
    if (slot && std::find(out.begin(), out.end(), *slot) == out.end()) out.push_back(*slot);
  }
  return out;
}

/// Trial coordinates of one shape parameter: many for the first of a term, few for the others.
std::vector<double> shape_trials(const Coordinate& k, bool first) {
  std::vector<double> out;
  if (!first) {
    for (const double share : {0.02, 0.5, 0.98}) {
      out.push_back(k.lo_x() + share * (k.hi_x() - k.lo_x()));
    }
    return out;
  }
  constexpr int count = 24;
  for (int i = 0; i < count; ++i) {
    out.push_back(k.lo_x() + (k.hi_x() - k.lo_x()) * (i + 0.5) / count);
  }
  return out;
}

/// Least objective that the quadratic at `at` promises when some coordinates take given steps.
double promised(const NormalEquations& at, const Eigen::VectorXd& lo, const Eigen::VectorXd& hi) {
  const Eigen::VectorXd step =
      minimum_in_box(at.curvature, at.gradient, lo, hi, Eigen::VectorXd::Zero(lo.size()));
  return at.objective + (2 * at.gradient + at.curvature * step).dot(step);
}

struct Box {
  Eigen::VectorXd lo, hi;
};
/// Limits of a step from x, c.
Box step_limits(const Layout& layout, const std::vector<double>& x, std::size_t factors) {
  const auto size = static_cast<Eigen::Index>(layout.size() + factors);
  Box box{Eigen::VectorXd::Constant(size, -1e300), Eigen::VectorXd::Constant(size, 1e300)};
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const Coordinate& k = layout.free()[i].coordinate;
    box.lo[static_cast<Eigen::Index>(i)] = k.lo_x() - x[i];
    box.hi[static_cast<Eigen::Index>(i)] = k.hi_x() - x[i];
  }
  return box;
}

}  // namespace

std::vector<Term> terms_with_shapes(const Layout& layout, const Observations& data,
                                    const std::vector<bool>& linear) {
  const auto& list = layout.model().parameters();
  std::vector<View> views;
  for (const Spectrum& spectrum : data.spectra) {
    const std::size_t step = std::max<std::size_t>(1, spectrum.sites.size() / 6);
    for (std::size_t s = 0; s < spectrum.sites.size() && views.size() < 8; s += step) {
      views.push_back(spectrum.sites[s].view);
    }
  }
  const std::array channels{channel_of(0, 0), channel_of(0, 90), channel_of(90, 90)};
  std::vector<Term> out;
  for (std::size_t weight = 0; weight < list.size(); ++weight) {
    if (!linear[weight] || list[weight].min > 0) continue;
    std::vector<int> others;
    for (const int parameter : layout.active(0)) {
      if (!linear[static_cast<std::size_t>(parameter)]) others.push_back(parameter);
    }
    std::vector<double> off(others.size(), 0.0), on(others.size(), 0.0);
    for (const bool present : {false, true}) {
      std::vector<double> values = layout.values(0, layout.start_x());
      values[weight] = present ? 0.3 * list[weight].max : 0;
      for (const View& view : views) {
        std::vector<double> f(channels.size()), by(channels.size() * others.size());
        evaluate_channels(layout.model(), values, others, layout.wavelength_um(0), view, channels,
                          f, by);
        for (std::size_t i = 0; i < by.size(); ++i) {
          (present ? on : off)[i % others.size()] += std::abs(by[i]);
        }
      }
    }
    Term term{weight, {}};
    for (std::size_t i = 0; i < others.size(); ++i) {
      if (on[i] > 0 && off[i] <= 1e-12 * on[i]) {
        term.shapes.push_back(static_cast<std::size_t>(others[i]));
      }
    }
    if (!term.shapes.empty()) out.push_back(std::move(term));
  }
  return out;
}

Solution with_idle_terms_offered(const Problem& problem, const std::vector<bool>& linear,
                                 const std::vector<Term>& terms, Solution found, const Stop& stop) {
  const Layout& layout = problem.layout;
  for (const Term& term : terms) {
    const std::vector<std::size_t> weights = slots_of(layout, term.weight);
    // What would its absence cost?
    NormalEquations at = normal_equations(problem, found.x, found.c);
    Box box = step_limits(layout, found.x, found.c.size());
    for (const std::size_t i : weights) {
      box.lo[static_cast<Eigen::Index>(i)] = box.hi[static_cast<Eigen::Index>(i)] = -found.x[i];
    }
    if (!at.finite || promised(at, box.lo, box.hi) - at.objective > idle_cost) continue;

    // A grid over all shapes, each trial with a trace of the weight to have its derivative.
    struct Trial {
      double promise;
      std::vector<double> x;
    };
    std::vector<Trial> trials{{0, found.x}};
    for (const std::size_t i : weights) trials.front().x[i] = layout.free()[i].coordinate.lo_x();
    for (std::size_t s = 0; s < term.shapes.size(); ++s) {
      const std::vector<std::size_t> slots = slots_of(layout, term.shapes[s]);
      std::vector<Trial> next;
      for (const Trial& trial : trials) {
        for (const double value : shape_trials(layout.free()[slots.front()].coordinate, s == 0)) {
          next.push_back(trial);
          // One a wavelength: they start from the same shape.
          for (const std::size_t slot : slots) next.back().x[slot] = value;
        }
      }
      trials = std::move(next);
    }
    for (Trial& trial : trials) {
      at = normal_equations(problem, trial.x, found.c);
      if (!at.finite) {
        trial.promise = std::numeric_limits<double>::infinity();
        continue;
      }
      box = step_limits(layout, trial.x, found.c.size());
      // Without weight a shape has no derivative to tell where it would go: it stays.
      for (const std::size_t shape : term.shapes) {
        for (const std::size_t i : slots_of(layout, shape)) {
          box.lo[static_cast<Eigen::Index>(i)] = box.hi[static_cast<Eigen::Index>(i)] = 0;
        }
      }
      trial.promise = promised(at, box.lo, box.hi);
    }
    // Local minima along the first shape, the best of each neighbourhood.
    std::vector<std::size_t> order(trials.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return trials[a].promise < trials[b].promise;
    });
    std::vector<std::size_t> chosen;
    const std::size_t stride = std::max<std::size_t>(1, trials.size() / 24);
    for (const std::size_t i : order) {
      const bool apart = std::all_of(chosen.begin(), chosen.end(), [&](std::size_t other) {
        const std::size_t a = i / stride, b = other / stride;
        return (a > b ? a - b : b - a) > 2;
      });
      if (apart && chosen.size() < followed) chosen.push_back(i);
    }
    for (const std::size_t i : chosen) {
      Solution next = least_squares(problem, trials[i].x, found.c, linear, stop);
      const int all = found.iterations + next.iterations;
      if (next.objective < found.objective) found = std::move(next);
      found.iterations = all;
    }
  }
  return found;
}

}  // namespace umov::invert
