#include "host/cli/surface_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "host/cli/interrupt.hpp"
#include "host/cli/model_values.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/scene_digest.hpp"
#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/surface/run_state.hpp"

namespace umov::cli {
namespace {

// Launches an angle where only an error or a number of rays ends it, and where nothing does.
constexpr double unlimited_samples = 1e15;
constexpr double preset_samples = 1e6;
constexpr std::chrono::seconds between_states{60};

}  // namespace

SurfaceRun::SurfaceRun(const SurfaceOptions& options, const Common& common, const Ranks& ranks)
    : options_(options), common_(common), ranks_(ranks) {
  if (options.samples && !(*options.samples >= 1.0 && *options.samples <= 1e15)) {
    throw Error(fmt::format("{} samples", *options.samples), "choose 1 to 1e15");
  }
  if (options.resume && options.output.empty()) {
    throw Error("nothing to resume without an output file", "name it with -o, as the first time");
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
  request.rays = static_cast<std::uint64_t>(described.stop.rays);
  const bool ends_itself = request.dhr_relative_error > 0.0 || request.rays > 0;
  request.samples = static_cast<std::uint64_t>(
      options_.samples.value_or(ends_itself ? unlimited_samples : preset_samples));
  request.emissivity = described.emission.has_value();
  request.team = &ranks_;
  request.stop = [] { return interrupt_flag().load(); };
  return request;
}

std::vector<trace::Result> SurfaceRun::simulate(const surface::Surface& described) {
  const trace::Geometry geometry(described.scene);
  const trace::PathTracer tracer(described.scene, geometry);
  const trace::Hemisphere hemisphere(options_.rings, options_.strip,
                                     optics::radians(options_.strip_half_width_deg));
  const std::vector<double> theta = angles(described);
  trace::Request request = this->request(described);

  const std::string run = fmt::format(
      "{} {} {} {} {} {} {} {}", scene_digest(options_.scene), common_.seed, fmt::join(theta, " "),
      request.block, options_.rings, options_.strip, options_.strip_half_width_deg, UMOV_VERSION);
  surface::RunState state;
  if (options_.resume) {
    state = surface::load_state(options_.state_file(), run);
    if (state.size() > theta.size()) state.resize(theta.size());
  }
  const bool keeps = !options_.output.empty() && first_rank();
  auto kept = std::chrono::steady_clock::now();

  Progress progress("simulate", common_.quiet || !first_rank());
  std::vector<trace::Result> results;
  for (std::size_t i = 0; i < theta.size(); ++i) {
    request.theta_i = optics::radians(theta[i]);
    request.progress = [&](const trace::Progress& p) {
      // What is left by the samples, the rays or the error asked for, whichever is sooner.
      double done = static_cast<double>(p.samples) / static_cast<double>(request.samples);
      if (request.dhr_relative_error > 0.0 && p.dhr_relative_error > 0.0) {
        done = std::max(done, std::pow(request.dhr_relative_error / p.dhr_relative_error, 2));
      }
      if (request.rays > 0) {
        done = std::max(
            done, static_cast<double>(p.result.ledger().rays) / static_cast<double>(request.rays));
      }
      const double angles_done = static_cast<double>(i) + std::min(1.0, done);
      progress.update(1000.0 * angles_done / static_cast<double>(theta.size()), 1000.0,
                      fmt::format("{:g}°, {:.3g} launches, DHR ± {:.3f} %", theta[i],
                                  static_cast<double>(p.samples), 100.0 * p.dhr_relative_error));
      if (keeps && std::chrono::steady_clock::now() - kept > between_states) {
        kept = std::chrono::steady_clock::now();
        state.resize(std::max(state.size(), i + 1));
        state[i] = p.result.state();
        surface::save_state(options_.state_file(), run, state);
      }
    };
    const std::vector<double> begun = i < state.size() ? state[i] : std::vector<double>{};
    results.push_back(trace::simulate(tracer, hemisphere, request, begun));
    state.resize(std::max(state.size(), i + 1));
    state[i] = results.back().state();
    // A signal may have reached some of the ranks only.
    interrupted_ = on_any_rank(&ranks_, interrupt_flag().load());
    if (interrupted_) break;
  }
  progress.finish();
  if (keeps) {
    std::error_code none;
    if (interrupted_) {
      surface::save_state(options_.state_file(), run, state);
    } else {
      std::filesystem::remove(options_.state_file(), none);
    }
  }
  return results;
}

}  // namespace umov::cli
