#include "host/invert/invert.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <set>

#include "host/brdf/dhr.hpp"
#include "host/brdf/model.hpp"
#include "host/errors/error.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/invert/dhr_gradient.hpp"
#include "host/invert/identifiability.hpp"
#include "host/invert/minimise.hpp"
#include "host/invert/parallel.hpp"
#include "host/invert/posterior.hpp"
#include "host/invert/starts.hpp"
#include "host/optics/angles.hpp"

namespace umov::invert {
namespace {

using formats::Estimate;
using formats::FitParameter;
using formats::FitResult;

/// Geometries of each scan that the starting stage looks at, and the share of the BRDF by which the
/// model may be off there: enough to smooth the way to the optimum.
constexpr std::size_t sites_per_scan = 20;
constexpr double starting_floor = 0.03;
/// Distinct candidates that are followed to the end.
constexpr std::size_t finalists = 2;
constexpr std::size_t held_out_stride = 5;
/// Reflectance is listed at so many of the data's incidences unless the user names them.
constexpr std::size_t most_incidences = 10;

class Clock {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }
  double total() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - first_).count();
  }

 private:
  std::chrono::steady_clock::time_point first_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_ = first_;
};

std::string text(const char* format, auto... values) {
  char out[256];
  std::snprintf(out, sizeof out, format, values...);
  return out;
}

Layout layout_of(const brdf::Model& model, const Observations& data, const Options& options) {
  Layout layout(model, data.wavelengths_nm(), options);
  if (layout.size() == 0) {
    throw Error("all parameters of " + model.name() + " are fixed", "leave at least one free");
  }
  if (data.size() <= layout.size()) {
    throw Error(std::to_string(data.size()) + " used points cannot determine " +
                    std::to_string(layout.size()) + " free parameters",
                "measure more points, fix parameters or share them between wavelengths");
  }
  return layout;
}

/// Points with a value that a relative deviation can be formed of: nearer to zero than three of its
/// uncertainties it would be one of the noise.
Observations with_signal(const Observations& data, const formats::BrdfTable& table,
                         std::size_t& left_out) {
  std::vector<std::vector<bool>> keep;
  left_out = 0;
  for (const Spectrum& spectrum : data.spectra) {
    keep.emplace_back();
    for (const Observation& point : spectrum.points) {
      keep.back().push_back(point.brdf_per_sr > 0 &&
                            point.brdf_per_sr >= 3 * table.points.brdf_u[point.table_index]);
      if (!keep.back().back()) ++left_out;
    }
  }
  return select(data, keep);
}

struct Found {
  Solution solution;
  double scale = 1;
  std::size_t starts = 0, agreeing = 0;
  int start_iterations = 0;
};

