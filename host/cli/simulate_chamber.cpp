// umov simulate chamber: luminance map and intensity distribution of a described luminaire.
#include "host/cli/simulate_chamber.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>

#include "host/chamber/advice.hpp"
#include "host/chamber/map_picture.hpp"
#include "host/chamber/result_file.hpp"
#include "host/chamber/scene_file.hpp"
#include "host/cli/interrupt.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/scene_digest.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/table_csv_rows.hpp"
#include "host/parallel/ranks/ranks.hpp"

namespace umov::cli {
namespace {

using chamber::Distribution;
using chamber::Map;
using nlohmann::ordered_json;

struct Options {
  std::string scene;
  std::string output, exr, png, ies, ldt, compare;
  double rays_per_pixel = 0.0;
  double rays = 0.0;
  bool advise = false;
  chamber::Tolerances tolerances;
};

ordered_json evenness_json(const Map& map) {
  const chamber::Evenness e = chamber::evenness(map);
  // Of the pixels that see light.
  std::vector<double> errors;
  for (std::size_t i = 0; i < map.luminance_se.size(); ++i)
    if (map.luminance_cd_m2[i] > 0.0) errors.push_back(map.luminance_se[i]);
  if (errors.empty()) errors.push_back(0.0);
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return {{"pixels", map.luminance_cd_m2.size()},
          {"max_cd_m2", e.maximum},
          {"mean_cd_m2", e.mean},
          {"min_cd_m2", e.minimum},
          {"uniformity", e.uniformity},
          {"median_se_cd_m2", *middle}};
}

ordered_json distribution_json(const Distribution& d) {
  ordered_json zones = ordered_json::array();
  const formats::Photometry p = d.photometry();
  for (int from = 0; from < 180; from += 10) {
    zones.push_back({{"from_deg", from}, {"lm", p.zonal_lm(from, from + 10)}});
  }
  return {{"source_lm", d.source_lm},
          {"out_lm", d.out_lm},
          {"out_se", d.out_se},
          {"efficiency", d.efficiency()},
          {"first_hit_fraction", d.first_hit_fraction},
          {"absorbed_fraction", d.absorbed_fraction},
          {"behind_fraction", d.behind_fraction},
          {"lost_fraction", d.lost_fraction},
          {"peak_cd", *std::max_element(d.intensity_cd.begin(), d.intensity_cd.end())},
          {"launches", d.rays_launched},
          {"rays", d.fate.work.rays},
          {"zonal", zones}};
}

/// Mean over the map, W/(m² sr nm).
ordered_json bands_json(const Map& map) {
  ordered_json bands = ordered_json::array();
  const auto pixels = static_cast<std::ptrdiff_t>(map.luminance_cd_m2.size());
  for (std::size_t b = 0; b < map.wavelengths_um.size(); ++b) {
    const auto from = map.radiance.begin() + static_cast<std::ptrdiff_t>(b) * pixels;
    bands.push_back({{"wavelength_nm", formats::nanometres(map.wavelengths_um[b])},
                     {"mean_radiance",
                      std::accumulate(from, from + pixels, 0.0) / static_cast<double>(pixels)}});
  }
  return bands;
}

void print(const ordered_json& s) {
  const auto number = [](const ordered_json& j, const char* key) { return j[key].get<double>(); };
  for (const char* part : {"map", "region"}) {
    if (!s.contains(part)) continue;
    const auto& m = s[part];
    fmt::print("{:<7} max {:.1f}  mean {:.1f}  min {:.1f} cd/m²  min/mean {:.3f}  1 σ {:.2f}\n",
               part, number(m, "max_cd_m2"), number(m, "mean_cd_m2"), number(m, "min_cd_m2"),
               number(m, "uniformity"), number(m, "median_se_cd_m2"));
  }
  if (s.contains("likeness")) {
    const auto& l = s["likeness"];
    fmt::print("against {}: NCC {:.2f} %  NRMSE {:.2f} %  mean deviation {:.2f} %\n",
               l["file"].get<std::string>(), 100.0 * number(l, "ncc"), 100.0 * number(l, "nrmse"),
               100.0 * number(l, "mean_deviation"));
  }
  if (s.contains("ugr")) {
    fmt::print("UGR {:.1f} by the map, {:.1f} by its mean\n", number(s["ugr"], "map"),
               number(s["ugr"], "uniform"));
  }
  if (s.contains("lid")) {
    const auto& d = s["lid"];
    fmt::print(
        "LID     {:.4f} of {:.4f} lm leave ({:.2f} % ± {:.2f}), {:.1f} % met a wall first, "
        "peak {:.4f} cd\n",
        number(d, "out_lm"), number(d, "source_lm"), 100.0 * number(d, "efficiency"),
        100.0 * number(d, "out_se") / number(d, "source_lm"),
        100.0 * number(d, "first_hit_fraction"), number(d, "peak_cd"));
  }
}

/// To be called on all ranks alike: Ctrl-C may have reached some of them only.
void stop_if_asked(const Ranks& ranks) {
  if (on_any_rank(&ranks, interrupt_flag().load()))
    throw Interrupted("the simulation was stopped; nothing is kept");
}

/// Simplifies the scene's surfaces and says how much of them it needs.
void advise(const Options& options, const Common& common, const Ranks& ranks,
            const chamber::Job& job) {
  Progress progress("advise", common.quiet || ranks.rank() != 0);
  chamber::AdviceRequest request;
  request.tolerances = options.tolerances;
  request.seed = common.seed;
  request.threads = ranks.threads(common.threads);
  request.team = &ranks;
  request.progress = [&](double share) {
    stop_if_asked(ranks);
    progress.update(1000.0 * share, 1000.0);
  };
  const chamber::Advice advice = chamber::advise(job, request);
  progress.finish();
  if (ranks.rank() != 0) return;
  if (common.json) {
    ordered_json rows = ordered_json::array();
    for (const chamber::Ablation& a : advice.ablations) {
      ordered_json row = {{"surface", a.surface}, {"knows", a.knows}, {"readings", a.readings}};
      if (a.intensity) row["intensity_rms_of_peak"] = *a.intensity;
      if (a.luminance) row["luminance_nrmse"] = *a.luminance;
      if (a.ncc) row["luminance_ncc"] = *a.ncc;
      if (a.ugr) row["ugr"] = *a.ugr;
      rows.push_back(std::move(row));
    }
    const ordered_json out = {{"ablations", rows}, {"advice", advice.sentences}};
    fmt::print("{}\n", out.dump());
    return;
  }
  const auto cell = [](const std::optional<double>& value, double scale) {
    return value ? fmt::format("{:.2f}", scale * *value) : std::string("-");
  };
  fmt::print("{:<12} {:<42} {:>8} {:>10} {:>10} {:>8} {:>6}\n", "surface", "what is known of it",
             "readings", "LID %", "NRMSE %", "NCC %", "UGR");
  for (const chamber::Ablation& a : advice.ablations) {
    fmt::print("{:<12} {:<42} {:>8} {:>10} {:>10} {:>8} {:>6}\n", a.surface, a.knows, a.readings,
               cell(a.intensity, 100.0), cell(a.luminance, 100.0), cell(a.ncc, 100.0),
               cell(a.ugr, 1.0));
  }
  for (const std::string& sentence : advice.sentences) fmt::print("{}\n", sentence);
}

void run(const Options& options, const Common& common) {
  for (const std::string& file :
       {options.output, options.exr, options.png, options.ies, options.ldt}) {
    if (!file.empty()) require_product_output({options.scene}, file);
  }
  const bool writes_or_compares =
      !(options.output + options.exr + options.png + options.ies + options.ldt + options.compare)
           .empty();
  if (options.advise && (writes_or_compares || options.rays_per_pixel > 0.0 || options.rays > 0.0))
    throw Error("--advise writes no files, compares with none and counts its rays itself",
                "umov simulate chamber scene.toml --advise [--tolerance-…] [--json]");
  const Ranks ranks;
  chamber::Job job = chamber::read_job(options.scene);
  if (options.rays_per_pixel > 0.0) {
    job.map.rays_per_pixel = static_cast<std::uint64_t>(options.rays_per_pixel);
  }
  if (options.rays > 0.0 && job.distribution) {
    job.distribution->rays = static_cast<std::uint64_t>(options.rays);
  }
  const auto needs = [](bool there, const std::string& file, const char* table) {
    if (!file.empty() && !there) {
      throw Error(file + " cannot be written: the scene has no [" + table + "]",
                  std::string("add [") + table + "] to the scene");
    }
  };
  needs(job.camera.has_value(), options.exr, "camera");
  needs(job.camera.has_value(), options.png, "camera");
  needs(job.distribution.has_value(), options.ies, "goniophotometer");
  needs(job.distribution.has_value(), options.ldt, "goniophotometer");
  catch_interrupts();
  if (options.advise) return advise(options, common, ranks, job);
  Progress progress("simulate", common.quiet || ranks.rank() != 0);
  const auto watched = [&](const char* what) {
    return [&progress, &ranks, what](double share) {
      stop_if_asked(ranks);
      progress.update(1000.0 * share, 1000.0, what);
    };
  };
  const chamber::Tracer tracer(job.luminaire);
  chamber::Result result;
  ordered_json s = {{"scene", options.scene}, {"seed", common.seed}};
  if (job.camera) {
    job.map.seed = common.seed;
    job.map.threads = ranks.threads(common.threads);
    job.map.team = &ranks;
    job.map.progress = watched("map");
    result.map = chamber::luminance_map(tracer, *job.camera, job.map);
    s["map"] = evenness_json(*result.map);
    s["map"]["rays"] = result.map->work.rays;
    s["map"]["paths_given_up"] = result.map->work.endless;
    if (job.luminaire.bands) s["map"]["bands"] = bands_json(*result.map);
    if (job.region) s["region"] = evenness_json(chamber::cut(*result.map, *job.region));
    if (job.glare) {
      const chamber::GlareRating rating = chamber::glare_rating(*result.map, *job.glare);
      s["ugr"] = {{"map", rating.ugr_map}, {"uniform", rating.ugr_uniform}};
    }
  }
  if (job.distribution) {
    job.distribution->seed = common.seed;
    job.distribution->threads = ranks.threads(common.threads);
    job.distribution->team = &ranks;
    job.distribution->progress = watched("distribution");
    result.distribution = chamber::intensity_distribution(tracer, *job.distribution);
    s["lid"] = distribution_json(*result.distribution);
    if (job.luminaire.bands) s["lid"]["spectrum_out_w_nm"] = result.distribution->fate.spectrum_out;
  }
  progress.finish();
  if (ranks.rank() != 0) return;
  if (!options.compare.empty()) {
    const chamber::Result other = chamber::read_sim_h5(options.compare);
    if (!other.map || !result.map) {
      throw Error(Place{options.compare}, "there are no two maps to compare",
                  "simulate both with a [camera]");
    }
    const auto part = [&](const Map& map) {
      return job.region ? chamber::cut(map, *job.region) : map;
    };
    const chamber::Likeness l = chamber::likeness(part(*other.map), part(*result.map));
    s["likeness"] = {{"file", options.compare},
                     {"ncc", l.ncc},
                     {"nrmse", l.nrmse},
                     {"mean_deviation", l.mean_deviation}};
  }
  if (!options.output.empty()) {
    result.keys = {{"scene_sha256", scene_digest(options.scene)},
                   {"seed", std::to_string(common.seed)}};
    formats::Provenance provenance;
    provenance.program = "umov " UMOV_VERSION;
    provenance.command = common.command_line;
    chamber::write_sim_h5(options.output, result, provenance);
  }
  if (!options.exr.empty()) chamber::write_map_exr(options.exr, *result.map);
  if (!options.png.empty()) formats::replace_file(options.png, chamber::map_png(*result.map));
  if (!options.ies.empty() || !options.ldt.empty()) {
    formats::Photometry photometry = result.distribution->photometry();
    photometry.maker = "umov " UMOV_VERSION;
    photometry.name = options.scene;
    photometry.report = "simulated";
    photometry.length_mm = job.luminaire.opening_diameter_mm;
    if (!options.ies.empty()) formats::replace_file(options.ies, formats::ies_text(photometry));
    if (!options.ldt.empty()) {
      formats::replace_file(options.ldt, formats::eulumdat_text(photometry));
    }
  }
  if (common.json) {
    fmt::print("{}\n", s.dump());
  } else {
    print(s);
  }
}

}  // namespace

void add_simulate_chamber_command(CLI::App& simulate, const Common& common) {
  auto* command = simulate.add_subcommand(
      "chamber", "luminance map and intensity distribution of a luminaire of any surfaces");
  command->fallthrough();
  auto options = std::make_shared<Options>();
  command->add_option("scene", options->scene, "scene file (TOML; see host/chamber/README.md)")
      ->required();
  command->add_option("-o,--output", options->output, "sim.h5 to write");
  command->add_option("--exr", options->exr, "the map as OpenEXR, cd/m2");
  command->add_option("--png", options->png, "the map as a picture with its scale");
  command->add_option("--ies", options->ies, "the distribution as IES LM-63");
  command->add_option("--ldt", options->ldt, "the distribution as EULUMDAT");
  command->add_option("--compare", options->compare,
                      "a sim.h5 whose map this one is compared with (NCC, NRMSE)");
  command->add_option("--rays-per-pixel", options->rays_per_pixel, "instead of the scene's")
      ->check(CLI::Range(2.0, 1e9));
  command->add_option("--rays", options->rays, "of the distribution, instead of the scene's")
      ->check(CLI::Range(64.0, 1e12));
  command->add_flag("--advise", options->advise,
                    "instead: how much of the surfaces' BRDF does this luminaire need?");
  command
      ->add_option("--tolerance-lid", options->tolerances.intensity,
                   "for --advise: rms error of the intensities over the peak")
      ->check(CLI::Range(1e-4, 1.0))
      ->capture_default_str();
  command
      ->add_option("--tolerance-luminance", options->tolerances.luminance,
                   "for --advise: NRMSE of the map")
      ->check(CLI::Range(1e-4, 1.0))
      ->capture_default_str();
  command->add_option("--tolerance-ugr", options->tolerances.ugr, "for --advise: units of UGR")
      ->check(CLI::Range(1e-3, 100.0))
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  umov simulate chamber examples/chambers/mixing-chamber.toml --png map.png --ies lamp.ies\n"
      "  mpirun -n 8 umov simulate chamber lamp.toml -o sim.h5");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
