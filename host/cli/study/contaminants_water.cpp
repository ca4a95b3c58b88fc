// Figures 8 and 9: water drops on a black paint.
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "host/cli/study/contaminants_parts.hpp"
#include "host/cli/study/plots.hpp"
#include "host/optics/angles.hpp"

namespace umov::study {
namespace {

constexpr std::array angles{20.0, 60.0};
constexpr std::array contact_angles{15.0, 90.0, 180.0};
constexpr std::array coverages{0.05, 0.10, 0.30, 0.50, 0.75};
constexpr std::array colours{"#1f5fbf", "#16883a", "#d4331d", "#74296f", "#c86a06"};
constexpr double half_covered = 0.50;
// Rays that are reflected once inside a drop turn back at 42° from where they came, in any drop.
constexpr double rainbow_deg = 42.0;

std::string scene(double contact, double coverage) {
  return fmt::format(
      "{}[substrate]\nmodel = \"lambertian\"\nrho = 0.04\n[[drops]]\ncontact_angle_deg = {}\n"
      "coverage = {}\nradius_um = 30\nindex = \"H2O_Hale\"\n",
      band_text, contact, coverage);
}

// How far a place stands out over the line between its neighbourhoods, in standard errors.
struct Peak {
  double height, sigma, at_deg;
};

Peak peak_near(const InPlane& p, double theta_deg) {
  Peak best{0.0, 0.0, theta_deg};
  for (double at = theta_deg - 4.0; at <= theta_deg + 4.0; at += 2.0) {
    const trace::Estimate middle = p.mean(at - 2.5, at + 2.5);
    const trace::Estimate left = p.mean(at - 14.0, at - 8.0);
    const trace::Estimate right = p.mean(at + 8.0, at + 14.0);
    const double base = 0.5 * (left.mean + right.mean);
    const double u = std::hypot(middle.error, 0.5 * left.error, 0.5 * right.error);
    if ((middle.mean - base) / u > best.sigma) {
      best = {middle.mean / base - 1.0, (middle.mean - base) / u, at};
    }
  }
  return best;
}

void curves(Page& page, const std::string& name, const std::string& caption,
            const std::vector<std::string>& names, const std::vector<InPlane>& planes,
            const InPlane& dry, bool polarised) {
  Json data = Json::array();
  const auto add = [&](const std::string& label, const InPlane& plane, const char* colour) {
    data.push_back(
        line(label, plane.theta_deg, polarised ? plane.s1 : plane.times_cosine(), colour));
  };
  add("dry", dry, "#1c222b");
  for (std::size_t k = 0; k < planes.size(); ++k) add(names[k], planes[k], colours[k]);
  page.figure(
      name, caption, data,
      axes("θr / °, forward > 0", polarised ? "m10/m00" : "BRDF · cos θr / sr<sup>−1</sup>"));
}

// Root mean square of f/dry - 1 over |θr| <= 70°, without what noise makes of it.
double difference(const InPlane& wet, const InPlane& dry) {
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < wet.brdf.size(); ++i) {
    if (std::abs(wet.theta_deg[i]) > 70.0) continue;
    const double d = wet.brdf[i] / dry.brdf[i] - 1.0;
    const double u = std::hypot(wet.brdf_u[i], dry.brdf_u[i]) / dry.brdf[i];
    sum += d * d - u * u;
    ++count;
  }
  return std::sqrt(std::max(0.0, sum / count));
}

bool rises(const std::vector<double>& values) {
  return std::is_sorted(values.begin(), values.end());
}

std::string listed(const std::vector<double>& values, const char* form) {
  std::string text;
  for (const double v : values) {
    text += (text.empty() ? "" : ", ") + fmt::format(fmt::runtime(form), v);
  }
  return text;
}

}  // namespace