/// Many starts on thinned data, the best different ones on all of it.
Found search(const Layout& layout, const Observations& data, const Options& options, FitResult& fit,
             Clock& clock) {
  const auto report = [&](double share, const char* stage) {
    if (options.progress) options.progress(share, stage);
  };
  const Observations thin = thinned(data, sites_per_scan, starting_floor);
  report(0, "starting values");
  const auto starts = starting_points(layout, thin, lobe_slope(data), options.starts, options.seed,
                                      options.threads);
  fit.phase_seconds.emplace_back("starting values", clock.lap());

  std::vector<RobustSolution> tried(starts.size());
  std::vector<double> merit(starts.size());
  std::mutex reporting;
  std::size_t done = 0;
  for_each_index(starts.size(), options.threads, [&](std::size_t i) {
    tried[i] = robust_least_squares(layout, thin, starts[i], {}, 4, 60);
    merit[i] = measured_scale(layout, thin, tried[i].solution, 4);
    const std::lock_guard lock(reporting);
    ++done;
    report(0.1 + 0.4 * static_cast<double>(done) / static_cast<double>(starts.size()), "starts");
  });
  fit.phase_seconds.emplace_back("starts", clock.lap());
  std::vector<std::size_t> order(starts.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return merit[a] < merit[b]; });
  Found out;
  out.starts = starts.size();
  std::vector<std::size_t> followed;
  for (const std::size_t i : order) {
    if (merit[i] <= merit[order.front()] * (1 + 1e-3)) ++out.agreeing;
    const bool new_optimum = followed.empty() || merit[i] > merit[followed.back()] * (1 + 1e-3);
    if (new_optimum && followed.size() < finalists && merit[i] < 1.5 * merit[order.front()]) {
      followed.push_back(i);
    }
  }

  report(0.5, "all points");
  const std::vector<double> no_factor(
      options.objective == Objective::paper ? 0 : data.factor_names.size(), 0.0);
  std::vector<Solution> ended(followed.size());
  std::vector<double> scales(followed.size(), 1.0), quality(followed.size());
  for_each_index(followed.size(), options.threads, [&](std::size_t i) {
    const std::vector<double>& x = tried[followed[i]].solution.x;
    if (options.objective == Objective::paper) {
      ended[i] = paper_bfgs(layout, data, x, options.max_iterations);
      quality[i] = ended[i].objective;
    } else {
      RobustSolution robust = robust_least_squares(layout, data, x, no_factor, options.robust_sigma,
                                                   options.max_iterations);
      ended[i] = std::move(robust.solution);
      scales[i] = robust.scale;
      quality[i] = measured_scale(layout, data, ended[i], options.robust_sigma);
    }
  });
  const auto best =
      static_cast<std::size_t>(std::min_element(quality.begin(), quality.end()) - quality.begin());
  out.start_iterations = tried[followed[best]].solution.iterations;
  out.solution = std::move(ended[best]);
  out.scale = scales[best];
  fit.phase_seconds.emplace_back("all points", clock.lap());
  return out;
}

void set_parameters(const Layout& layout, const Solution& solution, const Posterior& posterior,
                    FitResult& fit) {
  const auto& list = layout.model().parameters();
  for (std::size_t i = 0; i < list.size(); ++i) {
    FitParameter parameter;
    parameter.name = list[i].name;
    parameter.unit = list[i].unit;
    parameter.shared = layout.is_shared(i);
    parameter.fixed = true;
    const std::size_t count = parameter.shared ? 1 : fit.wavelengths_nm.size();
    for (std::size_t w = 0; w < count; ++w) {
      Estimate e;
      e.value = layout.values(w, solution.x)[i];
      e.lo = e.hi = e.value;
      if (const auto free = layout.slot(w, i)) {
        parameter.fixed = false;
        const Coordinate& k = layout.free()[*free].coordinate;
        const double x = solution.x[*free], span = k.hi_x() - k.lo_x();
        if (x - k.lo_x() <= 1e-9 * span) {
          e.at_bound = "lower";
          e.value = k.lo;
        } else if (k.hi_x() - x <= 1e-9 * span) {
          e.at_bound = "upper";
          e.value = k.hi;
        }
        if (!e.at_bound.empty()) fit.at_bound.push_back(layout.label(*free));
        const Interval interval = posterior.parameter_interval(*free);
        e.lo = std::min(interval.lo, e.value);
        e.hi = std::max(interval.hi, e.value);
        e.standard_error = (e.hi - e.lo) / (2 * 1.959963984540054);
      }
      parameter.estimates.push_back(e);
    }
    fit.parameters.push_back(std::move(parameter));
  }
}

