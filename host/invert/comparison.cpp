#include "host/invert/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>

#include "host/brdf/model.hpp"
#include "host/errors/error.hpp"
#include "host/formats/order_statistics.hpp"
#include "host/invert/fitted_model.hpp"
#include "host/invert/neighbours.hpp"
#include "host/invert/observations.hpp"
#include "host/invert/prediction.hpp"
#include "host/invert/residuals.hpp"
#include "host/invert/stopwatch.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::invert {
namespace {

constexpr const char* interpolation = "interpolation";
constexpr std::size_t stride = 5;
/// Starts of each fit: the models are many, and each start is followed by line searches.
constexpr int most_starts = 6;

/// Prediction of one held-out point: value and one sigma, its noise included.
struct Forecast {
  double value = 0, sigma = 1;
};

void judge(const formats::BrdfTable& table, const std::vector<std::size_t>& held_out,
           const std::vector<Forecast>& forecasts, Contender& out) {
  std::vector<double> sizes;
  double chi2 = 0, log_density = 0;
  for (std::size_t k = 0; k < held_out.size(); ++k) {
    const std::size_t i = held_out[k];
    const double y = table.points.brdf_per_sr[i], u = table.points.brdf_u[i];
    const double miss = y - forecasts[k].value;
    chi2 += miss * miss / (u * u);
    const double spread = forecasts[k].sigma;
    log_density -= 0.5 * (miss * miss / (spread * spread)) + std::log(spread / u) +
                   0.5 * std::log(2 * std::numbers::pi);
    if (y > 0) sizes.push_back(std::abs(miss / y));
  }
  const auto count = static_cast<double>(held_out.size());
  out.chi2_per_point = chi2 / count;
  out.log_density = log_density / count;
  if (!sizes.empty()) {
    out.median_relative = formats::median(sizes);
    out.p90_relative = formats::quantile(sizes, 0.9);
  }
  if (!std::isfinite(out.log_density)) out.failure = "its predictions are not finite";
}

void run_model(const formats::BrdfTable& table, const formats::BrdfTable& training,
               const std::vector<std::size_t>& held_out, const Options& options, Contender& out) {
  Options own = options;
  own.model = out.model;
  own.held_out = own.dhr = false;
  own.threads = 1;
  own.starts = std::min(options.starts, most_starts);
  own.progress = nullptr;
  out.fit = invert(training, own);
  const formats::FitResult& fit = *out.fit;
  out.model = fit.model;
  out.parameters = fit.covariance.names.size();

  const Prediction prediction = predict(fit, table);
  std::vector<double> z;
  for (std::size_t i = 0; i < training.points.size(); ++i) {
    if (training.points.used[i] != 0) z.push_back(prediction.residual[i]);
  }
  const Eigen::Map<const Eigen::VectorXd> residuals_of_training(
      z.data(), static_cast<Eigen::Index>(z.size()));
  out.scale = residual_scale(residuals_of_training, 4, out.parameters);
  const auto points = static_cast<double>(z.size());
  out.bic = points * std::log(std::max(out.scale * out.scale, 1e-300)) +
            static_cast<double>(out.parameters) * std::log(points);

  const FittedModel model(fit);
  const double aperture = solid_angle_sr(table);
  std::vector<Forecast> forecasts;
  for (const std::size_t i : held_out) {
    double f = 0;
    const double own_u = model.sigma(
        model.wavelength(table.points.wavelength_nm[i]), view_of(table.points, i, aperture),
        channel_of(table.points.polarizer_deg[i], table.points.analyzer_deg[i]), f);
    const double noise =
        std::hypot(table.points.brdf_u[i], options.floor_relative * table.points.brdf_per_sr[i]) *
        std::max(1.0, fit.interval_scale);
    forecasts.push_back({prediction.calibrated_per_sr[i], std::hypot(noise, own_u)});
  }
  judge(table, held_out, forecasts, out);
}

void run_interpolation(const formats::BrdfTable& table, const formats::BrdfTable& training,
                       const std::vector<std::size_t>& held_out, Contender& out) {
  std::vector<bool> known(table.points.size()), wanted(table.points.size());
  for (std::size_t i = 0; i < known.size(); ++i) known[i] = training.points.used[i] != 0;
  for (const std::size_t i : held_out) wanted[i] = true;
  // How well it does on the training points themselves, each left out in turn.
  const std::vector<double> trial = from_neighbours(table, known, known);
  std::vector<double> z;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (known[i] && std::isfinite(trial[i])) {
      z.push_back((trial[i] - table.points.brdf_per_sr[i]) / table.points.brdf_u[i]);
    }
  }
  if (z.empty()) {
    out.failure = "no two training points are of the same wavelength and state";
    return;
  }
  out.scale = residual_scale(
      Eigen::Map<const Eigen::VectorXd>(z.data(), static_cast<Eigen::Index>(z.size())), 4, 0);
  const std::vector<double> values = from_neighbours(table, known, wanted);
  std::vector<Forecast> forecasts;
  for (const std::size_t i : held_out) {
    forecasts.push_back({values[i], table.points.brdf_u[i] * std::max(1.0, out.scale)});
  }
  judge(table, held_out, forecasts, out);
}

}  // namespace

