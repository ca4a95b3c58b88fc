#include "host/cli/study/chamber.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "host/chamber/radiosity.hpp"
#include "host/cli/study/chamber_page.hpp"
#include "host/cli/study/chamber_runs.hpp"
#include "host/optics/angles.hpp"

namespace umov::study {
namespace {

using chamber::Distribution;
using chamber::Map;
using chamber::MixingChamber;

constexpr std::uint64_t rays_per_pixel = 1000;
constexpr std::uint64_t launches = 20'000'000;
// A camera does not see the noise of rays: where it is compared, the measurement has ten times
// their number.
constexpr std::uint64_t rays_per_measured_pixel = 10'000;

/// What one chamber gives.
struct Taken {
  Map map;
  Distribution distribution;
  double walls_take = 0.0;  ///< of the light that meets what is not black, all bounces
};

class ChamberStudy {
 public:
  explicit ChamberStudy(const Options& options) : options_(options), page_("chamber", title) {}

  Page run() {
    introduce();
    diffuse_case();
    take_all();
    table_1();
    figures();
    distributions();
    registration();
    targets();
    return std::move(page_);
  }

 private:
  static constexpr const char* title =
      "How good must a BRDF be? Luminance maps and intensity distributions of a mixing chamber";

  chamber::MapRequest map_request(double from, double to, const std::string& what) const {
    chamber::MapRequest request;
    request.rays_per_pixel = rays_per_pixel;
    request.seed = options_.seed;
    request.threads = options_.threads;
    request.progress = [this, from, to, what](double share) {
      step(options_, from + (to - from) * share, what);
    };
    return request;
  }

  Taken take(const MixingChamber& chamber, double from, double to, const std::string& what,
             std::uint64_t seed) {
    const chamber::Luminaire luminaire = chamber.luminaire();
    const chamber::Tracer tracer(luminaire);
    chamber::MapRequest request = map_request(from, to, what);
    request.seed = seed;
    Taken taken{chamber::luminance_map(tracer, chamber.camera(), request),
                distribution(tracer, seed), 0.0};
    const chamber::Fate& fate = taken.distribution.fate;
    double met = 0.0;
    for (std::size_t i = 0; i < luminaire.surfaces.size(); ++i) {
      if (luminaire.surfaces[i]->black()) continue;
      met += fate.incident[i];
      taken.walls_take += fate.taken[i];
    }
    taken.walls_take /= met;
    return taken;
  }

  Distribution distribution(const chamber::Tracer& tracer, std::uint64_t seed) const {
    chamber::DistributionRequest lid;
    lid.rays = launches;
    lid.planes = 8;
    lid.angles = 19;
    lid.seed = seed;
    lid.threads = options_.threads;
    return chamber::intensity_distribution(tracer, lid);
  }

  void introduce() {
    page_.paragraph(fmt::format(
        "Command `{}`. The authors of [M] (doi:10.1117/1.OE.52.9.095101) built a cylinder of "
        "white plastic over four small sources and asked which BRDF model of the plastic foretells "
        "its intensity distribution, and which its luminance map. Here both halves are repeated "
        "with a virtual measurement: a chamber that differs from the models in what the models "
        "are not told.",
        options_.command));
    page_.heading("What is known and what is assumed");
    page_.list(
        {"Published: inner diameter 43 mm, height 21.4 mm, four holes of 5 mm with black edges, "
         "0.96 lm each, view from 55°, 125 × 300 pixels of 0.2 mm, 1000 rays a pixel, R_total "
         ".984.",
         "Not published: the ring of holes and the depth of the sources. No hole is in view from "
         "55°, so a ring on the diagonals has at most 9.3 mm; 8 mm is taken (6.6 mm, with sources "
         ".5 "
         "mm deep, stood in an earlier version of the example). The sheet is 1 mm thick and the "
         "sources lie behind it, so the depth is 1 "
         "mm in everything but the table of depths.",
         "The measured curves of MCPET are printed as pictures only. The plastic here is "
         "**synthetic**: `ggx+subsurface` (n = 1.6, α = .1), each incidence scaled to reflect "
         ".984 (`examples/chambers`). The tabular model has it at 5, 25, 45, 60, 70, 80° every "
         "2.5° in two planes, linear in between, scaled to .984; the diffuse/specular model has "
         "what a 5° wide aperture gets in the mirror direction beyond the diffuse level.",
         "The region: X 15–35 mm, Y 15–23 mm, is printed without the origin of X. In a window "
         "centred on the opening it reaches over the opening's edge, where no luminance is, and "
         "a U of .87 would be impossible. The main reading is therefore a region as large about "
         "the axis; beside it the printed numbers, without the pixels that do not lie wholly "
         "inside."});
    std::vector<std::string> items = withheld();
    page_.paragraph("**Withheld from the models** in the measurement:");
    page_.list(items);
  }

