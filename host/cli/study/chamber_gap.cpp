#include "host/cli/study/chamber_gap.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "host/chamber/synthetic_mcpet.hpp"
#include "host/cli/study/chamber_runs.hpp"
#include "host/gap/chamber/chamber_model.hpp"
#include "host/gap/engine/diagnosis.hpp"

namespace umov::study {
namespace {

using chamber::Map;
using chamber::MixingChamber;

constexpr std::uint64_t rays_per_measured_pixel = 4000;
constexpr std::size_t joined = 5;  ///< pixels of 0.2 mm to one of 1 mm

/// What is done to the chamber without a word to the simulation.
struct Case {
  std::string withheld;  ///< the effect's name; empty: nothing; "?" what no catalogue has
  std::string how;
  std::function<void(MixingChamber&)> change;
};

std::vector<Case> cases() {
  const auto plastic = [](double rho) {
    return std::make_shared<const chamber::Surface>(
        "plastic",
        chamber::PlanesSurface(chamber::synthetic_mcpet(chamber::mcpet_theta_i_deg, 2.5), 0, rho));
  };
  return {
      {"", "nothing", [](MixingChamber&) {}},
      {"wall_absorption", "wall .964 instead of .984",
       [plastic](MixingChamber& c) { c.wall = plastic(0.964); }},
      {"source_position", "sources and holes moved by (.35, −.2) mm",
       [](MixingChamber& c) {
         c.shift_x_mm = 0.35;
         c.shift_y_mm = -0.2;
       }},
      {"source_depth", "sources .12 mm deeper", [](MixingChamber& c) { c.depth_mm += 0.12; }},
      {"source_exitance", "one source 8 % weaker, its opposite 8 % stronger",
       [](MixingChamber& c) {
         c.flux_lm[0] *= 0.92;
         c.flux_lm[2] *= 1.08;
       }},
      {"hole_edge_reflection", "edges reflect 25 %", [](MixingChamber& c) { c.edge_rho = 0.25; }},
      {"observer_angle", "observer at 55.8°", [](MixingChamber& c) { c.view_deg = 55.8; }},
      {"?", "a soiled stripe of 20° on the wall reflects 80 %",
       [](MixingChamber& c) {
         c.spot_width_deg = 20.0;
         c.spot_azimuth_deg = 60.0;
         c.spot_rho = 0.8;
       }},
  };
}

class GapStudy {
 public:
  explicit GapStudy(const Options& options)
      : options_(options), page_("chamber-gap", "What a luminance map says of its simulation") {}

  Page run() {
    page_.paragraph(fmt::format(
        "Command `{}`. The engine of `umov diagnose` (`host/gap/engine`) is given a luminance map "
        "of the mixing chamber of `studies/chamber.md` at 1 mm a pixel, its noise, a simulation, "
        "and how the simulated map changes with each of eight things that may be wrong. It is not "
        "told which. Lobes are tried at widths of .06, .085, .12, .17 and .24; the plastic has .1.",
        options_.command));
    models();
    blind_cases();
    targets();
    return std::move(page_);
  }

 private:
  static MixingChamber simulated(const WallModel& model) {
    MixingChamber c = known_chamber();
    c.wall = model.surface;
    return c;
  }

  std::shared_ptr<const gap::MapSignatures> signatures(const WallModel& model, double from,
                                                       double to) const {
    gap::MapOptions options;
    options.joined = joined;
    options.seed = options_.seed;
    options.threads = options_.threads;
    options.progress = [this, from, to, &model](double share) {
      step(options_, from + (to - from) * share, "signatures, " + model.title);
    };
    return std::make_shared<const gap::MapSignatures>(
        gap::map_signatures(simulated(model).described(), options));
  }

  Map measure(const MixingChamber& c, std::uint64_t seed) const {
    const chamber::Luminaire luminaire = c.luminaire();
    const chamber::Tracer tracer(luminaire);
    chamber::MapRequest request;
    request.rays_per_pixel = rays_per_measured_pixel / (joined * joined);
    request.seed = seed;
    request.threads = options_.threads;
    Map map = chamber::joined(chamber::luminance_map(tracer, c.camera(), request), joined);
    add_camera_noise(map, seed + 1);
    return map;
  }