std::vector<std::string> library_models() {
  std::vector<std::string> out;
  for (const std::string& name : brdf::Model::names()) {
    const brdf::Model model = brdf::Model::by_name(name);
    if (model.needs_table() || model.parameters().empty()) continue;
    out.push_back(name);
  }
  const auto known = [&](const char* name) {
    return std::find(out.begin(), out.end(), name) != out.end();
  };
  std::vector<std::string> sums;
  for (const char* lobe : {"microfacet", "ggx", "he-torrance", "rayleigh-rice", "ward", "phong"}) {
    for (const char* body : {"lambertian", "nef", "subsurface"}) {
      if (known(lobe) && known(body)) sums.push_back(std::string(lobe) + "+" + body);
    }
  }
  for (const char* two : {"microfacet+microfacet", "microfacet+ggx", "ggx+ggx"}) {
    for (const char* body : {"lambertian", "nef", "subsurface"}) {
      if (known(body)) sums.push_back(std::string(two) + "+" + body);
    }
  }
  for (const char* lobe : {"microfacet", "ggx", "rayleigh-rice"}) {
    if (!known(lobe) || !known("subsurface")) continue;
    sums.push_back(std::string(lobe) + "+subsurface+lambertian");
  }
  out.insert(out.end(), sums.begin(), sums.end());
  return out;
}

std::vector<bool> every_fifth_row(const formats::BrdfTable& table) {
  std::vector<bool> out(table.points.size(), false);
  for (const Spectrum& spectrum : observations(table, 0).spectra) {
    for (const Observation& point : spectrum.points) {
      out[point.table_index] = point.row % stride == stride - 1;
    }
  }
  return out;
}

Comparison compare_models(const formats::BrdfTable& table, const std::vector<bool>& held_out,
                          const std::vector<std::string>& models, const Options& options) {
  formats::BrdfTable training = table;
  std::vector<std::size_t> withheld;
  Comparison out;
  for (std::size_t i = 0; i < table.points.size(); ++i) {
    if (table.points.used[i] == 0) continue;
    if (held_out[i]) {
      training.points.used[i] = 0;
      withheld.push_back(i);
    } else {
      ++out.training_points;
    }
  }
  out.held_out_points = withheld.size();
  if (withheld.empty() || out.training_points == 0) {
    throw Error("a comparison needs rows to fit and rows to foretell, and one of them is empty",
                "select other --rows");
  }
  for (const std::string& name : models) {
    const bool twice = std::any_of(out.contenders.begin(), out.contenders.end(),
                                   [&](const Contender& c) { return c.model == name; });
    if (twice) continue;
    out.contenders.emplace_back();
    out.contenders.back().model = name;
  }
  std::mutex reporting;
  std::size_t done = 0;
  for_each_index(out.contenders.size(), options.threads, [&](std::size_t i) {
    Contender& contender = out.contenders[i];
    Stopwatch clock;
    try {
      if (contender.model == interpolation) {
        run_interpolation(table, training, withheld, contender);
      } else {
        run_model(table, training, withheld, options, contender);
      }
    } catch (const Error& error) {
      contender.failure = error.what();
    }
    contender.seconds = clock.total();
    const std::lock_guard lock(reporting);
    ++done;
    if (options.progress) {
      options.progress(static_cast<double>(done) / static_cast<double>(out.contenders.size()),
                       contender.model);
    }
  });
  std::stable_sort(out.contenders.begin(), out.contenders.end(),
                   [](const Contender& a, const Contender& b) {
                     if (a.failure.empty() != b.failure.empty()) return a.failure.empty();
                     return a.failure.empty() && a.log_density > b.log_density;
                   });
  return out;
}

}  // namespace umov::invert