  // [M]'s external figures against the diffuse chamber, nothing tuned.
  void diffuse_case() {
    page_.heading("The diffuse case against the paper's own numbers");
    std::vector<std::vector<std::string>> rows;
    const std::array depths{0.0, 0.5, 1.0};
    for (std::size_t i = 0; i < depths.size(); ++i) {
      MixingChamber c = known_chamber();
      c.wall = wall_models().front().surface;
      c.depth_mm = depths[i];
      const double from = 0.1 * static_cast<double>(i) / 3.0;
      const Taken t =
          take(c, from, from + 0.03, fmt::format("depth {} mm", depths[i]), options_.seed);
      const chamber::Evenness e = chamber::evenness(chamber::cut(t.map, centred_region()));
      const chamber::Evenness printed = chamber::evenness(inside_only(t.map, printed_region(), c));
      const chamber::Radiosity r = solve(c);
      rows.push_back(
          {fmt::format("{} mm", depths[i]), fmt::format("{:.0f}", e.mean),
           fmt::format("{:.0f}", e.maximum), fmt::format("{:.3f}", e.uniformity),
           fmt::format("{:.0f}, {:.0f}, {:.3f}", printed.mean, printed.maximum, printed.uniformity),
           fmt::format("{:.1f} %", 100.0 * t.distribution.first_hit_fraction),
           fmt::format("{:.2f} ({:.2f})", t.distribution.out_lm, r.out_lm)});
      const double off = std::abs(t.distribution.out_lm / r.out_lm - 1.0);
      radiosity_off_ = std::max(radiosity_off_, off);
      Json& n = page_.numbers()["diffuse"][fmt::format("depth_{}_mm", depths[i])];
      n = {{"mean_cd_m2", e.mean},
           {"max_cd_m2", e.maximum},
           {"uniformity", e.uniformity},
           {"mean_printed_region_cd_m2", printed.mean},
           {"first_hit_fraction", t.distribution.first_hit_fraction},
           {"out_lm", t.distribution.out_lm},
           {"radiosity_out_lm", r.out_lm}};
      energy_off_ = std::max(energy_off_, std::abs(t.walls_take / (1.0 - chamber_total) - 1.0));
    }
    rows.push_back({"[M], diffuse model", "265", "309", ".87", "–", "40 %", "–"});
    page_.table({"depth of the sources", "mean cd/m²", "max", "U",
                 "mean, max, U of the printed region", "met a wall first", "lm out (radiosity)"},
                rows);
    page_.paragraph(
        "Nothing was tuned, and no depth meets all four of [M]'s numbers: the ring and the depth "
        "are ours. The share that meets a wall first falls with depth, as the holes cut off what "
        "goes aside; the region's mean falls with it. In brackets: the same lumens by "
        "radiosity, without a ray (`host/chamber/radiosity`). A maximum over 4,000 pixels holds "
        "the largest noise of 4,000 as well, some 3.5 of its standard errors, and a minimum "
        "likewise.");
  }

  static chamber::Radiosity solve(const MixingChamber& c) {
    chamber::DiffuseChamber d{0.5 * c.diameter_mm, c.height_mm, chamber_total, chamber_total, {}};
    for (std::size_t i = 0; i < 4; ++i) {
      const double a = optics::radians(c.azimuth_deg + 90.0 * static_cast<double>(i));
      d.holes.push_back({c.ring_radius_mm * std::cos(a), c.ring_radius_mm * std::sin(a),
                         0.5 * c.hole_diameter_mm, c.depth_mm, c.flux_lm[i]});
    }
    return chamber::solve_radiosity(
        d, {{0.0, 5.0, 10.0, 16.0, c.height_mm}, {0.0, 12.0, 0.5 * c.diameter_mm}, 5, 72});
  }