void add_water(Page& page, SurfaceBench& bench) {
  page.heading("Water drops on a black paint");
  page.paragraph(
      "Lambertian paint of 4 %, drops of one size at random without overlap (water of Hale and "
      "Querry, "
      "with its absorption).");
  std::array<InPlane, 2> dry;
  std::array<std::vector<InPlane>, 2> by_contact, by_coverage;
  for (std::size_t a = 0; a < 2; ++a) {
    dry[a] = in_plane(
        bench.simulate(scene(90.0, half_covered), angles[a], {.part = surface::Part::bare}), bands);
    for (const double contact : contact_angles) {
      by_contact[a].push_back(in_plane(bench.simulate(scene(contact, half_covered), angles[a], {},
                                                      contact == 180.0 ? 4 * launches : launches),
                                       bands));
    }
    for (const double coverage : coverages) {
      by_coverage[a].push_back(
          in_plane(bench.simulate(scene(90.0, coverage), angles[a], {}), bands));
    }
  }
  const std::vector<std::string> contact_names{"15°", "90°", "180°"};
  const std::vector<std::string> coverage_names{"5 %", "10 %", "30 %", "50 %", "75 %"};
  page.heading("Figure 8: contact angle, half of the ground covered");
  for (std::size_t a = 0; a < 2; ++a) {
    curves(page, fmt::format("figure-8-{:.0f}", angles[a]),
           fmt::format("In plane, light from {:.0f}°, by contact angle", angles[a]), contact_names,
           by_contact[a], dry[a], false);
    curves(page, fmt::format("figure-8-{:.0f}-s1", angles[a]),
           fmt::format("Signed degree of polarisation, light from {:.0f}°", angles[a]),
           contact_names, by_contact[a], dry[a], true);
  }
  page.heading("Figure 9: coverage, contact angle 90°");
  for (std::size_t a = 0; a < 2; ++a) {
    curves(page, fmt::format("figure-9-{:.0f}", angles[a]),
           fmt::format("In plane, light from {:.0f}°, by coverage", angles[a]), coverage_names,
           by_coverage[a], dry[a], false);
    curves(page, fmt::format("figure-9-{:.0f}-s1", angles[a]),
           fmt::format("Signed degree of polarisation, light from {:.0f}°", angles[a]),
           coverage_names, by_coverage[a], dry[a], true);
  }

  std::vector<Target> targets;
  const auto& [flat, half, whole] = std::tie(by_contact[0][0], by_contact[0][1], by_contact[0][2]);
  const Peak one = peak_near(whole, -angles[0] + rainbow_deg);
  const Peak other = peak_near(whole, -angles[0] - rainbow_deg);
  targets.push_back(
      {"two rainbow peaks at 180°, light from 20°", "near 22° and −62°",
       fmt::format("{:.0f}° (+{:.0f} %, {:.0f} σ) and {:.0f}° (+{:.0f} %, {:.0f} σ)", one.at_deg,
                   100 * one.height, one.sigma, other.at_deg, 100 * other.height, other.sigma),
       one.sigma > 5.0 && other.sigma > 5.0});
  const Peak late = peak_near(by_contact[1][2], -angles[1] + rainbow_deg);
  targets.push_back(
      {"no rainbow peak at 180°, light from 60°", "none near −18°",
       late.sigma > 5.0
           ? fmt::format("one of +{:.0f} % ({:.0f} σ) at {:.0f}°, {:.2f} of that at 20°",
                         100 * late.height, late.sigma, late.at_deg, late.height / one.height)
           : fmt::format("{:.1f} σ", late.sigma),
       late.sigma <= 5.0});
  const trace::Estimate specular = flat.mean(10.0, 30.0);
  const trace::Estimate beside = flat.mean(-60.0, -30.0);
  const trace::Estimate polarised = flat.mean_s1(15.0, 55.0);
  targets.push_back(
      {"15°: a broad peak about 20°, polarised around it", "BRDF and m10/m00 above",
       fmt::format("BRDF {:.4f} against {:.4f} at −60° to −30°; m10/m00 {:+.3f} ± {:.3f} "
                   "from 15° to 55°",
                   specular.mean, beside.mean, polarised.mean, polarised.error),
       specular.mean > 1.5 * beside.mean && polarised.mean > 5.0 * polarised.error});
  const std::array<double, 3> off{difference(flat, dry[0]), difference(half, dry[0]),
                                  difference(whole, dry[0])};
  targets.push_back({"90° is close to the dry surface at 20°", "nearest of the three",
                     fmt::format("rms off by {:.0f} % (15°: {:.0f} %, 180°: {:.0f} %)",
                                 100 * off[1], 100 * off[0], 100 * off[2]),
                     off[1] < off[0] && off[1] < off[2]});
  std::vector<double> same, forward, back, s1;
  for (std::size_t k = 0; k < coverages.size(); ++k) {
    same.push_back(by_coverage[0][k].mean(-60.0, 60.0).mean / dry[0].mean(-60.0, 60.0).mean - 1.0);
    forward.push_back(by_coverage[1][k].mean(70.0, 84.0).mean / dry[1].mean(70.0, 84.0).mean);
    back.push_back(by_coverage[1][k].mean(-84.0, -70.0).mean / dry[1].mean(-84.0, -70.0).mean);
    s1.push_back(by_coverage[1][k].mean_s1(60.0, 84.0).mean);
  }
  const double most = std::max(std::abs(*std::min_element(same.begin(), same.end())),
                               std::abs(*std::max_element(same.begin(), same.end())));
  targets.push_back({"90°: coverage changes nothing at 20°", "within 15 % of dry, θr up to 60°",
                     listed(same, "{:+.3f}") + " of dry", most < 0.15});
  targets.push_back({"90°: more oblique forward light at 60° with coverage", "rises",
                     listed(forward, "{:.2f}") + " of dry, 70° to 84°", rises(forward)});
  targets.push_back({"90°: more oblique back scatter at 60° with coverage", "rises",
                     listed(back, "{:.2f}") + " of dry, −84° to −70°", rises(back)});
  targets.push_back({"90°: more polarisation of oblique forward light at 60°", "rises",
                     "m10/m00 " + listed(s1, "{:+.3f}") + " from 60° to 84°", rises(s1)});
  page.heading("The paper's statements on water");
  page.targets(targets);
  page.paragraph(
      "Where ours differs: at 60° the rainbow of drops of 180° is weaker, not gone; drops of one "
      "size at half coverage leave room for its light between them. Drops of 90° send oblique "
      "light "
      "forward, as in the paper, but not back. How the paper's drops lay and which sizes they had "
      "is "
      "not published.");
}

}  // namespace umov::study
