#include "host/cli/simulate_mixture.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/cli/interrupt.hpp"
#include "host/cli/progress.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/table_csv_rows.hpp"
#include "host/surface/mixture_run.hpp"

namespace umov::cli {
namespace {

using nlohmann::ordered_json;

void put(ordered_json& to, const char* name, const trace::Estimate& e) {
  // JSON has no NaN: what is not defined is null.
  const auto number = [](double x) { return std::isfinite(x) ? ordered_json(x) : ordered_json(); };
  to[name] = number(e.mean);
  to[std::string(name) + "_u"] = number(e.error);
}

ordered_json as_json(const surface::MixingLaw& law) {
  if (law.points == 0) return nullptr;
  return {{"effective", "1-(1-f)^gamma"}, {"gamma", law.gamma}, {"gamma_u", law.gamma_u},
          {"points", law.points},         {"chi2", law.chi2},   {"largest_miss", law.largest_miss}};
}

ordered_json as_json(const surface::MixtureAngle& angle) {
  ordered_json points = ordered_json::array();
  for (const surface::MixturePoint& p : angle.points) {
    ordered_json point = {{"coverage", p.coverage}, {"lays", p.lays}};
    put(point, "area_fraction", p.fraction);
    put(point, "effective_fraction", p.effective);
    point["bands"] = ordered_json::array();
    for (const surface::MixtureBand& band : p.bands) {
      ordered_json b = {{"wavelength_nm", formats::nanometres(band.wavelength_um)}};
      put(b, "dhr", band.dhr);
      put(b, "dhr_linear", band.linear_dhr);
      put(b, "effective_fraction", band.effective);
      put(b, "hemispherical_dop", band.dop);
      put(b, "hemispherical_dop_linear", band.linear_dop);
      b["brdf_difference"] = band.shape_difference;
      point["bands"].push_back(b);
    }
    points.push_back(point);
  }
  ordered_json laws = ordered_json::array();
  for (std::size_t w = 0; w < angle.band_laws.size(); ++w) {
    laws.push_back(
        {{"wavelength_nm", formats::nanometres(angle.points.front().bands[w].wavelength_um)},
         {"law", as_json(angle.band_laws[w])}});
  }
  return {{"theta_i_deg", angle.theta_i_deg},
          {"law", as_json(angle.law)},
          {"points", points},
          {"laws", laws}};
}

void print(const surface::MixtureAngle& angle) {
  fmt::print("light from {:g}°, {}\n", angle.theta_i_deg,
             angle.points.front().lays > 1 ? "errors are of lays and rays"
                                           : "one lay, errors are of rays");
  fmt::print("{:>9} {:>9} {:>20} {:>26} {:>26} {:>10}\n", "coverage", "seen", "effective",
             "largest DHR - mixture", "largest DOP - mixture", "BRDF off");
  for (const surface::MixturePoint& p : angle.points) {
    // What stands out most, in its own errors.
    const auto worst = [&](auto member, auto linear) {
      const surface::MixtureBand* found = &p.bands.front();
      const auto off = [&](const surface::MixtureBand& b) {
        return std::abs((b.*member).mean - (b.*linear).mean);
      };
      for (const auto& b : p.bands) {
        if (off(b) > off(*found)) found = &b;
      }
      return fmt::format("{:+.5f} ± {:.5f}", (found->*member).mean - (found->*linear).mean,
                         std::hypot((found->*member).error, (found->*linear).error));
    };
    double off = 0.0;
    for (const auto& b : p.bands) off = std::max(off, b.shape_difference);
    fmt::print("{:9.4f} {:9.4f} {:10.4f} ± {:.4f}   {:>26} {:>26} {:8.1f} %\n", p.coverage,
               p.fraction.mean, p.effective.mean, p.effective.error,
               worst(&surface::MixtureBand::dhr, &surface::MixtureBand::linear_dhr),
               worst(&surface::MixtureBand::dop, &surface::MixtureBand::linear_dop), 100.0 * off);
  }
  if (angle.law.points > 0) {
    fmt::print("effective = 1 - (1 - seen)^{:.3f} ± {:.3f}, off by {:.3f} at most\n",
               angle.law.gamma, angle.law.gamma_u, angle.law.largest_miss);
  }
}

}  // namespace

void run_mixture(const SurfaceOptions& options, const std::vector<double>& coverage_factors,
                 const Common& common, const Ranks& ranks) {
  const SurfaceRun work(options, common, ranks);
  const surface::ReadSurface read = surface::reader_of(options.scene);
  const surface::Surface described = read({.seed = common.seed});
  surface::MixtureRequest request;
  request.theta_i_deg = work.angles(described);
  request.coverage_factors = coverage_factors;
  request.how = work.request(described);
  request.rings = options.rings;
  request.strip = options.strip;
  request.strip_half_width_deg = options.strip_half_width_deg;
  request.launches = work.lay_launches();
  KeptRun kept = work.kept(
      request.theta_i_deg,
      fmt::format(
          "mixture {}; {} a lay, {} launches, errors {} {}", fmt::join(coverage_factors, " "),
          request.launches ? std::to_string(*request.launches) : "preset", request.how.samples,
          request.how.dhr_relative_error, request.how.cells.relative_error));
  catch_interrupts();
  Progress progress("simulate", common.quiet || !work.first_rank());
  std::size_t at = 0;
  std::size_t of = 1;
  request.begin = [&](std::size_t number, std::size_t count) {
    at = number;
    of = count;
    return kept.begun(number);
  };
  request.ended = [&](std::size_t number, const trace::Result& result) {
    kept.ended(number, result);
  };
  request.how.progress = [&](const trace::Progress& p) {
    progress.update(1000.0 * (static_cast<double>(at) + p.done) / static_cast<double>(of), 1000.0,
                    fmt::format("simulation {} of {}, {}", at + 1, of, work.said(p)));
    kept.under_way(at, p.result);
  };
  const auto angles = surface::analyse_mixture(read, request);
  progress.finish();
  const bool interrupted = angles.size() < request.theta_i_deg.size();
  kept.finish(interrupted);
  if (!work.first_rank()) return;

  ordered_json out = {{"scene", options.scene},
                      {"seed", common.seed},
                      {"program", "umov " UMOV_VERSION},
                      {"command", common.command_line},
                      {"angles", ordered_json::array()}};
  for (const auto& angle : angles) out["angles"].push_back(as_json(angle));
  if (!options.output.empty()) formats::replace_file(options.output, out.dump(1) + "\n");
  if (common.json) {
    fmt::print("{}\n", out.dump());
  } else {
    for (const auto& angle : angles) print(angle);
  }
  if (!interrupted) return;
  std::fflush(stdout);
  throw Interrupted(options.output.empty()
                        ? "stopped; angles that were not whole are left out, and nothing is kept "
                          "without -o"
                        : "stopped; angles that were not whole are left out; the same command with "
                          "--resume goes on");
}

}  // namespace umov::cli
