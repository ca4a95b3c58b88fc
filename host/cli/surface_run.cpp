#include "host/cli/surface_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/cli/interrupt.hpp"
#include "host/cli/model_values.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/scene_digest.hpp"
#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/frames.hpp"

namespace umov::cli {
namespace {

// Launches an angle where only an error or a number of rays ends it, and where nothing does.
constexpr double unlimited_samples = 1e15;
constexpr double preset_samples = 1e6;

// Of the options, else of the scene.
trace::CellGoal cell_goal(const SurfaceOptions& options, const surface::Stop& stop,
                          const trace::Hemisphere& hemisphere) {
  trace::CellGoal goal;
  goal.relative_error = options.cell_error_percent > 0.0 ? 0.01 * options.cell_error_percent
                                                         : stop.cell_relative_error;
  const bool named = options.cell_percentile || !options.cell_deg.empty();
  if (named && !(goal.relative_error > 0.0)) {
    throw Error("--cell and --cell-percentile say of which cells, but not how well",
                "add --cell-error");
  }
  goal.percentile = options.cell_percentile.value_or(stop.cell_percentile);
  std::optional<std::array<double, 2>> direction;
  if (!named) direction = stop.cell_deg;
  if (!options.cell_deg.empty()) direction = {options.cell_deg[0], options.cell_deg[1]};
  if (direction) {
    goal.cell = hemisphere.find(
        optics::exit_direction(optics::radians((*direction)[0]), optics::radians((*direction)[1])));
  }
  return goal;
}

}  // namespace

SurfaceRun::SurfaceRun(const SurfaceOptions& options, const Common& common, const Ranks& ranks)
    : options_(options), common_(common), ranks_(ranks) {
  if (options.samples && !(*options.samples >= 1.0 && *options.samples <= 1e15)) {
    throw Error(fmt::format("{} samples", *options.samples), "choose 1 to 1e15");
  }
  if (options.resume && options.output.empty()) {
    throw Error("nothing to resume without an output file", "name it with -o, as the first time");
  }
  if (options.lay_samples && !(*options.lay_samples >= 0.0 && *options.lay_samples <= 1e15)) {
    throw Error(fmt::format("{} launches a lay", *options.lay_samples),
                "choose 1 to 1e15, or 0 for one lay");
  }
  if (!options.cell_deg.empty()) {
    const bool direction = options.cell_deg.size() == 2 && options.cell_deg[0] >= 0.0 &&
                           options.cell_deg[0] < 90.0 && std::isfinite(options.cell_deg[1]);
    if (!direction) {
      throw Error(fmt::format("--cell {} is no direction", fmt::join(options.cell_deg, ",")),
                  "give THETA,PHI in degrees, theta from 0 to below 90");
    }
    if (options.cell_percentile) {
      throw Error("--cell and --cell-percentile", "a run stops by one cell or by a share of all");
    }
  }
}

std::vector<double> SurfaceRun::angles(const surface::Surface& described) const {
  std::vector<double> angles = options_.theta_i_deg;
  if (angles.empty()) angles = described.theta_i_deg;
  if (angles.empty()) angles = {0.0};
  for (const double angle : angles) checked_incidence(angle);
  return angles;
}

trace::Request SurfaceRun::request(const surface::Surface& described) const {
  trace::Request request;
  request.seed = common_.seed;
  request.threads = ranks_.threads(common_.threads);
  request.dhr_relative_error = options_.relative_error_percent > 0.0
                                   ? 0.01 * options_.relative_error_percent
                                   : described.stop.dhr_relative_error;
  request.cells = cell_goal(options_, described.stop, hemisphere());
  request.rays = static_cast<std::uint64_t>(described.stop.rays);
  const bool ends_itself =
      request.dhr_relative_error > 0.0 || request.cells.relative_error > 0.0 || request.rays > 0;
  request.samples = static_cast<std::uint64_t>(
      options_.samples.value_or(ends_itself ? unlimited_samples : preset_samples));
  request.emissivity = described.emission.has_value();
  request.team = &ranks_;
  request.stop = [] { return interrupt_flag().load(); };
  return request;
}

std::optional<std::uint64_t> SurfaceRun::lay_launches() const {
  if (!options_.lay_samples) return std::nullopt;
  return static_cast<std::uint64_t>(*options_.lay_samples);
}

std::uint64_t SurfaceRun::launches(const surface::Surface& described) const {
  if (!described.random) return 0;
  const auto chosen = lay_launches();
  return chosen ? *chosen : surface::launches_a_lay(described, request(described).samples);
}

std::uint64_t SurfaceRun::lays(const surface::Surface& described,
                               const trace::Result& result) const {
  return launches(described) > 0 ? result.blocks() : 1;
}

trace::Hemisphere SurfaceRun::hemisphere() const {
  return {options_.rings, options_.strip, optics::radians(options_.strip_half_width_deg)};
}

KeptRun SurfaceRun::kept(const std::vector<double>& theta_i_deg, const std::string& more) const {
  const std::string words =
      fmt::format("{} {} {} {} {} {} {} {}", scene_digest(options_.scene), common_.seed,
                  fmt::join(theta_i_deg, " "), more, options_.rings, options_.strip,
                  options_.strip_half_width_deg, UMOV_VERSION);
  return {options_.state_file(), words, options_.resume, !options_.output.empty() && first_rank()};
}

std::string SurfaceRun::said(const trace::Progress& p) const {
  std::string text = fmt::format("{:.3g} launches, DHR ± {:.3f} %", static_cast<double>(p.samples),
                                 100.0 * p.dhr_relative_error);
  if (p.cell_relative_error > 0.0) {
    text += fmt::format(", cells ± {:.2f} %", 100.0 * p.cell_relative_error);
  }
  return text;
}

std::vector<trace::Result> SurfaceRun::simulate(const surface::Lays& lays) {
  const std::vector<double> theta = angles(lays.first());
  trace::Request request = this->request(lays.first());
  const std::uint64_t launches_a_lay = launches(lays.first());
  KeptRun kept = this->kept(theta, fmt::format("{} a lay", launches_a_lay));

  Progress progress("simulate", common_.quiet || !first_rank());
  std::vector<trace::Result> results;
  for (std::size_t i = 0; i < theta.size(); ++i) {
    request.theta_i = optics::radians(theta[i]);
    request.progress = [&](const trace::Progress& p) {
      progress.update(
          1000.0 * (static_cast<double>(i) + p.done) / static_cast<double>(theta.size()), 1000.0,
          fmt::format("{:g}°, {}", theta[i], said(p)));
      kept.under_way(i, p.result);
    };
    results.push_back(lays.simulate(hemisphere(), request, launches_a_lay, kept.begun(i)));
    kept.ended(i, results.back());
    interrupted_ = trace::stop_asked(request);
    if (interrupted_) break;
  }
  progress.finish();
  kept.finish(interrupted_);
  return results;
}

}  // namespace umov::cli
