// Black paints (figure 8) of the study `reflectometer`.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "host/cli/emulator/truth.hpp"
#include "host/cli/study/plots.hpp"
#include "host/cli/study/reduced.hpp"
#include "host/cli/study/reflectometer_parts.hpp"

namespace umov::study {
namespace {

constexpr double nm = 532, incidence_deg = 30;
constexpr double open = std::numeric_limits<double>::quiet_NaN();

struct Paint {
  const char* name;
  const char* title;
  const char* colour;
};
constexpr std::array<Paint, 3> paints = {{{"black-matte", "matte", "#5a6472"},
                                          {"black-semi-gloss", "matte-glossy", "#c86a06"},
                                          {"black-gloss", "glossy", "#1f5fbf"}}};

/// Value at an angle; NaN where it was not measured.
double at_angle(const Curve& curve, double theta_r_deg) {
  for (std::size_t i = 0; i < curve.value.size(); ++i)
    if (std::abs(curve.theta_r_deg[i] - theta_r_deg) < 1e-6) return curve.value[i];
  return NAN;
}

double u_at_angle(const Curve& curve, double theta_r_deg) {
  for (std::size_t i = 0; i < curve.value.size(); ++i)
    if (std::abs(curve.theta_r_deg[i] - theta_r_deg) < 1e-6) return curve.u[i];
  return NAN;
}

/// One panel of BRDF above one of DOLP, numbered 1 to 3 and 4 to 6 from the left.
void place_panel(Json& layout, int column, const char* title) {
  const double left = 0.37 * column, right = left + 0.26;
  const std::string above = column == 0 ? "" : std::to_string(column + 1);
  const std::string below = std::to_string(column + 4);
  const auto x_axis = [&](const std::string& other) {
    return Json{{"title", {{"text", "θ<sub>r</sub> / °"}}},
                {"domain", {left, right}},
                {"anchor", "y" + other},
                {"dtick", 40}};
  };
  layout["xaxis" + above] = x_axis(above);
  layout["yaxis" + above] = {{"title", {{"text", "BRDF / sr<sup>−1</sup>"}}},
                             {"type", "log"},
                             {"domain", {0.58, 0.97}},
                             {"anchor", "x" + above},
                             {"dtick", 1},
                             {"range", {-3, 1}}};
  layout["xaxis" + below] = x_axis(below);
  layout["yaxis" + below] = {{"title", {{"text", "DOLP / 1"}}},
                             {"domain", {0.0, 0.4}},
                             {"anchor", "x" + below},
                             {"range", {-0.05, 1.05}}};
  layout["annotations"].push_back({{"text", title},
                                   {"x", left + 0.13},
                                   {"y", 1.04},
                                   {"xref", "paper"},
                                   {"yref", "paper"},
                                   {"showarrow", false}});
}

}  // namespace

void add_black_paints(Page& page, CalibratedBench& at) {
  page.heading("Black paints of three glosses (figure 8)");
  Json data = Json::array(),
       layout = {
           {"width", 1120}, {"height", 760}, {"showlegend", false}, {"annotations", Json::array()}};
  std::vector<std::vector<std::string>> rows;
  std::vector<double> peaks, dolps;
  double worst = 0;
  for (std::size_t i = 0; i < paints.size(); ++i) {
    const Paint& paint = paints[i];
    const int column = static_cast<int>(i);
    const auto table = at.reduced(paint.name);
    const emulator::SampleTruth truth(paint.name);
    const Curve brdf = state_curve(table, nm, incidence_deg, 0, open);
    const Curve dolp = dolp_curve(table, nm, incidence_deg);
    std::vector<double> theta, true_brdf, true_dolp;
    for (double angle = -80; angle <= 80; angle += 0.5) {
      theta.push_back(angle);
      true_brdf.push_back(truth.brdf(incidence_deg, angle, 0, nm, 0, open));
      true_dolp.push_back(truth.dolp(incidence_deg, angle, 0, nm));
    }
    data.push_back(on(line("truth", theta, true_brdf, "#aab3bf"), column + 1));
    data.push_back(
        on(points(paint.title, brdf.theta_r_deg, brdf.value, brdf.u, paint.colour), column + 1));
    data.push_back(on(line("truth", theta, true_dolp, "#aab3bf"), column + 4));
    data.push_back(
        on(points(paint.title, dolp.theta_r_deg, dolp.value, dolp.u, paint.colour), column + 4));
    place_panel(layout, column, paint.title);
    const double peak = at_angle(brdf, incidence_deg), mirror = at_angle(dolp, incidence_deg);
    const double exact = truth.dolp(incidence_deg, incidence_deg, 0, nm);
    peaks.push_back(peak);
    dolps.push_back(mirror);
    worst = std::max(worst, std::abs(mirror - exact));
    rows.push_back({paint.title, fmt::format("{:.3g}", peak),
                    fmt::format("{:.3g}", truth.brdf(incidence_deg, incidence_deg, 0, nm, 0, open)),
                    with_u(mirror, u_at_angle(dolp, incidence_deg), 4), fixed(exact, 4),
                    fixed(at_angle(dolp, -40), 3),
                    fixed(truth.dolp(incidence_deg, -40, 0, nm), 3)});
    page.numbers()["figure_8"].push_back(
        {{"paint", paint.name}, {"peak_per_sr", peak}, {"dolp", mirror}, {"dolp_truth", exact}});
  }
  page.figure("figure-8",
              "As figure 8 of the paper: BRDF for P-polarised light (above) and DOLP (below) of "
              "three black paints at 30° incidence, 532 nm. Points: measured; grey: truth.",
              std::move(data), std::move(layout));
  page.table(
      {"paint", "BRDF at 30° / sr⁻¹", "truth", "DOLP at 30°", "truth", "DOLP at −40°", "truth"},
      std::move(rows));
  const bool ordered =
      std::is_sorted(peaks.begin(), peaks.end()) && std::is_sorted(dolps.begin(), dolps.end());
  page.paragraph(fmt::format(
      "The paper's finding, \"the glossier the paint coating, the more directional the BRDF and "
      "the higher the DOLP at reflection angle\", {} here. The largest error of the DOLP in the "
      "mirror direction is {:.4f}.",
      ordered ? "shows" : "does not show", worst));
  page.numbers()["figure_8_ordered"] = ordered;
}

}  // namespace umov::study
