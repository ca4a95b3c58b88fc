// umov model check: energy, reciprocity, realisability and sampling of a model, as numbers.
#include "host/cli/model_check.hpp"

#include <Random123/philox.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/brdf/checks.hpp"
#include "host/brdf/dhr.hpp"
#include "host/brdf/sampler.hpp"
#include "host/cli/model_values.hpp"
#include "host/cli/progress.hpp"
#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::cli {
namespace {

using nlohmann::ordered_json;

struct Options {
  std::string name;
  std::vector<std::string> settings;
  double wavelength_nm = 632.8;
  std::vector<double> theta_i_deg{0, 15, 30, 45, 60, 70, 75, 80, 85, 89};
  bool lossless = false;
  int geometries = 2000;
  int draws = 20000;
};

/// Reflectances at one incidence, mirror part included.
struct Energy {
  double theta_i_deg;
  brdf::Dhr total;
  double mirror;

  double greatest() const { return std::max(total.s, total.p); }
};

/// What drawing directions costs in accuracy.
struct Sampling {
  double theta_i_deg;
  double mean;            ///< of the weights: the reflectance
  double standard_error;  ///< of the mean
  double spread;          ///< standard deviation of the weights over their mean
  double greatest;        ///< weight over the mean
  double nothing;         ///< share of draws that leave the upper hemisphere
  double mirror;          ///< probability of the mirror direction
  double per_second;      ///< draws, in seconds of this processor's time
};

Energy energy(const ModelValues& m, double wavelength_um, double theta_i_deg) {
  const double theta_i = optics::radians(theta_i_deg);
  const brdf::Dhr lobe = brdf::dhr(m.model, m.values, wavelength_um, theta_i);
  const brdf::Dhr mirror = brdf::mirror_dhr(m.model, m.values, wavelength_um, theta_i);
  brdf::Dhr total = lobe;
  total.unpolarized += mirror.unpolarized;
  total.s += mirror.s;
  total.p += mirror.p;
  return {theta_i_deg, total, mirror.unpolarized};
}

Sampling sampling(const brdf::Sampler& sampler, double theta_i_deg, int draws, std::uint64_t seed) {
  const double theta_i = optics::radians(theta_i_deg);
  const r123::Philox4x64 generator;
  const auto uniform = [](std::uint64_t bits) {
    return static_cast<double>(bits >> 11) / 9007199254740992.0;
  };
  double sum = 0.0, squares = 0.0, greatest = 0.0;
  int nothing = 0;
  const std::clock_t start = std::clock();
  for (int i = 0; i < draws; ++i) {
    const auto bits = generator({{static_cast<std::uint64_t>(i), 0, 0, 0}}, {{seed, 0}});
    const auto sample =
        sampler.sample(theta_i, uniform(bits[0]), uniform(bits[1]), uniform(bits[2]));
    if (!sample) {
      ++nothing;
      continue;
    }
    const double weight = optics::element(sample->weight, 0, 0);
    sum += weight;
    squares += weight * weight;
    greatest = std::max(greatest, weight);
  }
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  const double mean = sum / draws;
  const double deviation = std::sqrt(std::max(0.0, squares / draws - mean * mean));
  const double scale = mean > 0.0 ? 1.0 / mean : 0.0;
  return {theta_i_deg,
          mean,
          deviation / std::sqrt(static_cast<double>(draws)),
          deviation * scale,
          greatest * scale,
          static_cast<double>(nothing) / draws,
          sampler.mirror_probability(theta_i),
          seconds > 0.0 ? draws / seconds : 0.0};
}

ModelValues chosen(const Options& options) {
  ModelValues m = model_values(options.name, options.settings);
  if (m.model.needs_table()) brdf::refuse_missing_table(m.model);
  if (!options.lossless) return m;
  const auto without_loss = brdf::lossless(m.model, m.values);
  if (!without_loss) {
    throw Error("model '" + m.model.name() + "' has no setting without loss",
                "its parameters don't say what it absorbs: leave out --lossless");
  }
  return {m.model, *without_loss};
}

ordered_json as_json(const brdf::WorstCase& worst) {
  return {{"violation", worst.amount},
          {"theta_i_deg", optics::degrees(worst.geometry.theta_i)},
          {"theta_r_deg", optics::degrees(worst.geometry.theta_r)},
          {"phi_r_deg", optics::degrees(worst.geometry.phi_r)}};
}

std::string as_text(const brdf::WorstCase& worst, double limit, const char* good) {
  if (worst.amount <= limit) return fmt::format("{} (worst {:.1e})", good, worst.amount);
  return fmt::format(
      "violated by {:.3g} of m00 at theta_i {:.1f}, theta_r {:.1f}, phi_r {:.1f} degrees",
      worst.amount, optics::degrees(worst.geometry.theta_i),
      optics::degrees(worst.geometry.theta_r), optics::degrees(worst.geometry.phi_r));
}

void check(const Options& options, const Common& common) {
  const double wavelength_um = checked_wavelength_um(options.wavelength_nm);
  for (const double angle : options.theta_i_deg) checked_incidence(angle);
  const ModelValues m = chosen(options);

  Progress progress("checking " + m.model.name(), common.quiet);
  const double steps = 2.0 * static_cast<double>(options.theta_i_deg.size()) + 2.0;
  double done = 0.0;
  const auto step = [&] { progress.update(++done, steps); };
  std::vector<Energy> energies;
  for (const double angle : options.theta_i_deg) {
    energies.push_back(energy(m, wavelength_um, angle));
    step();
  }
  const brdf::WorstCase reciprocity =
      brdf::reciprocity_violation(m.model, m.values, wavelength_um, options.geometries);
  step();
  const brdf::WorstCase realisability =
      brdf::realisability_violation(m.model, m.values, wavelength_um, options.geometries);
  step();
  std::vector<Sampling> samplings;
  double preparation_s = 0.0;
  if (options.draws > 0) {
    const std::clock_t start = std::clock();
    const brdf::Sampler sampler(m.model, m.values, wavelength_um);
    preparation_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    for (const double angle : options.theta_i_deg) {
      samplings.push_back(sampling(sampler, angle, options.draws, common.seed));
      step();
    }
  }
  progress.finish();

  double greatest = 0.0, greatest_at = 0.0;
  for (const Energy& e : energies) {
    if (e.greatest() <= greatest) continue;
    greatest = e.greatest();
    greatest_at = e.theta_i_deg;
  }
  if (common.json) {
    ordered_json values = ordered_json::object();
    for (std::size_t i = 0; i < m.values.size(); ++i)
      values[m.model.parameters()[i].name] = m.values[i];
    ordered_json energy_rows = ordered_json::array(), sampling_rows = ordered_json::array();
    for (const Energy& e : energies) {
      energy_rows.push_back({{"theta_i_deg", e.theta_i_deg},
                             {"total", e.total.unpolarized},
                             {"total_s", e.total.s},
                             {"total_p", e.total.p},
                             {"mirror", e.mirror}});
    }
    for (const Sampling& s : samplings) {
      sampling_rows.push_back({{"theta_i_deg", s.theta_i_deg},
                               {"mean", s.mean},
                               {"standard_error", s.standard_error},
                               {"relative_standard_error_1e5", s.spread / std::sqrt(1e5)},
                               {"greatest_weight_over_mean", s.greatest},
                               {"nothing", s.nothing},
                               {"mirror_probability", s.mirror},
                               {"draws_per_cpu_s", s.per_second}});
    }
    fmt::print("{}\n", ordered_json{{"model", m.model.name()},
                                    {"parameters", values},
                                    {"wavelength_nm", options.wavelength_nm},
                                    {"lossless", options.lossless},
                                    {"energy", energy_rows},
                                    {"greatest_reflectance", greatest},
                                    {"reciprocity", as_json(reciprocity)},
                                    {"realisability", as_json(realisability)},
                                    {"sampling", sampling_rows},
                                    {"preparation_cpu_s", preparation_s},
                                    {"draws", options.draws},
                                    {"geometries", options.geometries}}
                           .dump());
    return;
  }
  fmt::print("{}", m.model.name());
  for (std::size_t i = 0; i < m.values.size(); ++i)
    fmt::print("{} {}={:g}", i == 0 ? ":" : ",", m.model.parameters()[i].name, m.values[i]);
  fmt::print(
      "\n\nreflectance, mirror part included\n  theta_i   unpolarised          s          p     "
      "mirror\n");
  for (const Energy& e : energies) {
    fmt::print("{:9g}  {:12.6f} {:10.6f} {:10.6f} {:10.6f}\n", e.theta_i_deg, e.total.unpolarized,
               e.total.s, e.total.p, e.mirror);
  }
  fmt::print("energy: {}\n",
             greatest <= 1.0 + 2e-6
                 ? std::string("never more light out than in at these incidences")
                 : fmt::format("violated, {:.4g} times the light at theta_i {:g} degrees", greatest,
                               greatest_at));
  fmt::print("reciprocity: {}\n", as_text(reciprocity, 1e-6, "kept"));
  fmt::print("realisability: {}\n", as_text(realisability, 1e-9, "kept"));
  if (samplings.empty()) return;
  fmt::print(
      "\nsampling, {} draws each\n  theta_i   reflectance  rel. error of 1e5   greatest weight   "
      "nothing\n",
      options.draws);
  for (const Sampling& s : samplings) {
    fmt::print("{:9g}  {:12.6f}  {:17.5f}  {:16.2f}  {:8.4f}\n", s.theta_i_deg, s.mean,
               s.spread / std::sqrt(1e5), s.greatest, s.nothing);
  }
}

}  // namespace

