// umov simulate surface: the polarised BRDF of a described surface by ray tracing.
#include "host/cli/simulate_surface.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "host/cli/interrupt.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/scene_digest.hpp"
#include "host/cli/simulate_mixture.hpp"
#include "host/cli/surface_run.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/table_csv_rows.hpp"
#include "host/formats/table_file.hpp"
#include "host/optics/angles.hpp"
#include "host/surface/brdf_export.hpp"
#include "host/surface/hemisphere_picture.hpp"
#include "host/surface/hemisphere_table.hpp"
#include "host/surface/lays.hpp"
#include "host/surface/radiance.hpp"
#include "host/surface/sim_h5.hpp"

namespace umov::cli {
namespace {

using nlohmann::ordered_json;
using surface::Directions;

struct Options : SurfaceOptions {
  Directions directions = Directions::both;
  bool mixture = false;
  std::string table, exr, png;
  std::optional<double> png_nm;  // else the wavelength in the middle
  std::string png_element = "m00";
  std::vector<double> coverage_factors{0.2, 0.4, 0.6, 0.8, 1.0};
};

ordered_json angle_summary(const surface::Surface& described, double theta_i_deg,
                           const trace::Result& result, std::uint64_t lays) {
  const trace::Ledger& ledger = result.ledger();
  ordered_json bands = ordered_json::array();
  for (std::size_t w = 0; w < described.scene.wavelengths_um.size(); ++w) {
    const trace::MuellerEstimate all = result.hemispherical(w);
    const trace::Estimate dop = result.hemispherical_dop(w);
    bands.push_back({{"wavelength_nm", formats::nanometres(described.scene.wavelengths_um[w])},
                     {"dhr", all.mean[0][0]},
                     {"dhr_u", all.error[0][0]},
                     {"hemispherical_dop", dop.mean},
                     {"hemispherical_dop_u", std::isfinite(dop.error) ? dop.error : 0.0},
                     {"absorbed", ledger.absorbed[w] / ledger.launched[w]},
                     {"lost", (ledger.lost[w] + ledger.below[w]) / ledger.launched[w]}});
  }
  if (described.emission) {
    const auto views = surface::viewed_radiance(result, described.scene, *described.emission);
    for (std::size_t w = 0; w < views.size(); ++w) {
      const surface::ViewedRadiance& v = views[w];
      bands[w]["emissivity"] = v.emissivity;
      bands[w]["emissivity_u"] = v.emissivity_u;
      bands[w]["radiance"] = {{"unit", "W/m^2/sr/um"},
                              {"emitted", v.emitted},
                              {"reflected_sky", v.reflected_sky},
                              {"reflected_sun", v.reflected_sun},
                              {"total", v.total},
                              {"total_u", v.total_u},
                              {"stokes_1", v.stokes_1}};
    }
  }
  return {{"theta_i_deg", theta_i_deg},
          {"samples", result.samples()},
          {"rays", ledger.rays},
          {"lays", lays},
          {"bands", bands}};
}

ordered_json summary(const Options& options, const SurfaceRun& work,
                     const surface::Surface& described, const std::vector<double>& theta,
                     const std::vector<trace::Result>& results) {
  ordered_json layers = ordered_json::array();
  for (const surface::Layer& layer : described.layers) {
    layers.push_back(
        {{"kind", layer.kind}, {"particles", layer.count}, {"coverage", layer.coverage}});
  }
  ordered_json angles = ordered_json::array();
  for (std::size_t i = 0; i < results.size(); ++i) {
    angles.push_back(
        angle_summary(described, theta[i], results[i], work.lays(described, results[i])));
  }
  ordered_json out = {{"scene", options.scene},
                      {"layers", layers},
                      {"covered", described.covered},
                      {"random", described.random},
                      {"angles", angles}};
  // One angle is also said without a list.
  if (results.size() == 1) out.update(angles[0]);
  return out;
}

// What the errors below are of, where that is not plain.
std::string errors_of(bool random, std::uint64_t lays) {
  if (!random) return "";
  if (lays > 1) return fmt::format(", {} lays; errors are of lays and rays", lays);
  return ", one lay; errors are of rays, another lay scatters too";
}

void print(const ordered_json& s) {
  for (const auto& layer : s["layers"]) {
    fmt::print("{} of {} cover {:.2f} %\n", layer["particles"].get<std::size_t>(),
               layer["kind"].get<std::string>(), 100.0 * layer["coverage"].get<double>());
  }
  for (const auto& angle : s["angles"]) {
    fmt::print("light from {:g}°: {} samples, {} rays{}\n", angle["theta_i_deg"].get<double>(),
               angle["samples"].get<std::uint64_t>(), angle["rays"].get<std::uint64_t>(),
               errors_of(s["random"].get<bool>(), angle["lays"].get<std::uint64_t>()));
    const bool emits = angle["bands"][0].contains("radiance");
    fmt::print("{:>9}  {:>18}  {:>20}  {:>9}{}\n", "nm", "DHR", "hemispherical DOP", "lost",
               emits ? "  emissivity   radiance [W/m2/sr/um]" : "");
    for (const auto& band : angle["bands"]) {
      fmt::print("{:9.1f}  {:8.5f} ± {:.5f}  {:9.5f} ± {:.5f}  {:9.1e}",
                 band["wavelength_nm"].get<double>(), band["dhr"].get<double>(),
                 band["dhr_u"].get<double>(), band["hemispherical_dop"].get<double>(),
                 band["hemispherical_dop_u"].get<double>(), band["lost"].get<double>());
      if (emits) {
        fmt::print("  {:10.5f}   {:.6g} ± {:.2g}", band["emissivity"].get<double>(),
                   band["radiance"]["total"].get<double>(),
                   band["radiance"]["total_u"].get<double>());
      }
      fmt::print("\n");
    }
  }
}

void append(formats::BrdfTable& all, formats::BrdfTable&& part) {
  const auto join = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  auto& p = all.points;
  const auto& q = part.points;
  join(p.theta_i_deg, q.theta_i_deg);
  join(p.theta_r_deg, q.theta_r_deg);
  join(p.phi_r_deg, q.phi_r_deg);
  join(p.wavelength_nm, q.wavelength_nm);
  join(p.polarizer_deg, q.polarizer_deg);
  join(p.analyzer_deg, q.analyzer_deg);
  join(p.brdf_per_sr, q.brdf_per_sr);
  join(p.brdf_u, q.brdf_u);
  join(p.used, q.used);
  join(all.dhr.wavelength_nm, part.dhr.wavelength_nm);
  join(all.dhr.theta_i_deg, part.dhr.theta_i_deg);
  join(all.dhr.dhr, part.dhr.dhr);
  join(all.dhr.dhr_u, part.dhr.dhr_u);
  auto& m = *all.mueller;
  const auto& n = *part.mueller;
  join(m.theta_i_deg, n.theta_i_deg);
  join(m.theta_r_deg, n.theta_r_deg);
  join(m.phi_r_deg, n.phi_r_deg);
  join(m.wavelength_nm, n.wavelength_nm);
  join(m.mueller, n.mueller);
  join(m.mueller_u, n.mueller_u);
  join(m.condition, n.condition);
  join(m.chi2, n.chi2);
  join(m.dof, n.dof);
  join(m.realisable_z, n.realisable_z);
}

// One file: the table that every command of the toolkit reads, and the whole hemispheres.
void write(const Options& options, const Common& common, const SurfaceRun& work,
           const surface::Surface& described, const std::vector<double>& theta,
           const std::vector<trace::Result>& results) {
  formats::BrdfTable table;
  for (std::size_t i = 0; i < results.size(); ++i) {
    formats::BrdfTable part =
        surface::brdf_table(results[i], described.scene, theta[i], options.directions);
    if (i == 0) {
      table = std::move(part);
    } else {
      append(table, std::move(part));
    }
  }
  table.keys = {{"scene_sha256", scene_digest(options.scene)},
                {"seed", std::to_string(common.seed)}};
  formats::Provenance provenance;
  provenance.program = "umov " UMOV_VERSION;
  provenance.command = common.command_line;
  formats::write_brdf_h5(options.output, table, provenance, [&](formats::Hdf5Builder& file) {
    for (std::size_t i = 0; i < results.size(); ++i) {
      const std::string path = i == 0 ? "/hemisphere" : fmt::format("/hemisphere_{}", i + 1);
      surface::add_hemisphere(file, path, results[i], described.scene,
                              {theta[i], common.seed, work.lays(described, results[i])},
                              described.emission);
    }
  });
}

// For whoever takes a reflectance as a table: chambers, the emulated instrument, other programs.
void write_as_table(const Options& options, const Common& common, const surface::Surface& described,
                    const std::vector<double>& theta, const std::vector<trace::Result>& results) {
  const brdf::GridTable table = surface::hemisphere_table(
      results, theta, described.scene.wavelengths_um, "simulated " + options.scene);
  formats::TableWriting writing;
  writing.program = "umov " UMOV_VERSION;
  writing.command = common.command_line;
  writing.notes = {
      fmt::format("simulated; means over cells of about {:.3g} deg, mirrored at the "
                  "plane of incidence",
                  90.0 / static_cast<double>(options.rings))};
  const bool csv = options.table.ends_with(".csv");
  formats::write_table(options.table, csv ? "table-csv" : "table", table, writing);
}

// Before anything is simulated.
void check_table_angles(const std::vector<double>& theta, const Common& common, bool first_rank) {
  if (!std::is_sorted(theta.begin(), theta.end(), std::less_equal<>()))
    throw Error("the angles of incidence of a table must rise",
                "name them in ascending order, each once: --theta-i 20,60");
  if (theta.size() == 1 && first_rank && !common.quiet)
    fmt::print(stderr,
               "note: a table of one incidence says the same of every other; "
               "--theta-i 0,20,40,60,75 gives it more\n");
}

// The wavelength that the picture is of.
std::size_t pictured(const Options& options, const surface::Surface& described) {
  const std::vector<double>& um = described.scene.wavelengths_um;
  if (!options.png_nm) return um.size() / 2;
  const auto found = std::find_if(
      um.begin(), um.end(), [&](double w) { return std::abs(1e3 * w - *options.png_nm) < 0.5; });
  if (found == um.end()) {
    throw Error(fmt::format("a picture at {:g} nm, which is not simulated", *options.png_nm),
                "choose a wavelength of the scene with --png-nm");
  }
  return static_cast<std::size_t>(found - um.begin());
}

// One picture an angle: where there are several, each with its angle in the name.
void write_pictures(const Options& options, std::size_t wavelength,
                    const surface::Surface& described, const std::vector<double>& theta,
                    const std::vector<trace::Result>& results) {
  const std::vector<double>& um = described.scene.wavelengths_um;
  if (!options.exr.empty()) surface::write_hemisphere_exr(options.exr, {results, theta, um});
  if (options.png.empty()) return;
  for (std::size_t i = 0; i < results.size(); ++i) {
    std::filesystem::path file = options.png;
    if (theta.size() > 1) {
      file.replace_filename(
          fmt::format("{}-{:g}deg{}", file.stem().string(), theta[i], file.extension().string()));
    }
    formats::replace_file(
        file, surface::hemisphere_png(results[i], theta[i], um[wavelength], wavelength,
                                      options.png_element[1] - '0', options.png_element[2] - '0'));
  }
}

void run(const Options& options, const Common& common) {
  for (const std::string& file : {options.table, options.output, options.exr, options.png}) {
    if (!file.empty()) require_product_output({options.scene}, file);
  }
  const Ranks ranks;
  if (options.mixture && !(options.table + options.exr + options.png).empty()) {
    throw Error("--mixture writes neither tables nor pictures",
                "leave --table, --exr and --png out, or simulate without --mixture");
  }
  if (options.mixture) return run_mixture(options, options.coverage_factors, common, ranks);
  const surface::Lays lays(surface::reader_of(options.scene), {.seed = common.seed});
  const surface::Surface& described = lays.first();
  SurfaceRun work(options, common, ranks);
  const std::size_t in_picture = pictured(options, described);
  const std::vector<double> theta = work.angles(described);
  if (!options.table.empty()) check_table_angles(theta, common, work.first_rank());
  catch_interrupts();
  const std::vector<trace::Result> results = work.simulate(lays);
  if (!work.first_rank()) return;
  if (!options.output.empty()) write(options, common, work, described, theta, results);
  write_pictures(options, in_picture, described, theta, results);
  if (!options.table.empty() && !work.interrupted()) {
    write_as_table(options, common, described, theta, results);
  }
  const ordered_json s = summary(options, work, described, theta, results);
  if (common.json) {
    fmt::print("{}\n", s.dump());
  } else {
    print(s);
  }
  if (!work.interrupted()) return;
  std::fflush(stdout);
  throw Interrupted(options.output.empty()
                        ? "stopped; what there is stands above, and nothing is kept without -o"
                        : fmt::format("stopped; {} holds what there is; the same command with "
                                      "--resume goes on",
                                      options.output));
}

}  // namespace

void add_simulate_surface(CLI::App& simulate, const Common& common) {
  auto* command = simulate.add_subcommand(
      "surface", "polarised BRDF of a rough, dirty or wet surface over the whole hemisphere");
  command->fallthrough();
  auto options = std::make_shared<Options>();
  command->add_option("scene", options->scene, "scene file (TOML; see host/surface/README.md)")
      ->required();
  command->add_option("-o,--output", options->output, "sim.h5 to write (also a brdf.h5)");
  command
      ->add_option("--theta-i", options->theta_i_deg,
                   "angles of incidence in degrees; else those of the scene, else 0")
      ->delimiter(',');
  command->add_option("--samples", options->samples,
                      "launches at most, an angle, rounded up to sixteen lays or blocks; 1e6 where "
                      "neither the scene nor another option ends the run");
  command
      ->add_option("--relative-error", options->relative_error_percent,
                   "stop when the DHR of every wavelength is known to so many percent (1 sigma); "
                   "else that of the scene")
      ->check(CLI::Range(0.0, 100.0));
  command
      ->add_option("--cell-error", options->cell_error_percent,
                   "stop when m00 of the cells of the hemisphere is known to so many percent (1 "
                   "sigma) at every wavelength; with --relative-error, when both are; else that of "
                   "the scene")
      ->check(CLI::Range(0.0, 100.0));
  command
      ->add_option(
          "--cell-percentile", options->cell_percentile,
          "--cell-error: so many percent of all cells are known as well or better; 50, the "
          "median, unless said otherwise")
      ->check(CLI::Range(1.0, 100.0));
  command
      ->add_option("--cell", options->cell_deg,
                   "--cell-error: THETA,PHI in degrees; the cell in this direction alone")
      ->delimiter(',');
  command->add_option(
      "--lay-samples", options->lay_samples,
      "launches after which particles and rough ground are laid anew, so that errors hold where "
      "they lie too; 0: one lay, errors of rays alone; unless said otherwise 4096 or more, fewer "
      "in short runs, 0 where laying takes longer than tracing");
  command->add_flag("--resume", options->resume,
                    "go on where Ctrl-C or a crash ended a run to the same output");
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
                   "of the table in the file: cells, strip or both; both hold the same light")
      ->transform(CLI::CheckedTransformer(std::map<std::string, Directions>{
          {"cells", Directions::cells}, {"strip", Directions::strip}, {"both", Directions::both}}));
  command->add_option("--table", options->table,
                      "also write the BRDF as a table over all angles of incidence: .csv for the "
                      "emulated instrument (umov emulator --sample FILE.csv), else table.h5");
  command->add_option("--exr", options->exr,
                      "the hemispheres as polar maps in OpenEXR: a channel for each angle, "
                      "wavelength and Mueller element");
  command->add_option("--png", options->png,
                      "a polar map with its scale; of several angles one each, FILE-20deg.png");
  command->add_option("--png-nm", options->png_nm,
                      "--png: wavelength; the one in the middle unless said otherwise");
  std::vector<std::string> elements;
  for (int e = 0; e < 16; ++e) elements.push_back(fmt::format("m{}{}", e / 4, e % 4));
  command
      ->add_option("--png-element", options->png_element,
                   "--png: m00, or another Mueller element as its share of m00")
      ->check(CLI::IsMember(elements))
      ->capture_default_str();
  command->add_flag("--mixture", options->mixture,
                    "linear mixing of the materials by area beside the simulation, at several "
                    "coverages; -o is then a JSON file");
  command
      ->add_option("--coverage-factors", options->coverage_factors,
                   "--mixture: multiples of the scene's coverages")
      ->delimiter(',')
      ->check(CLI::Range(1e-3, 1e3))
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  umov simulate surface dirt.toml --cell-error 3 -o dirt.h5   # the median cell to 3 %\n"
      "  umov simulate surface examples/surfaces/wet-dirt.toml --theta-i 20,60 -o wet.h5\n"
      "  mpirun -n 8 umov simulate surface scene.toml --relative-error 0.1 -o sim.h5");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
