#include "host/invert/invert.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/brdf/model.hpp"
#include "host/errors/error.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/invert/estimates.hpp"
#include "host/invert/further_data.hpp"
#include "host/invert/held_out.hpp"
#include "host/invert/identifiability.hpp"
#include "host/invert/posterior.hpp"
#include "host/invert/search.hpp"
#include "host/invert/starts.hpp"
#include "host/invert/stopwatch.hpp"

namespace umov::invert {
namespace {

using formats::FitResult;

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

}  // namespace

FitResult invert(const formats::BrdfTable& table, const Options& options) {
  if (options.starts < 1) throw Error("a fit needs at least one start", "use 8 to 16");
  Stopwatch clock;
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
  if (options.objective == Objective::paper && !options.priors.empty()) {
    throw Error("priors have no weight against relative deviations",
                "use the noise-weighted objective with --prior");
  }
  const Priors priors(layout, options.priors);
  for (const Prior& prior : options.priors) fit.priors.push_back(prior_text(prior));
  fit.model = model.name();
  fit.wavelengths_nm = layout.wavelengths_nm();
  fit.seed = options.seed;
  fit.robust_scale_sigma = options.objective == Objective::paper ? 0 : options.robust_sigma;
  fit.floor_relative = options.floor_relative;
  fit.objective_kind = options.objective == Objective::paper ? "paper" : "noise-weighted";
  fit.data_sha256 = formats::content_sha256(table);

  const Found found = search(layout, data, priors, options);
  fit.phase_seconds = found.phase_seconds;
  clock.lap();
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
  const Posterior posterior(layout, data, priors, found.solution, options.objective, scale,
                            options.robust_sigma);
  set_parameters(layout, found.solution, posterior, fit);
  set_derived(layout, found.solution, posterior, fit);
  describe_identifiability(layout, data, posterior, fit);
  if (options.objective == Objective::noise_weighted) {
    describe_further_data({layout, data, priors, {.scale = scale}}, found.solution, fit);
  }
  set_covariance(layout, found.solution, posterior, fit);
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
    fit.g2_held_out = held_out_gap(layout, data, priors, found, options);
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
  for (std::size_t i = 0; i < model.parameters().size(); ++i) {
    const std::string& name = model.parameters()[i].name;
    if (bare_name(name) != "n" || fit.parameters[i].fixed) continue;
    const formats::FitParameter* kappa = fit.find(name.substr(0, name.size() - 1) + "kappa");
    if (kappa == nullptr || fit.parameters[i].estimates.front().hi >= 1) continue;
    const bool metal = std::all_of(kappa->estimates.begin(), kappa->estimates.end(),
                                   [](const formats::Estimate& e) { return e.value >= 1; });
    if (metal) continue;
    fit.notes.push_back(name + text(" = %.3g", fit.parameters[i].estimates.front().value) +
                        " without a metal's extinction is no surface in air: the lobe stands for "
                        "something else, and its parameters mean nothing alone");
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
  const Observations thin = starting_observations(data);
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