  gap::Diagnosis diagnose(const gap::ChamberModel& model) const {
    gap::DiagnoseOptions how;
    how.search.seed = options_.seed;
    how.search.threads = options_.threads;
    return gap::diagnose(model, how);
  }

  static std::string named(const gap::Diagnosis& d) {
    std::vector<std::string> words;
    for (const gap::Cause& c : d.causes)
      words.push_back(fmt::format("`{}` ({}{:.2f})", c.effect,
                                  c.family.empty() ? "" : c.family + ", ", c.probability));
    for (const auto& set : d.ambiguity_sets)
      words.push_back(fmt::format("not to be told apart: {}", fmt::join(set, ", ")));
    return words.empty() ? "nothing" : fmt::format("{}", fmt::join(words, ", "));
  }

  static bool names(const gap::Diagnosis& d, const std::string& effect) {
    const auto is = [&](const gap::Cause& c) { return c.effect == effect; };
    return std::any_of(d.causes.begin(), d.causes.end(), is);
  }

  /// The worst cells where the measurement is brighter and where it is darker.
  static std::string where(const gap::Where& w) {
    std::vector<std::string> words;
    for (const bool brighter : {true, false}) {
      const auto cell = std::find_if(w.cells.begin(), w.cells.end(),
                                     [&](const gap::Cell& c) { return (c.z > 0.0) == brighter; });
      if (cell == w.cells.end()) continue;
      words.push_back(fmt::format("{} at {} {:.2g} to {:.2g}{}", brighter ? "brighter" : "darker",
                                  cell->axis, cell->from, cell->to,
                                  cell->unit == "1" ? "" : " " + cell->unit));
    }
    return words.empty() ? "nowhere" : fmt::format("{}", fmt::join(words, "; "));
  }

  /// Pixels as a map of one row, for figures of merit.
  static Map as_map(const Eigen::VectorXd& values) {
    Map map;
    map.width = static_cast<std::size_t>(values.size());
    map.height = 1;
    map.luminance_cd_m2.assign(values.data(), values.data() + values.size());
    map.luminance_se.assign(map.width, 0.0);
    return map;
  }

  // The measurement with all its details against the two simple models.
  void models() {
    page_.heading("The lobe that two models lack");
    const std::vector<WallModel> all = wall_models();
    std::vector<std::vector<std::string>> rows;
    for (std::size_t i = 0; i < 2; ++i) {
      const double from = 0.3 * static_cast<double>(i);
      const auto s = signatures(all[i], from, from + 0.25);
      const Map measured = measure(measured_chamber(), options_.seed + 500);
      const gap::ChamberModel model(s, measured);
      step(options_, from + 0.26, "diagnosis, " + all[i].title);
      const gap::Diagnosis d = diagnose(model);
      const Map seen = as_map(model.observations().value);
      const chamber::Likeness before = chamber::likeness(seen, as_map(s->mean));
      const chamber::Likeness after = chamber::likeness(seen, as_map(d.best.mean));
      named_lobe_[i] = names(d, "near_specular_lobe");
      rows.push_back({all[i].title, named(d), where(d.where),
                      fmt::format("{:.1f} → {:.1f}", 100.0 * before.ncc, 100.0 * after.ncc),
                      fmt::format("{:.2f} → {:.2f}", 100.0 * before.nrmse, 100.0 * after.nrmse),
                      fmt::format("{:.1f}", 100.0 * d.closed_fraction.value)});
      Json& n = page_.numbers()["models"][all[i].name];
      n = {{"ncc_before", before.ncc},     {"ncc_after", after.ncc},
           {"nrmse_before", before.nrmse}, {"nrmse_after", after.nrmse},
           {"where", where(d.where)},      {"verdict", gap::to_string(d.verdict)}};
      for (const gap::Cause& c : d.causes) n["named"].push_back(c.effect);
      improved_ = improved_ && after.ncc > before.ncc && after.nrmse < before.nrmse;
    }
    page_.table({"simulation", "named (probability)", "where the measurement is", "NCC %",
                 "NRMSE %", "of the gap closed %"},
                rows);
    page_.paragraph(
        "All pixels inside the opening, not only the region of [M]. `highlight` is the share of "
        "the strongest near-specular signature: 1 in the middle of a highlight. The lobe that is "
        "missing makes them brighter than the diffuse model says, and its scattered light the "
        "far wall (y 20 to 22 mm) than the diffuse/specular model, whose mirrored share has "
        "highlights of its own. Two widths of the lobe (α) together stand for one between. The "
        "other withheld details (position, depth, edges, angle, balance) are in the measurement "
        "too; what of them is named stands beside the lobe.");
  }