void add_model_check(CLI::App& model, const Common& common) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = model.add_subcommand(
      "check", "does it keep energy, reciprocity and realisability, and by how much not");
  command->add_option("name", options->name, "model, or sum such as microfacet+nef")->required();
  command
      ->add_option("--set", options->settings,
                   "parameter, choice or file, NAME=VALUE; repeatable (umov model show NAME lists "
                   "them)")
      ->allow_extra_args(false);
  command->add_option("--wavelength-nm", options->wavelength_nm, "vacuum wavelength, nm")
      ->capture_default_str();
  command->add_option("--theta-i", options->theta_i_deg, "incidences, degrees")
      ->delimiter(',')
      ->capture_default_str();
  command->add_flag("--lossless", options->lossless,
                    "take all absorption out first (a nearly perfect conductor, albedos 1)");
  command
      ->add_option("--geometries", options->geometries,
                   "directions tried for reciprocity and realisability")
      ->check(CLI::Range(1, 10000000))
      ->capture_default_str();
  command
      ->add_option("--draws", options->draws, "directions drawn at each incidence; 0: no sampling")
      ->check(CLI::Range(0, 100000000))
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  umov model check microfacet --set slope_rms=0.3 --lossless\n"
      "  umov model check li-torrance --set k_uds=0.5 --theta-i 0,45,80 --json");
  command->callback([options, &common] { check(*options, common); });
  command->fallthrough();
}

}  // namespace umov::cli
