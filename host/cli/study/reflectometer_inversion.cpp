// The red paint of the study `reflectometer`: in-plane scans, inversion, full BRDF against truth.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "host/cli/emulator/truth.hpp"
#include "host/cli/study/paper_numbers.hpp"
#include "host/cli/study/plots.hpp"
#include "host/cli/study/reduced.hpp"
#include "host/cli/study/reflectometer_parts.hpp"
#include "host/formats/fit_file.hpp"
#include "host/invert/invert.hpp"
#include "host/invert/prediction.hpp"

namespace umov::study {
namespace {

constexpr double open = std::numeric_limits<double>::quiet_NaN();
constexpr double figure_incidence_deg = 30;
/// Measured incidences, and one that was not.
constexpr std::array<double, 5> judged_incidences_deg = {10, 20, 30, 45, 60};

/// A derived quantity at a wavelength, or a parameter.
const formats::Estimate& estimate(const formats::FitResult& fit, const std::string& name,
                                  std::size_t w) {
  return fit.find(name)->at(w);
}

std::string interval(const formats::Estimate& e, int digits = 4) {
  return fmt::format("{:.{}f} ({:.{}f} … {:.{}f})", e.value, digits, e.lo, digits, e.hi, digits);
}

void add_tables_3_and_4(Page& page, const formats::FitResult& fit,
                        const emulator::SampleTruth& truth) {
  page.heading("Red gloss paint: reflectance and inversion (tables 3 and 4)");
  std::vector<std::vector<std::string>> rows;
  double worst_diffuse = 0;
  for (std::size_t w = 0; w < paper::wavelengths_nm.size(); ++w) {
    const double nm = paper::wavelengths_nm[w];
    const double udf = truth.parameter("k_udf", nm), uds = truth.parameter("k_uds", nm);
    const auto& sum = estimate(fit, "k_udf+k_uds", w);
    worst_diffuse = std::max(worst_diffuse, std::abs(sum.value / (udf + uds) - 1));
    rows.push_back({fmt::format("{:g}", nm), fixed(paper::table_3[w], 2),
                    fixed(paper::table_4.k_udf[w], 4), fixed(paper::table_4.k_uds[w], 4),
                    fixed(paper::table_4.dhr[w], 4),
                    fixed(paper::table_4.k_udf[w] + paper::table_4.k_uds[w], 4), fixed(udf, 4),
                    interval(estimate(fit, "k_udf", w)), fixed(uds, 4),
                    interval(estimate(fit, "k_uds", w)), fixed(udf + uds, 4), interval(sum)});
    page.numbers()["table_4"].push_back({{"wavelength_nm", nm},
                                         {"k_udf", estimate(fit, "k_udf", w).value},
                                         {"k_uds", estimate(fit, "k_uds", w).value},
                                         {"diffuse", sum.value},
                                         {"diffuse_truth", udf + uds}});
  }
  page.table({"nm", "table 3", "k_udf (paper)", "k_uds (paper)", "DHR (paper)", "their sum",
              "k_udf true", "k_udf found", "k_uds true", "k_uds found", "sum true", "sum found"},
             std::move(rows));
  const calibrate::DeclaredDoubts declared = declared_doubts();
  page.paragraph(fmt::format(
      "Found values with 95 % intervals, from one joint fit of {} points at three wavelengths "
      "({}). Besides noise and calibration the fit knows what an operator would declare of the "
      "bench: {} for the lasers' slow noise that the monitor misses, common to all points of a "
      "wavelength and again to those of an incidence; {:g}° for the zero of either arm and {:g}° "
      "for how a sample leans; {:g}° each for eccentricity and play of the detector arm; {:g}° for "
      "where a drive stops, the same at every visit. The detector's disc of {:g}° half-angle is "
      "corrected for. The largest relative error of k_udf + k_uds is {}.",
      fit.points, fit.model, percent(declared.source_relative_u, 1), declared.theta_r_zero_u_deg,
      declared.sample_lean_u_deg, declared.theta_r_play_u_deg, declared.position_u_deg,
      declared.aperture_half_angle_deg, percent(worst_diffuse)));
  page.paragraph(
      "**Where the paper contradicts itself.** At 633 nm its table 4 gives k_udf = .0300 and "
      "k_uds = .4860, which add up to .5160, while the reflectance beside them is .4890; at 532 "
      "and 814 nm the same sum is exact. k_udf = .0030 makes it exact at 633 nm too: the .0300 is "
      "a misprint, and the emulated paint has .0030. Its table 1 gives k_udf to the surface and "
      "k_uds to the subsurface, its text the reverse; the numbers (.0028 where the pigment "
      "absorbs, .49 elsewhere) fit table 1, which we follow. The text also asks for "
      "DHR(532) ≫ DHR(633), against its own measurement.");
  page.paragraph(
      "**The .01 of table 3.** Any binder reflects more than that at its surface alone: a smooth "
      "dielectric of n = 1.5 returns 4 % at normal incidence. The spectrophotometer must have "
      "excluded the specular part, so table 3 and table 4 compare with k_udf + k_uds, not with the "
      "whole reflectance, which is this:");
}

void add_dhr(Page& page, CalibratedBench& at, const formats::FitResult& fit,
             const emulator::SampleTruth& truth) {
  std::vector<std::vector<std::string>> rows;
  double worst = 0;
  for (const auto& d : fit.dhr) {
    const double exact = truth.dhr(d.theta_i_deg, d.wavelength_nm);
    const double error = d.value / exact - 1;
    worst = std::max(worst, std::abs(error));
    rows.push_back({fmt::format("{:g}", d.wavelength_nm), fmt::format("{:g}°", d.theta_i_deg),
                    fixed(exact, 5), fmt::format("{:.5f} ({:.5f} … {:.5f})", d.value, d.lo, d.hi),
                    percent(error)});
    page.numbers()["dhr"].push_back({{"wavelength_nm", d.wavelength_nm},
                                     {"theta_i_deg", d.theta_i_deg},
                                     {"dhr", d.value},
                                     {"truth", exact}});
  }
  page.table({"nm", "θi", "DHR true, surface included", "DHR found", "error"}, std::move(rows));
  page.numbers()["dhr_worst_relative_error"] = worst;
  at.targets.push_back({"DHR of the red gloss paint from in-plane scans, all incidences",
                        "within .5 % (paper: 1 %)", "largest error " + percent(worst),
                        worst <= 0.005});
}

void add_figure_9(Page& page, const formats::BrdfTable& table, const formats::FitResult& fit) {
  page.heading("Measured and fitted BRDF in plane (figure 9)");
  Json data = Json::array();
  std::vector<double> theta, zero;
  for (double angle = -85; angle <= 85; angle += 0.25) {
    theta.push_back(angle);
    zero.push_back(0);
  }
  // 633 and 814 nm lie upon each other: rings of different size let both be seen.
  int size = 5;
  for (const double nm : paper::wavelengths_nm) {
    const Curve curve = unpolarised_curve(table, nm, figure_incidence_deg);
    Json measured = points(fmt::format("{:g} nm, measured", nm), curve.theta_r_deg, curve.value,
                           curve.u, colour_of(nm));
    measured["marker"]["symbol"] = size == 5 ? "circle" : "circle-open";
    measured["marker"]["size"] = size;
    size += 4;
    data.push_back(std::move(measured));
    const auto model = model_brdf(fit, nm, figure_incidence_deg, theta, zero);
    data.push_back(line(fmt::format("{:g} nm, Li–Torrance", nm), theta, model, colour_of(nm),
                        nm < 700 ? "solid" : "dash"));
  }
  Json layout = axes("θ<sub>r</sub> / °", "BRDF / sr<sup>−1</sup>", true);
  layout["title"] = {{"text", "Red gloss paint at 30° incidence, unpolarised"}};
  page.figure("figure-9",
              "As figure 9 of the paper: in-plane BRDF of the red gloss paint at 30° incidence, "
              "measured (points) and the joint Li–Torrance fit (lines).",
              std::move(data), std::move(layout));
}

/// log₁₀ of the model's BRDF over the exit hemisphere in direction cosines, and its error.
void add_figure_11(Page& page, const formats::FitResult& fit, const emulator::SampleTruth& truth) {
  page.heading("Full BRDF from in-plane data (figure 11)");
  constexpr int half = 45;
  Json data = Json::array(),
       layout = {{"width", 1180}, {"height", 760}, {"annotations", Json::array()}};
  int column = 0;
  for (const double nm : paper::wavelengths_nm) {
    std::vector<double> theta, phi;
    std::vector<std::size_t> place;
    for (int row = -half; row <= half; ++row)
      for (int col = -half; col <= half; ++col) {
        const double x = static_cast<double>(col) / half, y = static_cast<double>(row) / half;
        const double radius = std::hypot(x, y);
        if (radius > std::sin(80 * 3.14159265358979 / 180)) continue;
        theta.push_back(std::asin(radius) * 180 / 3.14159265358979);
        phi.push_back(std::atan2(y, x) * 180 / 3.14159265358979);
        place.push_back(static_cast<std::size_t>((row + half) * (2 * half + 1) + col + half));
      }
    const auto model = model_brdf(fit, nm, figure_incidence_deg, theta, phi);
    Json value = Json::array(), error = Json::array(), axis = Json::array();
    std::vector<Json> flat_value(static_cast<std::size_t>((2 * half + 1) * (2 * half + 1))),
        flat_error(flat_value.size());
    for (std::size_t i = 0; i < model.size(); ++i) {
      const double exact = truth.brdf(figure_incidence_deg, theta[i], phi[i], nm, open, open);
      flat_value[place[i]] = std::round(1e3 * std::log10(model[i])) / 1e3;
      flat_error[place[i]] = std::round(1e4 * (model[i] / exact - 1)) / 1e2;
    }
    for (int row = 0; row <= 2 * half; ++row) {
      Json values = Json::array(), errors = Json::array();
      for (int col = 0; col <= 2 * half; ++col) {
        values.push_back(flat_value[static_cast<std::size_t>(row * (2 * half + 1) + col)]);
        errors.push_back(flat_error[static_cast<std::size_t>(row * (2 * half + 1) + col)]);
      }
      value.push_back(std::move(values));
      error.push_back(std::move(errors));
      axis.push_back(std::round(1e4 * (row - half) / half) / 1e4);
    }
    const auto map = [&](Json z, int number, const char* scale, double low, double high,
                         const char* title, double y) {
      Json trace = {
          {"type", "heatmap"}, {"x", axis},    {"y", axis},           {"z", std::move(z)},
          {"zmin", low},       {"zmax", high}, {"colorscale", scale}, {"showscale", column == 2}};
      trace["colorbar"] = {{"title", {{"text", title}}}, {"len", 0.45}, {"y", y}};
      return on(std::move(trace), number);
    };
    data.push_back(map(std::move(value), column + 1, "Viridis", -2.5, 1.5,
                       "log₁₀ BRDF<br>/ sr<sup>−1</sup>", 0.78));
    data.push_back(map(std::move(error), column + 4, "RdBu", -3, 3, "error / %", 0.2));
    for (const int number : {column + 1, column + 4}) {
      const std::string n = number == 1 ? "" : std::to_string(number);
      const bool above = number < 4;
      layout["xaxis" + n] = {{"title", {{"text", "sin θ<sub>r</sub> cos φ / 1"}}},
                             {"domain", {0.36 * column, 0.36 * column + 0.25}},
                             {"anchor", "y" + n},
                             {"dtick", 0.5}};
      layout["yaxis" + n] = {{"title", {{"text", "sin θ<sub>r</sub> sin φ / 1"}}},
                             {"domain", above ? Json{0.57, 0.97} : Json{0.0, 0.4}},
                             {"anchor", "x" + n},
                             {"dtick", 0.5}};
    }
    layout["annotations"].push_back({{"text", fmt::format("{:g} nm", nm)},
                                     {"x", 0.36 * column + 0.125},
                                     {"y", 1.04},
                                     {"xref", "paper"},
                                     {"yref", "paper"},
                                     {"showarrow", false}});
    ++column;
  }
  page.figure("figure-11",
              "As figure 11 of the paper: full BRDF at 30° incidence from the fit to in-plane data "
              "alone (above, decadic logarithm), and its relative error against the noise-free "
              "truth (below). Light comes from the left; the mirror direction is at (.5, 0).",
              std::move(data), std::move(layout));
}

void add_truth_comparison(Page& page, CalibratedBench& at, const formats::FitResult& fit,
                          const emulator::SampleTruth& truth) {
  std::vector<std::vector<std::string>> rows;
  std::vector<HemisphereError> parts;
  for (const double nm : paper::wavelengths_nm)
    for (const double theta_i_deg : judged_incidences_deg) {
      parts.push_back(hemisphere_error(fit, truth, nm, theta_i_deg));
      const auto& e = parts.back();
      rows.push_back({fmt::format("{:g}", nm), fmt::format("{:g}°", theta_i_deg),
                      fmt::format("{}", e.directions), percent(e.median), percent(e.p90),
                      percent(e.max),
                      fmt::format("{:g}°, {:g}°", e.max_theta_r_deg, e.max_phi_r_deg)});
      page.numbers()["full_brdf"].push_back({{"wavelength_nm", nm},
                                             {"theta_i_deg", theta_i_deg},
                                             {"directions", e.directions},
                                             {"median", e.median},
                                             {"p90", e.p90},
                                             {"max", e.max}});
    }
  page.table({"nm", "θi", "directions", "median error", "90th percentile", "largest", "at θr, φ"},
             std::move(rows));
  const auto all = together(parts);
  page.paragraph(fmt::format(
      "Relative size of the error of the fitted BRDF (unpolarised light) in all directions of the "
      "hemisphere, in plane and out of it, where the truth is above 1 % of its peak. Incidence 20° "
      "was not measured. All together: median **{}**, 90th percentile **{}**, largest **{}**.",
      percent(all.median), percent(all.p90), percent(all.max)));
  page.numbers()["full_brdf_all"] = {{"median", all.median}, {"p90", all.p90}, {"max", all.max}};
  at.targets.push_back(
      {"full BRDF of the red gloss paint from in-plane scans, directions above 1 "
       "% of the peak",
       "within 2 %",
       fmt::format("median {}, 90th percentile {}, largest {}", percent(all.median),
                   percent(all.p90), percent(all.max)),
       all.max <= 0.02});
}

bool holds(const formats::Estimate& e, double truth) {
  return e.lo <= truth && truth <= e.hi;
}

void add_parameters(Page& page, const formats::FitResult& fit, const emulator::SampleTruth& truth,
                    const calibrate::Alignment& alignment) {
  page.paragraph(fmt::format(
      "The paint was fitted three times, as `umov reduce --guided-by` does it: the first fit sees "
      "by "
      "the place of the lobes that the arms did not stand where they were commanded (zeros and the "
      "sample's lean together), and its model tells how the BRDF runs between the points, across "
      "the detector's disc and with the angles; the next ones take the points there. In all, "
      "incidence and exit angles stood {:+.3f}° and {:+.3f}° beside the commanded ones.",
      alignment.theta_i_deg(), alignment.theta_r_deg()));
  page.numbers()["alignment_deg"] = {{"theta_i", alignment.theta_i_deg()},
                                     {"theta_r", alignment.theta_r_deg()}};
  const auto& slope = estimate(fit, "slope_2sigma_over_tau", 0);
  const double true_slope = 2 * truth.parameter("sigma_um", 532) / truth.parameter("tau_um", 532);
  const auto& n = estimate(fit, "n", 0);
  const double true_n = truth.parameter("n", 532);
  page.paragraph(fmt::format(
      "Of the surface, the data fix the index n = {} (true {:g}) and the slope 2σ0/τ = {} (true "
      "{:g}); χ²/dof of the fit is {:.3f}.",
      interval(n), true_n, interval(slope, 5), true_slope,
      fit.chi2 / static_cast<double>(fit.dof)));
  int held = 0, all = 0;
  const auto count = [&](bool inside) {
    held += inside ? 1 : 0;
    ++all;
  };
  count(holds(n, true_n));
  count(holds(slope, true_slope));
  for (std::size_t w = 0; w < paper::wavelengths_nm.size(); ++w) {
    const double nm = paper::wavelengths_nm[w];
    count(holds(estimate(fit, "k_dd", w), truth.parameter("k_dd", nm)));
    count(holds(estimate(fit, "k_udf+k_uds", w),
                truth.parameter("k_udf", nm) + truth.parameter("k_uds", nm)));
  }
  page.paragraph(fmt::format(
      "The 95 % intervals of n, slope, k_dd and k_udf + k_uds hold the truth in {} of {} cases.",
      held, all));
  page.numbers()["intervals_held"] = {{"held", held}, {"of", all}};
  if (!fit.identifiability.empty()) {
    page.paragraph("What the fit itself says about what can be known:");
    page.list(fit.identifiability);
  }
}

}  // namespace

void add_red_paint(Page& page, CalibratedBench& at, const Options& options) {
  invert::Options how;
  how.seed = options.seed;
  how.threads = options.threads;
  how.held_out = false;
  how.dhr = false;
  double from = 0.75;
  how.progress = [&](double share, const std::string& stage) {
    if (options.keep_going && !options.keep_going()) throw Stopped{};
    if (options.progress) options.progress(from + 0.08 * share, "inversion: " + stage);
  };
  // Each fit tells the next reduction where the angles stood; two bring what is left below .005°.
  const auto table = at.reduced("red-gloss");
  calibrate::ReduceOptions guided;
  auto fit = invert::invert(table, how);
  for (int round = 0; round < 2; ++round) {
    guided.alignment += calibrate::alignment_found(fit, at.campaign.calibration.declared);
    guided.shape = invert::brdf_function(fit);
    from += 0.08;
    how.dhr = round == 1;
    how.dhr_theta_i_deg = {0, 10, 30, 45, 60};
    fit = invert::invert(at.reduced("red-gloss", guided), how);
  }
  fit.data_file = at.bench.file("red-gloss").string();
  fit.program = UMOV_STUDY_PROGRAM;
  fit.command = options.command;
  formats::write_fit((options.folder / "red-gloss-fit.json").string(), fit);
  const emulator::SampleTruth truth("red-gloss");
  add_tables_3_and_4(page, fit, truth);
  add_dhr(page, at, fit, truth);
  add_parameters(page, fit, truth, guided.alignment);
  add_figure_9(page, table, fit);
  add_figure_11(page, fit, truth);
  add_truth_comparison(page, at, fit, truth);
}

}  // namespace umov::study