  void take_all() {
    models_ = wall_models();
    for (std::size_t i = 0; i < models_.size(); ++i) {
      MixingChamber c = known_chamber();
      c.wall = models_[i].surface;
      const double from = 0.1 + 0.2 * static_cast<double>(i);
      taken_.push_back(take(c, from, from + 0.2, models_[i].title, options_.seed));
      energy_off_ =
          std::max(energy_off_, std::abs(taken_.back().walls_take / (1.0 - chamber_total) - 1.0));
    }
    MixingChamber plastic = known_chamber();
    plastic.wall = plastic_wall(chamber_total);
    const chamber::Luminaire luminaire = plastic.luminaire();
    plastic_ = distribution(chamber::Tracer(luminaire), options_.seed);
    // The measurement has noise of its own.
    measured_ = take(measured_chamber(), 0.7, 0.9, "measurement", options_.seed + 1000);
    refine_measurement();
    add_camera_noise(measured_.map, options_.seed + 2000);
  }

  // The part of the measured map that figures are told of, again with more rays.
  void refine_measurement() {
    const MixingChamber c = measured_chamber();
    const chamber::Luminaire luminaire = c.luminaire();
    const chamber::Tracer tracer(luminaire);
    Map& map = measured_.map;
    const std::size_t x0 = 75, x1 = 200, y0 = 75, y1 = 115;
    chamber::Camera camera = c.camera();
    const auto off = [&](std::size_t from, std::size_t to, std::size_t size) {
      return 0.5 * map.pixel_mm * (static_cast<double>(from + to) - static_cast<double>(size));
    };
    camera.centre += off(x0, x1, map.width) * camera.right();
    camera.centre += off(y0, y1, map.height) * camera.up();
    camera.width = x1 - x0;
    camera.height = y1 - y0;
    chamber::MapRequest request = map_request(0.9, 0.99, "measurement, the region");
    request.rays_per_pixel = rays_per_measured_pixel;
    request.seed = options_.seed + 1001;
    const Map part = chamber::luminance_map(tracer, camera, request);
    for (std::size_t y = y0; y < y1; ++y) {
      for (std::size_t x = x0; x < x1; ++x) {
        const std::size_t at = (y - y0) * part.width + (x - x0);
        map.luminance_cd_m2[y * map.width + x] = part.luminance_cd_m2[at];
        map.luminance_se[y * map.width + x] = part.luminance_se[at];
      }
    }
  }