  void blind_cases() {
    page_.heading("One thing wrong with a good table");
    const WallModel table = wall_models()[2];
    const auto s = signatures(table, 0.6, 0.8);
    std::vector<std::vector<std::string>> rows;
    const std::vector<Case> all = cases();
    for (std::size_t i = 0; i < all.size(); ++i) {
      step(options_, 0.8 + 0.2 * static_cast<double>(i) / static_cast<double>(all.size()),
           all[i].how);
      MixingChamber c = simulated(table);
      all[i].change(c);
      const Map measured = measure(c, options_.seed + 600 + 10 * i);
      const gap::ChamberModel model(s, measured);
      const gap::Diagnosis d = diagnose(model);
      bool right = false;
      if (all[i].withheld.empty()) {
        right = d.causes.empty();
      } else if (all[i].withheld == "?") {
        right =
            d.verdict == gap::Verdict::explained_in_part || d.verdict == gap::Verdict::unexplained;
      } else {
        right = !d.causes.empty() && d.causes.front().effect == all[i].withheld;
        for (const auto& set : d.ambiguity_sets)
          right = right || std::find(set.begin(), set.end(), all[i].withheld) != set.end();
      }
      for (const gap::Cause& cause : d.causes)
        beside_ += cause.effect != all[i].withheld && cause.probability >= 0.5 ? 1 : 0;
      right_ += right ? 1 : 0;
      ++cases_;
      rows.push_back({all[i].how, all[i].withheld == "?" ? "unknown" : "`" + all[i].withheld + "`",
                      named(d), gap::to_string(d.verdict), where(d.where),
                      right ? "yes" : "**no**"});
      page_.numbers()["cases"].push_back({{"withheld", all[i].withheld},
                                          {"named", named(d)},
                                          {"verdict", gap::to_string(d.verdict)},
                                          {"g2_before", d.before.g2},
                                          {"g2_after", d.after.g2},
                                          {"unexplained_p", d.unexplained_p},
                                          {"noise_scale", d.search.noise_scale},
                                          {"right", right}});
    }
    rows.front()[1] = "–";
    page_.table({"withheld", "effect", "named (probability)", "verdict", "where", "right"}, rows);
    page_.paragraph(
        "Right: the effect is the first cause named, or among those that the map cannot tell "
        "apart; for nothing, nothing is named; for what no catalogue has, the verdict says that "
        "it is not explained. Causes of .5 or more beside the right one are false; the table below "
        "counts them. Measured maps are traced anew in the changed chamber, with other "
        "random numbers: the diagnosis' linear changes are only near them. These changes are "
        "smoothed as far as two halves of their rays agree (`host/gap/chamber/smoothing.hpp`): "
        "with its noise a fit would take the change by the edges, which few and bright paths make, "
        "too small. A change in proportion does not tell all that edges of 25 % do: in every seed "
        "that "
        "was tried the depth of the sources is named for what is left.");
  }

  void targets() {
    page_.heading("What should hold");
    page_.targets(
        {{"`near_specular_lobe` is named against the diffuse model", "named",
          named_lobe_[0] ? "named" : "not named", named_lobe_[0]},
         {"against the diffuse/specular model", "named", named_lobe_[1] ? "named" : "not named",
          named_lobe_[1]},
         {"NCC and NRMSE improve", "both, for both", improved_ ? "yes" : "not all", improved_},
         {"blind cases", "all right", fmt::format("{} of {}", right_, cases_), right_ == cases_},
         {"causes named beside the right one", "none", fmt::format("{}", beside_), beside_ == 0}});
  }

  const Options& options_;
  Page page_;
  bool named_lobe_[2] = {false, false};
  bool improved_ = true;
  int right_ = 0, cases_ = 0, beside_ = 0;
};

}  // namespace

Page chamber_gap(const Options& options) {
  return GapStudy(options).run();
}

}  // namespace umov::study
