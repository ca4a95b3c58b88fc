// Figures 4 to 7: soil on a green paint.
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "host/cli/study/contaminants_parts.hpp"
#include "host/cli/study/plots.hpp"
#include "host/optics/angles.hpp"
#include "host/surface/mixture.hpp"

namespace umov::study {
namespace {

constexpr std::array angles{20.0, 60.0};
// [C], 4.1: the same particles seen from both angles.
constexpr std::array published_20{0.045, 0.101, 0.282, 0.507, 0.773};
constexpr std::array published_60{0.095, 0.213, 0.540, 0.745, 0.940};
constexpr std::array soils{"dry_soil", "wet_soil"};
constexpr std::array colours{"#9a7a00", "#c86a06", "#d4331d", "#74296f", "#1f5fbf"};
constexpr double period_um = 2000.0;
constexpr double particles = 1000.0;
constexpr std::size_t band_700 = 6;

// Green: what is below the varnish reflects least at 0.40 and 0.70 µm. The paper's paint is not
// published; this has its traits.
const char* const paint =
    "[substrate]\nmodel = \"microfacet+lambertian\"\n\"0.n\" = 1.5\n\"0.slope_rms\" = 0.15\n"
    "\"1.rho\" = [0.03, 0.04, 0.09, 0.15, 0.10, 0.05, 0.01, 0.12, 0.28, 0.36, 0.40]\n";

// As many spheres at every coverage: their size varies.
std::string scene(const char* soil, double coverage) {
  const double radius = period_um * std::sqrt(coverage / (particles * optics::pi));
  return fmt::format(
      "{}{}[[particles]]\nmaterial = \"{}\"\nradius_um = {:.6f}\ncoverage = {:.8f}\n", band_text,
      paint, soil, radius, coverage);
}

// The coverage from above of spheres that hide `fraction` of the ground from 20°.
double coverage_for(const SurfaceBench& bench, double fraction) {
  double low = fraction * std::cos(optics::radians(20.0));
  double coverage = low;
  for (int step = 0; step < 4; ++step) {
    const double hidden = bench.hidden(scene(soils[0], coverage), angles[0], 0).mean;
    // What shadows hide of each other grows with coverage.
    coverage = std::min(0.80, coverage + (fraction - hidden) * (step == 0 ? 1.0 : 0.8));
  }
  return coverage;
}

struct Case {
  double coverage = 0.0;
  std::array<trace::Estimate, 2> fraction{};
};

// Of one soil at one angle.
struct Seen {
  std::vector<trace::Result> wholes;
  std::vector<surface::MixturePoint> points;
  surface::MixingLaw law{};
};

std::string percent(const trace::Estimate& e) {
  return fmt::format("{:.1f}", 100.0 * e.mean);
}

std::vector<double> wavelengths_nm() {
  std::vector<double> nm;
  for (std::size_t w = 0; w < bands; ++w) nm.push_back(400.0 + 50.0 * static_cast<double>(w));
  return nm;
}

// Spectra of all coverages: simulated solid, mixed dashed.
void spectra(Page& page, const std::string& name, const std::string& caption, const Seen& seen,
             const char* quantity, trace::Estimate surface::MixtureBand::*found,
             trace::Estimate surface::MixtureBand::*linear) {
  Json data = Json::array();
  const std::vector<double> nm = wavelengths_nm();
  for (std::size_t k = 0; k < seen.points.size(); ++k) {
    std::vector<double> y, z;
    for (const auto& band : seen.points[k].bands) {
      y.push_back((band.*found).mean);
      z.push_back((band.*linear).mean);
    }
    const std::string label = percent(seen.points[k].fraction) + " %";
    data.push_back(line(label, nm, y, colours[k]));
    Json dashed = line(label + " mixed", nm, z, colours[k], "dash");
    dashed["showlegend"] = false;
    data.push_back(dashed);
  }
  page.figure(name, caption, data, axes("wavelength / nm", quantity));
}

}  // namespace

void add_soil(Page& page, SurfaceBench& bench) {
  page.heading("Soil on a green paint");
  page.paragraph(
      "The paper's paint and soil are not published. Paint here: a microfacet lobe (n = 1.5, rms "
      "slope .15) on a green Lambertian base that reflects 1 % at 0.70 µm and up to 40 % in the "
      "near "
      "infrared. Soils: `dry_soil` (24 to 43 %) and `wet_soil` (3 to 8 %) of the PROSAIL model. "
      "Spheres of one size touch the ground at random without overlap, a thousand of them; their "
      "size sets the coverage, as in the paper.");

  std::array<Case, 5> cases;
  std::vector<std::vector<std::string>> rows;
  Json numbers = Json::array();
  for (std::size_t k = 0; k < cases.size(); ++k) {
    cases[k].coverage = coverage_for(bench, published_20[k]);
    const std::string text = scene(soils[0], cases[k].coverage);
    for (std::size_t a = 0; a < 2; ++a)
      cases[k].fraction[a] = bench.hidden(text, angles[a], 1 + 2 * k + a);
    const double f = cases[k].fraction[0].mean;
    const double ratio = std::cos(optics::radians(20.0)) / std::cos(optics::radians(60.0));
    rows.push_back(
        {fmt::format("{:.1f}", 100.0 * cases[k].coverage),
         fmt::format("{:.1f} / {}", 100.0 * published_20[k], percent(cases[k].fraction[0])),
         fmt::format("{:.1f} / {}", 100.0 * published_60[k], percent(cases[k].fraction[1])),
         fmt::format("{:.1f}", std::min(100.0, 100.0 * ratio * f)),
         fmt::format("{:.1f}", 100.0 * (1.0 - std::pow(1.0 - f, ratio)))});
    numbers.push_back({{"coverage", cases[k].coverage},
                       {"fraction_20", f},
                       {"fraction_60", cases[k].fraction[1].mean},
                       {"published_20", published_20[k]},
                       {"published_60", published_60[k]}});
  }
  page.numbers()["soil_area_fractions"] = numbers;
  page.paragraph(
      "**Area fractions**, percent of the ground that soil hides. Coverage is chosen so "
      "that the fraction from 20° is the published one.");
  page.table({"seen from above", "20°: published / here", "60°: published / here",
              "no shadow on another (f · 1.879)", "shadows at random"},
             rows);
  page.paragraph(
      "Spheres that rest on one plane can gain at most cos 20°/cos 60° = 1.879 from 20° to 60°, "
      "and gain less where their shadows overlap. The paper's fractions at 60° exceed that at "
      "small "
      "coverage (9.5 and 21.3 % against at most 8.5 and 19.0 %), so its particles did not all "
      "touch "
      "the ground, or its fractions were counted otherwise. Nothing is tuned here to meet them.");

  // Everything is simulated once: bare paint, flat soil, five coverages, at both angles.
  std::array<std::array<Seen, 2>, 2> seen;  // by soil, angle
  std::vector<trace::Result> bare;
  std::array<std::vector<trace::Result>, 2> flat;
  std::vector<double> um;
  for (const double nm : wavelengths_nm()) um.push_back(1e-3 * nm);
  for (std::size_t a = 0; a < 2; ++a) {
    bare.push_back(bench.simulate(scene(soils[0], cases[0].coverage), angles[a],
                                  {.part = surface::Part::bare}));
  }
  for (std::size_t s = 0; s < 2; ++s) {
    for (std::size_t a = 0; a < 2; ++a) {
      flat[s].push_back(bench.simulate(scene(soils[s], cases[0].coverage), angles[a],
                                       {.part = surface::Part::contaminant}));
      Seen& here = seen[s][a];
      std::vector<trace::Estimate> fractions;
      std::vector<surface::EffectiveFraction> effective;
      for (const Case& c : cases) {
        here.wholes.push_back(bench.simulate(scene(soils[s], c.coverage), angles[a], {}));
        here.points.push_back(
            surface::mixed(here.wholes.back(), bare[a], {&flat[s][a]}, {c.fraction[a]}, um));
        fractions.push_back(c.fraction[a]);
        effective.push_back(here.points.back().effective);
      }
      here.law = surface::fit_law(fractions, effective);
    }
  }

  page.heading("Figure 4: spectral reflectance");
  for (std::size_t s = 0; s < 2; ++s) {
    for (std::size_t a = 0; a < 2; ++a) {
      spectra(
          page, fmt::format("figure-4-{}-{:.0f}", s == 0 ? "dry" : "wet", angles[a]),
          fmt::format("DHR at {:.0f}°, `{}`, by area fraction: simulated (solid), linear mixture "
                      "(dashed)",
                      angles[a], soils[s]),
          seen[s][a], "DHR", &surface::MixtureBand::dhr, &surface::MixtureBand::linear_dhr);
    }
  }
  std::vector<Target> targets;
  // "approach the soil DHR much faster"
  for (std::size_t s = 0; s < 2; ++s) {
    for (std::size_t a = 0; a < 2; ++a) {
      int faster = 0;
      int cells = 0;
      for (const auto& p : seen[s][a].points) {
        for (std::size_t w = 0; w < bands; ++w) {
          const double soil = flat[s][a].hemispherical(w).mean[0][0];
          const auto& band = p.bands[w];
          ++cells;
          if (std::abs(band.dhr.mean - soil) < std::abs(band.linear_dhr.mean - soil)) ++faster;
        }
      }
      targets.push_back({fmt::format("DHR nearer to the soil's than the mixture, {}, {:.0f}°",
                                     soils[s], angles[a]),
                         "most bands and coverages", fmt::format("{} of {}", faster, cells),
                         2 * faster > cells});
    }
  }
  // "falls below both the soil and paint DHR at 0.7 µm for some area fractions"
  for (std::size_t s = 0; s < 2; ++s) {
    for (std::size_t a = 0; a < 2; ++a) {
      std::string at;
      for (const auto& p : seen[s][a].points) {
        const auto soil = flat[s][a].hemispherical(band_700);
        const auto clean = bare[a].hemispherical(band_700);
        const double margin =
            std::min(soil.mean[0][0], clean.mean[0][0]) - p.bands[band_700].dhr.mean;
        const double u =
            std::hypot(p.bands[band_700].dhr.error, soil.error[0][0], clean.error[0][0]);
        if (margin > 3.0 * u) {
          at += fmt::format("{}{} % (by {:.4f} ± {:.4f})", at.empty() ? "" : ", ",
                            percent(p.fraction), margin, u);
        }
      }
      targets.push_back(
          {fmt::format("DHR at 0.70 µm below soil's and paint's, {}, {:.0f}°", soils[s], angles[a]),
           "at some fractions", at.empty() ? "at none" : at, !at.empty()});
    }
  }

  page.heading("Figure 5: effective area fraction");
  for (std::size_t s = 0; s < 2; ++s) {
    Json data = Json::array();
    std::vector<double> straight{0.0, 1.0};
    data.push_back(line("linear mixing", straight, straight, "#5a6472", "dot"));
    std::array<double, 2> bend{};
    for (std::size_t a = 0; a < 2; ++a) {
      std::vector<double> x, y, u, curve_x, curve_y;
      for (const auto& p : seen[s][a].points) {
        x.push_back(p.fraction.mean);
        y.push_back(p.effective.mean);
        u.push_back(p.effective.error);
        bend[a] = std::max(bend[a], std::abs(p.effective.mean - p.fraction.mean));
      }
      for (int i = 0; i <= 50; ++i) {
        curve_x.push_back(0.02 * i);
        curve_y.push_back(seen[s][a].law(0.02 * i));
      }
      data.push_back(points(fmt::format("{:.0f}°", angles[a]), x, y, u, colours[2 * a + 2]));
      data.push_back(
          line(fmt::format("γ = {:.3f} ± {:.3f}", seen[s][a].law.gamma, seen[s][a].law.gamma_u),
               curve_x, curve_y, colours[2 * a + 2]));
      page.numbers()[fmt::format("gamma_{}_{:.0f}", soils[s], angles[a])] = {
          seen[s][a].law.gamma, seen[s][a].law.gamma_u};
    }
    page.figure(
        fmt::format("figure-5-{}", s == 0 ? "dry" : "wet"),
        fmt::format("Fraction that linear mixing would need, `{}`; curves 1 − (1 − f)^γ, off "
                    "by {:.3f} and {:.3f} at most",
                    soils[s], seen[s][0].law.largest_miss, seen[s][1].law.largest_miss),
        data, axes("area fraction f", "effective area fraction"));
    const double z = std::abs(seen[s][0].law.gamma - 1.0) / seen[s][0].law.gamma_u;
    targets.push_back(
        {fmt::format("effective against true fraction is a curve, {}, 20°", soils[s]), "γ is not 1",
         fmt::format("γ = {:.3f} ({:.0f} σ from 1)", seen[s][0].law.gamma, z), z > 3.0});
    targets.push_back({fmt::format("more linear at 60° than at 20°, {}", soils[s]),
                       "effective fraction nearer to f",
                       fmt::format("at most {:.3f} at 60°, {:.3f} at 20°", bend[1], bend[0]),
                       bend[1] < bend[0]});
  }

  page.heading("Figure 6: hemispherical degree of polarisation");
  for (std::size_t a = 0; a < 2; ++a) {
    spectra(page, fmt::format("figure-6-{:.0f}", angles[a]),
            fmt::format(
                "m10/m00 over the hemisphere at {:.0f}°, `dry_soil`: simulated (solid), mixture "
                "(dashed)",
                angles[a]),
            seen[0][a], "degree of polarisation", &surface::MixtureBand::dop,
            &surface::MixtureBand::linear_dop);
    for (std::size_t s = 0; s < 2; ++s) {
      int lower = 0;
      int told = 0;
      for (const auto& p : seen[s][a].points) {
        for (const auto& band : p.bands) {
          const double u = std::hypot(band.dop.error, band.linear_dop.error);
          if (std::abs(band.dop.mean - band.linear_dop.mean) < 2.0 * u) continue;
          ++told;
          if (band.dop.mean < band.linear_dop.mean) ++lower;
        }
      }
      targets.push_back(
          {fmt::format("degree of polarisation falls faster than the mixture's, {}, {:.0f}°",
                       soils[s], angles[a]),
           "in nine of ten bands that differ by 2 σ", fmt::format("{} of {}", lower, told),
           told > 0 && 10 * lower >= 9 * told});
    }
  }

  page.heading("Figure 7: in the plane of incidence at 60°");
  Json data = Json::array();
  const InPlane clean = in_plane(bare[1], bands);
  const InPlane soil = in_plane(flat[0][1], bands);
  data.push_back(line("paint", clean.theta_deg, clean.brdf, "#16883a"));
  std::vector<std::string> ratios;
  bool forward_first = false;
  bool back_last = false;
  bool mixture_forward = true;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const InPlane plane = in_plane(seen[0][1].wholes[k], bands);
    const double f = seen[0][1].points[k].fraction.mean;
    std::vector<double> linear;
    for (std::size_t i = 0; i < plane.brdf.size(); ++i) {
      linear.push_back(f * soil.brdf[i] + (1.0 - f) * clean.brdf[i]);
    }
    data.push_back(line(percent(seen[0][1].points[k].fraction) + " %", plane.theta_deg, plane.brdf,
                        colours[k]));
    Json dashed = line("mixed", plane.theta_deg, linear, colours[k], "dash");
    dashed["showlegend"] = false;
    data.push_back(dashed);
    const trace::Estimate forward = plane.mean(55.0, 75.0);
    const trace::Estimate back = plane.mean(-75.0, -45.0);
    ratios.push_back(fmt::format("{} %: {:.2f}", percent(seen[0][1].points[k].fraction),
                                 forward.mean / back.mean));
    if (k == 0) forward_first = forward.mean > back.mean;
    if (k + 1 == cases.size()) back_last = back.mean > forward.mean;
    double mixed_forward = 0.0;
    double mixed_back = 0.0;
    for (std::size_t i = 0; i < linear.size(); ++i) {
      if (plane.theta_deg[i] > 55.0 && plane.theta_deg[i] < 75.0) mixed_forward += linear[i] / 10.0;
      if (plane.theta_deg[i] > -75.0 && plane.theta_deg[i] < -45.0) mixed_back += linear[i] / 15.0;
    }
    mixture_forward = mixture_forward && mixed_forward > mixed_back;
  }
  page.figure(
      "figure-7",
      "Mean BRDF of all bands, light from 60°, `dry_soil`: simulated (solid), mixture (dashed)",
      data, axes("θr / °, forward > 0", "BRDF / sr<sup>−1</sup>"));
  page.paragraph("Forward (55° to 75°) over back (−75° to −45°):");
  page.list(ratios);
  targets.push_back({"in-plane BRDF at 60° goes from a forward peak to a backward hotspot",
                     "forward at 9 %, back at 94 %", ratios.front() + "; " + ratios.back(),
                     forward_first && back_last});
  targets.push_back({"the mixture peaks forward in all cases", "forward",
                     mixture_forward ? "forward in all" : "not in all", mixture_forward});
  page.heading("The paper's statements on soil");
  page.targets(targets);
  page.paragraph(
      "What decides is how bright the soil is beside the paint. Dark soil does what the paper "
      "says: "
      "the surface is nearer to the soil than the mixture, and darker than both of its materials "
      "at "
      "0.70 µm. With bright soil on dark paint it stays nearer to the paint than the mixture, for "
      "what leaves a sphere downwards meets the paint, and nothing falls below both. The paper's "
      "soil "
      "was presumably about as dark as its paint. At 20° degrees of polarisation are of the order "
      "of "
      "a hundredth, and differ from the mixture's either way. At 60° dry soil does so in four "
      "bands "
      "of five; where it does not, little soil leaves the surface more polarised than the mixture "
      "and much soil less.");
}

}  // namespace umov::study