  void table_1() {
    page_.heading("Table 1: the region about the highlights");
    const Map measured = chamber::cut(measured_.map, centred_region());
    const Map measured_printed = inside_only(measured_.map, printed_region(), known_chamber());
    const chamber::Evenness m = chamber::evenness(measured);
    std::vector<std::vector<std::string>> rows;
    const auto with_paper = [](const std::string& own, const char* paper) {
      return own + " (" + paper + ")";
    };
    rows.push_back({"measurement", "–", "–", "–",
                    with_paper(fmt::format("{:.0f}", m.maximum), "794"),
                    with_paper(fmt::format("{:.0f}", m.mean), "470"),
                    with_paper(fmt::format("{:.2f}", m.uniformity), ".68"), "–"});
    for (std::size_t i = 0; i < models_.size(); ++i) {
      const Map part = chamber::cut(taken_[i].map, centred_region());
      const chamber::Likeness l = chamber::likeness(measured, part);
      const chamber::Likeness printed = chamber::likeness(
          measured_printed, inside_only(taken_[i].map, printed_region(), known_chamber()));
      const chamber::Evenness e = chamber::evenness(part);
      likeness_.push_back(l);
      uniformity_.push_back(e.uniformity);
      const PaperRow& paper = paper_rows[i];
      rows.push_back({models_[i].title, with_paper(fmt::format("{:.2f}", 100.0 * l.ncc), paper.ncc),
                      with_paper(fmt::format("{:.2f}", 100.0 * l.nrmse), paper.nrmse),
                      fmt::format("{:.2f}", 100.0 * l.mean_deviation),
                      with_paper(fmt::format("{:.0f}", e.maximum), paper.maximum),
                      with_paper(fmt::format("{:.0f}", e.mean), paper.mean),
                      with_paper(fmt::format("{:.2f}", e.uniformity), paper.uniformity),
                      fmt::format("{:.2f}, {:.2f}", 100.0 * printed.ncc, 100.0 * printed.nrmse)});
      page_.numbers()["table_1"][models_[i].name] = {
          {"ncc", l.ncc},
          {"nrmse", l.nrmse},
          {"mean_deviation", l.mean_deviation},
          {"max_cd_m2", e.maximum},
          {"mean_cd_m2", e.mean},
          {"uniformity", e.uniformity},
          {"printed_region", {{"ncc", printed.ncc}, {"nrmse", printed.nrmse}}}};
    }
    measured_uniformity_ = m.uniformity;
    page_.numbers()["table_1"]["measurement"] = {
        {"max_cd_m2", m.maximum}, {"mean_cd_m2", m.mean}, {"uniformity", m.uniformity}};
    page_.table({"", "NCC %", "NRMSE %", "mean deviation %", "max cd/m²", "mean cd/m²", "U",
                 "NCC, NRMSE of the printed region %"},
                rows);
    page_.paragraph(
        "In brackets [M]'s own values, of another material. NRMSE is √(mean of squares)/max; "
        "[M]'s formula as printed takes the root of each square, which is the mean deviation once "
        "its 1/N is put back. Both are given.");
    const chamber::Glare glare;
    std::vector<std::vector<std::string>> ratings;
    const auto rate = [&](const std::string& name, const Map& map) {
      const chamber::GlareRating r = chamber::glare_rating(map, glare);
      ratings.push_back(
          {name, fmt::format("{:.2f}", r.ugr_map), fmt::format("{:.2f}", r.ugr_uniform)});
      page_.numbers()["ugr"][name] = {{"map", r.ugr_map}, {"uniform", r.ugr_uniform}};
    };
    rate("measurement", measured_.map);
    for (std::size_t i = 0; i < models_.size(); ++i) rate(models_[i].title, taken_[i].map);
    page_.paragraph(
        "**Glare** of the whole opening from 2 m before 40 cd/m² (CIE 117; below 0 for so small "
        "and dim a source, of interest is the difference):");
    page_.table({"", "UGR by the map", "UGR by its mean"}, ratings);
  }

  void figures() {
    page_.heading("Figures 5 and 6: the maps");
    std::vector<NamedMap> maps;
    for (std::size_t i = 0; i < models_.size(); ++i)
      maps.push_back({models_[i].title, &taken_[i].map});
    maps.push_back({"measurement", &measured_.map});
    add_maps(page_, "figure-5", "Luminance seen from 55°, as figure 5 of [M].", maps, std::nullopt);
    add_maps(page_, "figure-6", "The region about the highlights, as figure 6 of [M].", maps,
             centred_region());
    page_.paragraph(
        "The diffuse wall has no highlight. The mirrored share of the second model shows the "
        "sources with sharp edges; the table blurs them over the wall and brightens it, as the "
        "measurement does.");
  }

  void distributions() {
    page_.heading("Figure 9: the intensity distributions");
    std::vector<NamedDistribution> all;
    for (std::size_t i = 0; i < models_.size(); ++i)
      all.push_back({models_[i].title, &taken_[i].distribution});
    all.push_back({"measurement", &measured_.distribution});
    add_distributions(page_, all);
    std::vector<std::vector<std::string>> rows;
    const Distribution& m = measured_.distribution;
    for (std::size_t i = 0; i < models_.size(); ++i) {
      const Distribution& d = taken_[i].distribution;
      const auto c0 = chamber::difference(m, d, 0);
      const auto c45 = chamber::difference(m, d, 1);
      double models = 0.0;
      for (const Taken& other : taken_)
        models = std::max(models, chamber::difference(d, other.distribution).largest);
      largest_difference_ = std::max(largest_difference_, models);
      double noise = 0.0;
      const double peak = *std::max_element(d.intensity_cd.begin(), d.intensity_cd.end());
      for (std::size_t k = 0; k < d.intensity_se.size(); ++k)
        noise = std::max(noise, d.intensity_se[k] / peak);
      rows.push_back({models_[i].title, fmt::format("{:.2f} %", 100.0 * c0.largest),
                      fmt::format("{:.2f} %", 100.0 * c45.largest),
                      fmt::format("{:.2f} %", 100.0 * models),
                      fmt::format("{:.2f} %", 100.0 * noise),
                      fmt::format("{:.2f} %", 100.0 * d.efficiency())});
      page_.numbers()["lid"][models_[i].name] = {{"from_measurement_c0", c0.largest},
                                                 {"from_measurement_c45", c45.largest},
                                                 {"from_other_models", models},
                                                 {"efficiency", d.efficiency()}};
    }
    rows.push_back(
        {"measurement", "–", "–", "–", "–", fmt::format("{:.2f} %", 100.0 * m.efficiency())});
    page_.table({"", "largest difference from the measurement, C0–C180", "C45–C225",
                 "from the other models, all planes", "largest standard error", "efficiency"},
                rows);
    page_.paragraph("Differences and errors are shares of the peak intensity.");
    explain_difference();
  }