/// Adds a quantity made of two parameters, shared where both are.
void add_derived(const Layout& layout, const Solution& solution, const Posterior& posterior,
                 std::size_t first, std::size_t second, const std::string& name,
                 const std::string& unit, auto value_and_slopes, FitResult& fit) {
  FitParameter derived;
  derived.name = name;
  derived.unit = unit;
  derived.shared = layout.is_shared(first) && layout.is_shared(second);
  for (std::size_t w = 0; w < (derived.shared ? 1 : fit.wavelengths_nm.size()); ++w) {
    const std::vector<double> values = layout.values(w, solution.x);
    const auto [value, by_first, by_second] = value_and_slopes(values[first], values[second]);
    Eigen::VectorXd by_x = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(layout.size()));
    for (const auto& [parameter, by] : {std::pair{first, by_first}, {second, by_second}}) {
      if (const auto free = layout.slot(w, parameter)) {
        by_x[static_cast<Eigen::Index>(*free)] +=
            by * layout.free()[*free].coordinate.slope(solution.x[*free]);
      }
    }
    const Interval interval = posterior.interval(value, by_x);
    Estimate e;
    e.value = value;
    e.lo = std::max(interval.lo, 0.0);  // slopes and reflectances are not negative
    e.hi = interval.hi;
    e.standard_error = (e.hi - e.lo) / (2 * 1.959963984540054);
    derived.estimates.push_back(e);
  }
  fit.derived.push_back(std::move(derived));
}

void set_derived(const Layout& layout, const Solution& solution, const Posterior& posterior,
                 FitResult& fit) {
  struct Values {
    double value, by_first, by_second;
  };
  const auto& list = layout.model().parameters();
  const auto find = [&](const std::string& name) -> std::optional<std::size_t> {
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (list[i].name == name) return i;
    }
    return std::nullopt;
  };
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string bare = bare_name(list[i].name);
    const std::string part = list[i].name.substr(0, list[i].name.size() - bare.size());
    if (bare == "sigma_um") {
      if (const auto tau = find(part + "tau_um")) {
        add_derived(
            layout, solution, posterior, i, *tau, part + "slope_2sigma_over_tau", "1",
            [](double sigma, double length) {
              return Values{2 * sigma / length, 2 / length, -2 * sigma / (length * length)};
            },
            fit);
      }
    }
    if (bare == "k_udf") {
      if (const auto uds = find(part + "k_uds")) {
        add_derived(
            layout, solution, posterior, i, *uds, part + "k_udf+" + part + "k_uds", "1",
            [](double udf, double below) {
              return Values{udf + below, 1, 1};
            },
            fit);
      }
    }
  }
}

void set_dhr(const Layout& layout, const formats::BrdfTable& table, const Solution& solution,
             const Posterior& posterior, const Options& options, FitResult& fit) {
  std::set<double> angles(options.dhr_theta_i_deg.begin(), options.dhr_theta_i_deg.end());
  if (angles.empty()) {
    angles.insert(0);
    for (std::size_t i = 0; i < table.points.size(); ++i) {
      if (table.points.used[i] != 0) angles.insert(table.points.theta_i_deg[i]);
    }
    if (angles.size() > most_incidences) {
      const std::vector<double> all(angles.begin(), angles.end());
      angles.clear();
      for (std::size_t i = 0; i < most_incidences; ++i) {
        angles.insert(all[i * (all.size() - 1) / (most_incidences - 1)]);
      }
    }
  }
  for (std::size_t w = 0; w < fit.wavelengths_nm.size(); ++w) {
    for (const double angle : angles) fit.dhr.push_back({fit.wavelengths_nm[w], angle});
  }
  for_each_index(fit.dhr.size(), options.threads, [&](std::size_t i) {
    FitResult::Dhr& entry = fit.dhr[i];
    const std::size_t w = i / angles.size();
    const double theta_i = optics::radians(entry.theta_i_deg);
    const std::vector<double> values = layout.values(w, solution.x);
    entry.mirror =
        brdf::mirror_dhr(layout.model(), values, layout.wavelength_um(w), theta_i).unpolarized;
    entry.value = brdf::dhr(layout.model(), values, layout.wavelength_um(w), theta_i).unpolarized +
                  entry.mirror;
    const Interval interval =
        posterior.interval(entry.value, dhr_gradient(layout, solution.x, w, theta_i));
    entry.lo = std::max(interval.lo, 0.0);
    entry.hi = interval.hi;
  });
}

