// umov simulate, and of it surface: the polarised BRDF of a described surface by ray tracing.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "host/cli/command.hpp"
#include "host/cli/interrupt.hpp"
#include "host/cli/model_values.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/simulate_chamber.hpp"
#include "host/errors/error.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/sha256.hpp"
#include "host/surface/brdf_export.hpp"
#include "host/surface/scene_file.hpp"
#include "host/trace/simulation.hpp"

namespace umov::cli {
namespace {

using nlohmann::ordered_json;
using surface::Directions;

struct Options {
  std::string scene;
  std::string output;
  double theta_i_deg = 0.0;
  double samples = 1e6;
  double relative_error_percent = 0.0;
  std::size_t rings = 18;
  std::size_t strip = 180;
  double strip_half_width_deg = 2.0;
  Directions directions = Directions::both;
};

ordered_json summary(const Options& options, const surface::Surface& described,
                     const trace::Result& result) {
  const trace::Ledger& ledger = result.ledger();
  ordered_json layers = ordered_json::array();
  for (const surface::Layer& layer : described.layers) {
    layers.push_back(
        {{"kind", layer.kind}, {"particles", layer.count}, {"coverage", layer.coverage}});
  }
  ordered_json bands = ordered_json::array();
  for (std::size_t w = 0; w < described.scene.wavelengths_um.size(); ++w) {
    const trace::MuellerEstimate all = result.hemispherical(w);
    const trace::Estimate dop = result.hemispherical_dop(w);
    bands.push_back({{"wavelength_nm", 1e3 * described.scene.wavelengths_um[w]},
                     {"dhr", all.mean[0][0]},
                     {"dhr_u", all.error[0][0]},
                     {"hemispherical_dop", dop.mean},
                     {"hemispherical_dop_u", std::isfinite(dop.error) ? dop.error : 0.0},
                     {"absorbed", ledger.absorbed[w] / ledger.launched[w]},
                     {"lost", (ledger.lost[w] + ledger.below[w]) / ledger.launched[w]}});
  }
  return {{"scene", options.scene}, {"theta_i_deg", options.theta_i_deg},
          {"layers", layers},       {"samples", result.samples()},
          {"rays", ledger.rays},    {"bands", bands}};
}

void print(const ordered_json& s) {
  for (const auto& layer : s["layers"]) {
    fmt::print("{} of {} cover {:.2f} %\n", layer["particles"].get<std::size_t>(),
               layer["kind"].get<std::string>(), 100.0 * layer["coverage"].get<double>());
  }
  fmt::print("{:>9}  {:>18}  {:>20}  {:>9}\n", "nm", "DHR", "hemispherical DOP", "lost");
  for (const auto& band : s["bands"]) {
    fmt::print("{:9.1f}  {:8.5f} ± {:.5f}  {:9.5f} ± {:.5f}  {:9.1e}\n",
               band["wavelength_nm"].get<double>(), band["dhr"].get<double>(),
               band["dhr_u"].get<double>(), band["hemispherical_dop"].get<double>(),
               band["hemispherical_dop_u"].get<double>(), band["lost"].get<double>());
  }
  fmt::print("{} samples, {} rays\n", s["samples"].get<std::uint64_t>(),
             s["rays"].get<std::uint64_t>());
}

void run(const Options& options, const Common& common) {
  if (!options.output.empty()) require_product_output({options.scene}, options.output);
  if (!(options.samples >= 1.0 && options.samples <= 1e15)) {
    throw Error(fmt::format("{} samples", options.samples), "choose 1 to 1e15");
  }
  trace::Request request;
  request.theta_i = checked_incidence(options.theta_i_deg);
  request.seed = common.seed;
  request.threads = common.threads;
  request.samples = static_cast<std::uint64_t>(options.samples);
  request.dhr_relative_error = 0.01 * options.relative_error_percent;
  const trace::Hemisphere hemisphere(options.rings, options.strip,
                                     optics::radians(options.strip_half_width_deg));
  const surface::Surface described = surface::read_surface(options.scene, common.seed);
  const trace::Geometry geometry(described.scene);
  const trace::PathTracer tracer(described.scene, geometry);

  catch_interrupts();
  Progress progress("simulate", common.quiet);
  request.progress = [&](const trace::Progress& p) {
    if (interrupt_flag().load()) throw Interrupted("the simulation was stopped; nothing is kept");
    // What is left by the number of samples or by the error asked for, whichever is sooner.
    double done = static_cast<double>(p.samples) / options.samples;
    if (request.dhr_relative_error > 0.0 && p.dhr_relative_error > 0.0) {
      done = std::max(done, std::pow(request.dhr_relative_error / p.dhr_relative_error, 2));
    }
    progress.update(1000.0 * std::min(1.0, done), 1000.0,
                    fmt::format("DHR ± {:.3f} %", 100.0 * p.dhr_relative_error));
  };
  const trace::Result result = trace::simulate(tracer, hemisphere, request);
  progress.finish();

  if (!options.output.empty()) {
    formats::BrdfTable table =
        surface::brdf_table(result, described.scene, request.theta_i, options.directions);
    table.keys = {{"scene_sha256", formats::sha256_of_file(options.scene)},
                  {"seed", std::to_string(common.seed)},
                  {"samples", std::to_string(result.samples())}};
    formats::Provenance provenance;
    provenance.program = "umov " UMOV_VERSION;
    provenance.command = common.command_line;
    formats::write_brdf_h5(options.output, table, provenance);
  }
  const ordered_json s = summary(options, described, result);
  if (common.json) {
    fmt::print("{}\n", s.dump());
  } else {
    print(s);
  }
}

}  // namespace

void add_simulate_command(CLI::App& root, const Common& common) {
  auto* simulate =
      root.add_subcommand("simulate", "what described things do to light, by ray tracing");
  simulate->require_subcommand(1);
  simulate->fallthrough();
  add_simulate_chamber_command(*simulate, common);
  auto* command = simulate->add_subcommand(
      "surface", "polarised BRDF of a rough, dirty or wet surface over the whole hemisphere");
  command->fallthrough();
  auto options = std::make_shared<Options>();
  command->add_option("scene", options->scene, "scene file (TOML; see host/surface/README.md)")
      ->required();
  command->add_option("-o,--output", options->output, "brdf.h5 to write");
  command->add_option("--theta-i", options->theta_i_deg, "angle of incidence in degrees")
      ->capture_default_str();
  command->add_option("--samples", options->samples, "launches at most")->capture_default_str();
  command
      ->add_option("--relative-error", options->relative_error_percent,
                   "stop when the DHR of every wavelength is known to so many percent (1 sigma)")
      ->check(CLI::Range(0.0, 100.0));
  command->add_option("--rings", options->rings, "rings of cells over 90 degrees")
      ->capture_default_str();
  command->add_option("--strip", options->strip, "cells of the in-plane strip over 180 degrees")
      ->capture_default_str();
  command
      ->add_option("--strip-half-width", options->strip_half_width_deg,
                   "degrees to each side of the plane of incidence")
      ->capture_default_str();
  command
      ->add_option("--directions", options->directions,
                   "written to the file: cells, strip or both; both hold the same light")
      ->transform(CLI::CheckedTransformer(std::map<std::string, Directions>{
          {"cells", Directions::cells}, {"strip", Directions::strip}, {"both", Directions::both}}));
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