  // Where the lobe puts light that the diffuse wall sends up, by the table and by the plastic that
  // the table was read from.
  void explain_difference() {
    const Distribution& diffuse = taken_.front().distribution;
    const Distribution& table = taken_.back().distribution;
    const double peak = *std::max_element(diffuse.intensity_cd.begin(), diffuse.intensity_cd.end());
    const std::size_t angles = diffuse.gamma_deg.size();
    const auto planes = static_cast<double>(diffuse.c_deg.size());
    /// Mean of all planes; its error for independent ones.
    const auto less_diffuse = [&](const Distribution& d, std::size_t g) {
      double sum = 0.0, variance = 0.0;
      for (std::size_t c = 0; c < diffuse.c_deg.size(); ++c) {
        sum += d.intensity(c, g) - diffuse.intensity(c, g);
        variance += std::pow(d.intensity_se[c * angles + g], 2) +
                    std::pow(diffuse.intensity_se[c * angles + g], 2);
      }
      // The cell on the axis is one, shared by the planes.
      const double error = std::sqrt(variance) / (g == 0 ? std::sqrt(planes) : planes);
      return std::pair(100.0 * sum / planes / peak, 100.0 * error / peak);
    };
    std::size_t most = 0;
    for (std::size_t g = 0; g < angles; ++g) {
      if (less_diffuse(table, g).first > less_diffuse(table, most).first) most = g;
    }
    const auto text = [&](const Distribution& d, std::size_t g) {
      const auto [value, error] = less_diffuse(d, g);
      return fmt::format("{:+.2f} ± {:.2f} %", value, error);
    };
    page_.paragraph(fmt::format(
        "What is between the models is neither noise nor energy: on the axis the tabular model is "
        "{} off the diffuse one, at γ = {:g}° {} (mean of the planes, one standard error), and the "
        "efficiencies are {:.2f} % apart. It is the lobe, which sends light that grazes the wall "
        "on to the opening's side, where the diffuse wall sends some of it up. The plastic itself, "
        "in the same chamber without a table of six incidences between, has {} and {}: so much "
        "of the difference is the material's, whoever measures it.",
        text(table, 0), diffuse.gamma_deg[most], text(table, most),
        100.0 * std::abs(table.efficiency() - diffuse.efficiency()), text(plastic_, 0),
        text(plastic_, most)));
    const auto note = [&](const char* name, const Distribution& d) {
      page_.numbers()["lid"]["less_diffuse_percent"][name] = {
          {"axis", less_diffuse(d, 0).first},
          {"axis_se", less_diffuse(d, 0).second},
          {"largest", less_diffuse(d, most).first},
          {"largest_gamma_deg", diffuse.gamma_deg[most]}};
    };
    note("tabular", table);
    note("plastic", plastic_);
  }