/// Fits again without every fifth row and asks how that fit does on them.
std::optional<double> held_out_gap(const Layout& layout, const Observations& data,
                                   const Found& found, const Options& options) {
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
          : least_squares(layout, training, found.solution.x, found.solution.c,
                          {.scale = found.scale, .huber_sigma = options.robust_sigma}, 40);
  double sum = 0;
  for (std::size_t w = 0; w < test.spectra.size(); ++w) {
    if (test.spectra[w].points.empty()) continue;
    sum += residuals(layout, test, w, again.x, again.c, {}, false).r.squaredNorm();
  }
  return sum / static_cast<double>(test.size()) - 1;
}

}  // namespace

FitResult invert(const formats::BrdfTable& table, const Options& options) {
  if (options.starts < 1) throw Error("a fit needs at least one start", "use 8 to 16");
  Clock clock;
  const brdf::Model model = brdf::Model::by_name(options.model);
  Observations data = observations(table, options.floor_relative);
  FitResult fit;
  if (options.objective == Objective::paper) {
    std::size_t left_out = 0;
    data = with_signal(data, table, left_out);
    if (left_out > 0) {
      fit.notes.push_back(std::to_string(left_out) +
                          " points below three times their uncertainty were left out: a relative "
                          "deviation needs a signal");
    }
  }
  const Layout layout = layout_of(model, data, options);
  fit.model = model.name();
  fit.wavelengths_nm = layout.wavelengths_nm();
  fit.seed = options.seed;
  fit.robust_scale_sigma = options.objective == Objective::paper ? 0 : options.robust_sigma;
  fit.floor_relative = options.floor_relative;
  fit.objective_kind = options.objective == Objective::paper ? "paper" : "noise-weighted";
  fit.data_sha256 = formats::content_sha256(table);

  const Found found = search(layout, data, options, fit, clock);
  fit.objective = found.solution.objective;
  fit.iterations = static_cast<std::size_t>(found.start_iterations + found.solution.iterations);
  fit.converged = found.solution.converged;
  fit.starts = found.starts;
  fit.starts_agreeing = found.agreeing;
  fit.points = data.size();
  fit.dof = data.size() - layout.size();

  std::size_t outliers = 0;
  double scale = found.scale;
  for (std::size_t w = 0; w < data.spectra.size(); ++w) {
    const auto part = residuals(layout, data, w, found.solution.x, found.solution.c, {}, false);
    fit.chi2 += part.r.squaredNorm();
    if (fit.robust_scale_sigma > 0) {
      outliers +=
          static_cast<std::size_t>((part.r.array().abs() > fit.robust_scale_sigma * scale).count());
    }
  }
  for (const double c : found.solution.c) fit.chi2 += c * c;
  if (options.objective == Objective::paper) {
    const double s = std::sqrt(fit.chi2 / static_cast<double>(fit.dof));
    if (exceeds_noise(s, data.size(), layout.size())) scale = s;
  }
  fit.outliers = outliers;
  fit.interval_scale = scale;

  if (options.progress) options.progress(0.8, "intervals");
  const Posterior posterior(layout, data, found.solution, options.objective, scale,
                            options.robust_sigma);
  set_parameters(layout, found.solution, posterior, fit);
  set_derived(layout, found.solution, posterior, fit);
  describe_identifiability(layout, posterior, fit);
  for (std::size_t i = 0; i < layout.size(); ++i) {
    fit.covariance.names.push_back(layout.label(i));
    const double slope_i = layout.free()[i].coordinate.slope(found.solution.x[i]);
    for (std::size_t j = 0; j < layout.size(); ++j) {
      const double slope_j = layout.free()[j].coordinate.slope(found.solution.x[j]);
      fit.covariance.values.push_back(
          slope_i * slope_j *
          posterior.covariance()(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
    }
  }
  for (std::size_t k = 0; k < found.solution.c.size(); ++k) {
    fit.factors.push_back({data.factor_names[k], found.solution.c[k],
                           posterior.factor_sigma()[static_cast<Eigen::Index>(k)]});
  }
  fit.phase_seconds.emplace_back("intervals", clock.lap());

  if (options.dhr) {
    if (options.progress) options.progress(0.85, "reflectance");
    set_dhr(layout, table, found.solution, posterior, options, fit);
    fit.phase_seconds.emplace_back("reflectance", clock.lap());
  }
  if (options.held_out) {
    if (options.progress) options.progress(0.95, "held-out rows");
    fit.g2_held_out = held_out_gap(layout, data, found, options);
    fit.phase_seconds.emplace_back("held-out rows", clock.lap());
  }

  if (scale > 1) {
    fit.notes.push_back(
        text("the model misses the data by more than their noise (%.3g times): intervals are "
             "widened by that factor and still take the misses for independent",
             scale));
  }
  if (outliers > 0) {
    fit.notes.push_back(
        std::to_string(outliers) +
        text(" points lie beyond %.3g sigma and count linearly", fit.robust_scale_sigma * scale));
  }
  if (!fit.converged) fit.notes.push_back("the minimiser stopped before it had converged");
  const auto brightest = std::max_element(fit.dhr.begin(), fit.dhr.end(),
                                          [](const auto& a, const auto& b) { return a.lo < b.lo; });
  const bool relative =
      std::find(table.keys.begin(), table.keys.end(),
                std::pair<std::string, std::string>("relative_units", "1")) != table.keys.end();
  if (relative) {
    fit.notes.push_back("the data have no absolute scale: reflectance and weights are relative");
  } else if (brightest != fit.dhr.end() && brightest->lo > 1) {
    fit.notes.push_back(
        text("at %g nm and %g degrees the model reflects more than it receives (%.3f): "
             "the data's scale or the model is wrong there",
             brightest->wavelength_nm, brightest->theta_i_deg, brightest->value));
  }
  for (const auto& factor : fit.factors) {
    if (std::abs(factor.value) > 3) {
      fit.notes.push_back("calibration factor \"" + factor.name + "\" was pulled to " +
                          text("%.1f", factor.value) +
                          " standard deviations: model and calibration disagree");
    }
  }
  if (fit.starts_agreeing < 2 && fit.starts > 2) {
    fit.notes.push_back("only one start reached the best objective: try more starts");
  }
  fit.seconds = clock.total();
  return fit;
}

std::vector<StartingValue> starting_values(const formats::BrdfTable& table,
                                           const Options& options) {
  const brdf::Model model = brdf::Model::by_name(options.model);
  const Observations data = observations(table, options.floor_relative);
  const Layout layout = layout_of(model, data, options);
  const Observations thin = thinned(data, sites_per_scan, starting_floor);
  const std::vector<double> x =
      starting_points(layout, thin, lobe_slope(data), options.starts, options.seed, options.threads)
          .front();
  std::vector<StartingValue> out;
  for (std::size_t i = 0; i < model.parameters().size(); ++i) {
    const auto& parameter = model.parameters()[i];
    StartingValue value{.name = parameter.name,
                        .unit = parameter.unit,
                        .meaning = parameter.meaning,
                        .shared = layout.is_shared(i),
                        .fixed = true,
                        .lo = parameter.min,
                        .hi = parameter.max,
                        .values = {}};
    const std::size_t count = value.shared ? 1 : data.spectra.size();
    for (std::size_t w = 0; w < count; ++w) {
      value.values.push_back(layout.values(w, x)[i]);
      if (const auto free = layout.slot(w, i)) {
        value.fixed = false;
        value.lo = layout.free()[*free].coordinate.lo;
        value.hi = layout.free()[*free].coordinate.hi;
      }
    }
    out.push_back(std::move(value));
  }
  return out;
}

}  // namespace umov::invert
