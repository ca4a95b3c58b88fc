#include "host/cli/study/reflectometer.hpp"

#include <array>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "host/calibrate/reduce.hpp"
#include "host/cli/emulator/truth.hpp"
#include "host/cli/study/embedded_plans.hpp"
#include "host/cli/study/reflectometer_parts.hpp"
#include "host/formats/scan_h5.hpp"

namespace umov::study {
namespace {

/// In the order of measurement. White and grey standards first, while the bench is freshly known;
/// the red paint next, as most depends on it.
constexpr std::array scans{
    StudyScan{"white-99", "white-99", "white-99", 0.27},
    StudyScan{"white-70", "white-70", "white-70", 0.05},
    StudyScan{"white-50", "white-50", "white-50", 0.05},
    StudyScan{"white-99-again", "white-again", "white-99", 0.05},
    StudyScan{"red-gloss", "red-paint", "red-gloss", 0.42},
    StudyScan{"germanium", "germanium", "germanium", 0.07},
    StudyScan{"black-matte", "black-paint", "black-matte", 0.03},
    StudyScan{"black-semi-gloss", "black-paint", "black-semi-gloss", 0.03},
    StudyScan{"black-gloss", "black-paint", "black-gloss", 0.03},
};

constexpr double warm_up_s = 3600;
/// Times that everything is measured, with seeds in succession.
constexpr int benches = 5;
/// Share of the whole study's time that measuring takes; the rest evaluates.
constexpr double measuring = 0.6;

void measure_all(Bench& bench) {
  double from = 0;
  for (const StudyScan& scan : scans) {
    bench.measure(scan.name, embedded_plan(scan.plan), scan.sample, measuring * from,
                  measuring * (from + scan.share));
    from += scan.share;
  }
}

calibrate::CampaignOptions campaign_options(const Bench& bench,
                                            const std::filesystem::path& certificate) {
  calibrate::CampaignOptions options;
  for (const char* name : {"white-99", "white-70", "white-50", "germanium", "red-gloss"})
    options.scans.push_back(bench.file(name));
  options.standard = "white 99";
  options.reciprocity_scan = "white 99";
  options.reference_brdf = {{"white 99", certificate}};
  options.declared = declared_doubts();
  return options;
}

CalibratedBench calibrate_bench(Bench& bench, const std::filesystem::path& folder) {
  const auto certificate = folder / "white-99.csv";
  emulator::write_certificate("white-99", certificate);
  auto options = campaign_options(bench, certificate);
  const auto files = calibrate::read_campaign_scans(options);
  auto campaign = calibrate::evaluate_campaign(files, options);
  options.reference_brdf.clear();
  calibrate::CampaignSteps steps;
  steps.checks = false;
  steps.polarization = campaign.calibration.polarization;
  auto lambertian = calibrate::evaluate_campaign(files, options, steps).calibration;
  return {bench, std::move(campaign), std::move(lambertian), {}};
}

void introduce(Page& page, const Options& options) {
  page.paragraph(fmt::format(
      "The instrument of the reflectometer paper, emulated and operated as described there: "
      "standards, wafer and paints are measured by `umov scan` on one emulated bench with the "
      "imperfections of the preset `realistic` (seed {}), calibrated as one campaign, reduced and "
      "inverted with the functions behind `umov calibrate --campaign`, `reduce` and `invert`. "
      "Nothing that evaluates a measurement knows the truth; the columns named so come from the "
      "emulator's own sample models, free of noise.",
      options.seed));
  page.paragraph(
      "The paper's numbers stand beside ours as printed. The samples are stand-ins of like kind, "
      "not its very samples: agreement between the columns shows that the same kind of instrument "
      "and evaluation gives the same kind of result, no more.");
}

void close(Page& page, CalibratedBench& at, const Options& options) {
  page.heading("What must hold");
  page.targets(at.targets);
  if (!at.campaign.missing.empty()) {
    page.paragraph("What the calibration says it lacks:");
    page.list(at.campaign.missing);
  }
  page.paragraph(fmt::format(
      "{} records in {:.1f} h of instrument time, the lasers warm for one hour before. Command "
      "`{}`.",
      at.bench.records(), at.bench.instrument_time_s() / 3600, options.command));
  page.numbers()["records"] = at.bench.records();
  page.numbers()["seed"] = options.seed;
}

/// The whole way on one bench.
void run_bench(Page& page, const Options& options) {
  const auto say = [&](double share, const char* what) {
    if (options.keep_going && !options.keep_going()) throw Stopped{};
    if (options.progress) options.progress(share, what);
  };
  introduce(page, options);
  Bench bench(options, options.folder / "scans", "realistic", "white-99");
  bench.wait(warm_up_s);
  measure_all(bench);
  say(measuring, "calibration");
  CalibratedBench at = calibrate_bench(bench, options.folder);
  say(0.7, "standards");
  add_standards(page, at);
  add_polarizers_and_reciprocity(page, at);
  add_black_paints(page, at);
  say(0.75, "inversion");
  add_red_paint(page, at, options);
  close(page, at, options);
}

/// The same with other seeds: another noise, other drifts, the same imperfections.
void add_other_benches(Page& page, const Options& options) {
  std::vector<std::vector<std::string>> rows;
  auto& numbers = page.numbers()["benches"];
  const auto add = [&](const Json& found) {
    rows.push_back({fmt::format("{}", found["seed"].get<std::uint64_t>()),
                    percent(found["table_2_mean_error"]),
                    fmt::format("{:.3f}°", found["polarizer_axis_error_deg"].get<double>()),
                    percent(found["extinction_relative_error"], 1),
                    percent(found["reciprocity_mean_absolute"]),
                    percent(found["dhr_worst_relative_error"]),
                    percent(found["full_brdf_all"]["median"]),
                    percent(found["full_brdf_all"]["p90"]), percent(found["full_brdf_all"]["max"]),
                    fmt::format("{} of {}", found["intervals_held"]["held"].get<int>(),
                                found["intervals_held"]["of"].get<int>())});
    numbers.push_back({{"seed", found["seed"]},
                       {"full_brdf_all", found["full_brdf_all"]},
                       {"dhr_worst_relative_error", found["dhr_worst_relative_error"]},
                       {"intervals_held", found["intervals_held"]}});
  };
  add(page.numbers());
  for (int bench = 1; bench < benches; ++bench) {
    Options other = options;
    other.seed = options.seed + static_cast<std::uint64_t>(bench);
    other.folder = options.folder / fmt::format("seed-{}", other.seed);
    std::filesystem::create_directories(other.folder);
    if (options.progress)
      other.progress = [&, bench](double share, const std::string& what) {
        options.progress((bench + share) / benches, fmt::format("seed {}: {}", other.seed, what));
      };
    Page scratch("scratch", "");
    run_bench(scratch, other);
    add(scratch.numbers());
  }
  page.heading("Other seeds");
  page.paragraph(
      "The same bench with other noise and other drifts. What differs most is the slow noise of "
      "the lasers that the monitor misses (.3 %) between the standard's scan and the paint's: it "
      "goes into every reflectance. The intervals are those of n, slope, k_dd and k_udf + k_uds.");
  page.table({"seed", "table 2, mean error", "axes", "extinction", "reciprocity", "DHR, largest",
              "full BRDF, median", "90th percentile", "largest", "intervals that hold"},
             std::move(rows));
  int held = 0, all = 0;
  for (const auto& bench : numbers) {
    held += bench["intervals_held"]["held"].get<int>();
    all += bench["intervals_held"]["of"].get<int>();
  }
  page.paragraph(
      fmt::format("Together {} of {} intervals of 95 % hold the truth. The slope is the one most "
                  "in doubt: slow "
                  "noise within a sweep over a lobe widens or narrows it, by some .02 % as it "
                  "seems, and the fit "
                  "takes all noise for independent from point to point.",
                  held, all));
}

}  // namespace

calibrate::DeclaredDoubts declared_doubts() {
  calibrate::DeclaredDoubts declared;
  declared.theta_i_zero_u_deg = 0.1;
  declared.theta_r_zero_u_deg = 0.1;
  declared.sample_lean_u_deg = 0.05;
  declared.theta_r_eccentricity_u_deg = 0.02;
  declared.theta_r_play_u_deg = 0.02;
  declared.position_u_deg = 0.012;
  declared.source_relative_u = 0.003;
  declared.aperture_half_angle_deg = 0.323;  // a disc of the plans' solid angle, 1e-4 sr
  return declared;
}

formats::BrdfTable CalibratedBench::reduced(const std::string& name,
                                            const calibrate::ReduceOptions& options) const {
  const auto scan = formats::read_scan_h5(bench.file(name)).table;
  return calibrate::reduce(scan, campaign.calibration, options).table;
}

std::string percent(double share, int digits) {
  return fmt::format("{:.{}f} %", 100 * share, digits);
}

std::string fixed(double value, int digits) {
  return fmt::format("{:.{}f}", value, digits);
}

std::string with_u(double value, double u, int digits) {
  return fmt::format("{:.{}f} ± {:.{}f}", value, digits, u, digits);
}

Page reflectometer(const Options& options) {
  Options first = options;
  if (options.progress)
    first.progress = [&](double share, const std::string& what) {
      options.progress(share / benches, what);
    };
  Page page("reflectometer", "The reflectometer of the paper, repeated");
  run_bench(page, first);
  add_other_benches(page, options);
  return page;
}

}  // namespace umov::study