  void registration() {
    page_.heading("How well must the maps be registered?");
    std::vector<std::vector<std::string>> rows;
    const Map measured = chamber::cut(measured_.map, centred_region());
    for (const double pixels : {0.0, 0.5, 1.0, 2.0, 4.0, 8.0}) {
      std::vector<std::string> row{fmt::format("{:g} ({:.1f} mm)", pixels, 0.2 * pixels)};
      for (const Taken& taken : taken_) {
        const auto of = [&](double x, double y) {
          return chamber::likeness(measured,
                                   chamber::cut(chamber::moved(taken.map, x, y), centred_region()));
        };
        const chamber::Likeness right = of(pixels, 0.0);
        const chamber::Likeness up = of(0.0, pixels);
        row.push_back(fmt::format("{:.1f}, {:.1f}", 100.0 * right.ncc, 100.0 * right.nrmse));
        row.push_back(fmt::format("{:.1f}, {:.1f}", 100.0 * up.ncc, 100.0 * up.nrmse));
      }
      rows.push_back(row);
    }
    std::vector<std::string> header{"moved by pixels"};
    for (const WallModel& model : models_) {
      header.push_back(model.title + ", in X");
      header.push_back(model.title + ", in Y");
    }
    page_.table(header, rows);
    const chamber::Registration best =
        chamber::registered(measured, chamber::cut(taken_.back().map, centred_region()), 5.0);
    page_.paragraph(fmt::format(
        "NCC and NRMSE in per cent. Moved freely for the largest NCC, the tabular map goes by "
        "({:.2f}, {:.2f}) pixels and reaches {:.2f} %. A match of templates that is free to move "
        "hides what a wrong angle of view does.",
        best.x_pixels, best.y_pixels, 100.0 * best.likeness.ncc));
    page_.numbers()["registration"] = {
        {"x_pixels", best.x_pixels}, {"y_pixels", best.y_pixels}, {"ncc", best.likeness.ncc}};
  }

  void targets() {
    page_.heading("What should hold");
    const auto percent = [](double x) { return fmt::format("{:.2f} %", 100.0 * x); };
    const auto three = [&](const auto& value) {
      return fmt::format("{}, {}, {}", percent(value(0)), percent(value(1)), percent(value(2)));
    };
    const auto ncc = [&](std::size_t i) { return likeness_[i].ncc; };
    const auto nrmse = [&](std::size_t i) { return likeness_[i].nrmse; };
    page_.targets({{"intensity distributions agree among the models", "< 2 % of the peak",
                    percent(largest_difference_), largest_difference_ < 0.02},
                   {"NCC rises from diffuse over diffuse/specular to tabular", "in this order",
                    three(ncc), ncc(0) < ncc(1) && ncc(1) < ncc(2)},
                   {"NRMSE falls in the same order", "in this order", three(nrmse),
                    nrmse(0) > nrmse(1) && nrmse(1) > nrmse(2)},
                   {"U of the tabular model is the nearest to the measured one", "nearest",
                    fmt::format("{:.2f}, {:.2f}, {:.2f} for {:.2f}", uniformity_[0], uniformity_[1],
                                uniformity_[2], measured_uniformity_),
                    std::abs(uniformity_[2] - measured_uniformity_) <
                        std::min(std::abs(uniformity_[0] - measured_uniformity_),
                                 std::abs(uniformity_[1] - measured_uniformity_))},
                   {"light out of the diffuse chamber against radiosity", "< 0.5 %",
                    percent(radiosity_off_), radiosity_off_ < 0.005},
                   {"energy: what walls take of what they get, against 1 − .984, all models",
                    "< 5 %", percent(energy_off_), energy_off_ < 0.05}});
  }

  static constexpr double chamber_total = 0.984;
  struct PaperRow {
    const char *ncc, *nrmse, *maximum, *mean, *uniformity;
  };
  static constexpr std::array<PaperRow, 3> paper_rows{{{"80.07", "28.32", "309", "265", ".87"},
                                                       {"86.96", "27.54", "356", "268", ".85"},
                                                       {"94.61", "9.14", "783", "416", ".65"}}};

  const Options& options_;
  Page page_;
  std::vector<WallModel> models_;
  std::vector<Taken> taken_;
  Taken measured_;
  Distribution plastic_;  ///< of the known chamber with the measured one's material
  std::vector<chamber::Likeness> likeness_;
  std::vector<double> uniformity_;
  double measured_uniformity_ = 0.0, largest_difference_ = 0.0, radiosity_off_ = 0.0,
         energy_off_ = 0.0;
};

}  // namespace

Page chamber(const Options& options) {
  return ChamberStudy(options).run();
}

}  // namespace umov::study
