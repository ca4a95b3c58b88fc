#include "host/brdf/dhr.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "host/brdf/adaptive_quadrature.hpp"
#include "host/brdf/evaluate.hpp"
#include "host/brdf/sampling_directions.hpp"
#include "host/brdf/table_dhr.hpp"
#include "host/errors/error.hpp"

namespace umov::brdf {
namespace {

void check_incidence(double theta_i) {
  if (theta_i >= 0.0 && theta_i < 0.5 * optics::pi) return;
  throw Error(fmt::format("incidence at {:g} degrees has no reflectance", optics::degrees(theta_i)),
              "give an angle from 0 up to, not including, 90 degrees");
}

/// Takes the place of a table whose integral is known.
class NoTable : public Table {
 public:
  optics::Mueller<double> at(double, const Geometry<double>&) const override {
    return optics::Mueller<double>(0.0);
  }
  const std::vector<double>& wavelengths_um() const override { return wavelengths_um_; }
  bool polarised() const override { return false; }
  std::string description() const override { return "nothing"; }

 private:
  std::vector<double> wavelengths_um_{1.0};
};

/// Between which slopes a lobe's width lies, whatever the facet's azimuth. `across` is how much
/// narrower it is along the plane of incidence (below 1) or across it (above 1).
struct LobeWidths {
  double least, greatest;
  double across = 1.0;
};

/// A lobe about the mirror direction with `width` in the facets' slope at normal incidence that is
/// round in angle: near grazing, facets tilted sideways turn the light by cos θi times less.
LobeWidths round_in_angle(double width, double cos_i) {
  return {width, width / cos_i, cos_i};
}

/// A lobe of `width` in the exit direction's sine. Where it is wider than cos θi, its slopes on the
/// side of the normal go with the root of the width.
LobeWidths round_in_sine(double width, double cos_i) {
  const double slope = 0.5 * width / cos_i;
  return {std::min(slope, std::sqrt(0.5 * width)), std::max(slope, std::sqrt(0.5 * width)), cos_i};
}

/// Terms whose integral is known: their sum is returned and their parameters are set to 0. `lobes`
/// gets the widths of what is left.
double take_exact_terms(const Model& model, std::vector<double>& parameters, double wavelength_um,
                        double theta_i, std::vector<LobeWidths>& lobes) {
  const double cos_i = std::cos(theta_i);
  double exact = 0.0;
  for (const Component& part : model.components()) {
    double* p = parameters.data() + part.first;
    switch (part.kind) {
      case Kind::lambertian:
        exact += p[0];
        p[0] = 0.0;
        break;
      case Kind::nef:
        exact += optics::pi * p[0] + 2.0 * optics::pi * p[1] / cos_i;
        p[0] = p[1] = 0.0;
        break;
      case Kind::li_torrance:
        // ∫ T(θr) cos θr dω = π T̄.
        exact += p[5] + p[6] * optics::transmittance(p[0], p[1], cos_i) /
                            optics::transmittance(p[0], p[1], 1.0);
        p[5] = p[6] = 0.0;
        if (p[7] > 0.0) lobes.push_back(round_in_angle(0.5 * optics::radians(p[8]), cos_i));
        [[fallthrough]];
      case Kind::he_torrance: {
        const double frequency = wavelength_um / (std::numbers::sqrt2 * optics::pi * p[3]);
        // The phase grows with cos θi + cos θr, and with it the lobe: up to the slopes' own width.
        const double phase = 4.0 * optics::pi * p[2] / wavelength_um;
        lobes.push_back(round_in_sine(std::max(1.0, phase * cos_i) * frequency, cos_i));
        if (phase > 1.0) {
          const double slope = std::numbers::sqrt2 * p[2] / p[3];
          lobes.push_back({slope, slope});
        }
        break;
      }
      case Kind::microfacet:
      case Kind::ggx:
        lobes.push_back({p[2], p[2]});
        break;
      case Kind::rayleigh_rice: {
        // Spatial frequencies reach to v_xy/λ = 2 cos θi · slope/λ.
        const double frequency = part.psd == Psd::gaussian
                                     ? 1.0 / (std::numbers::sqrt2 * optics::pi * p[3])
                                     : 1.0 / p[3];
        lobes.push_back(round_in_sine(wavelength_um * frequency, cos_i));
        break;
      }
      case Kind::beard_maxwell: {
        double* volume = p + part.count - 2;
        exact += optics::pi * volume[0] +
                 4.0 * optics::pi * volume[1] * (1.0 - cos_i * std::log1p(1.0 / cos_i));
        volume[0] = volume[1] = 0.0;
        lobes.push_back({p[2], p[2]});
        break;
      }
      case Kind::subsurface:
      case Kind::single_scatter:
        lobes.push_back({0.5, 0.5});
        break;
      case Kind::phong:
        lobes.push_back(round_in_angle(0.5 / std::sqrt(1.0 + p[1]), cos_i));
        break;
      case Kind::ward:
        lobes.push_back({std::min(p[1], p[2]) / std::numbers::sqrt2,
                         std::max(p[1], p[2]) / std::numbers::sqrt2, p[1] / p[2]});
        break;
      case Kind::tabulated:  // take_tables()
        break;
    }
  }
  return exact;
}

/// The integrals of all tables, which are replaced by nothing.
Integral take_tables(Model& model, double wavelength_um, double theta_i) {
  if (model.needs_table()) refuse_missing_table(model);
  Integral sum;
  const std::vector<TableSlot> slots = model.table_slots();
  for (const TableSlot& slot : slots) {
    const Integral one =
        integrate_table(*model.components()[slot.part].table, wavelength_um, theta_i);
    for (std::size_t c = 0; c < 2; ++c) sum.value[c] += one.value[c];
    sum.error += one.error;
    model = model.with_table(std::make_shared<NoTable>(), slot.part);
  }
  return sum;
}

/// Ratio of neighbouring breaks where only the order of magnitude is known: a peak anywhere between
/// two of them is seen by the 15 points.
constexpr double rung = 6.0;

/// Breaks of the slope from 0 to the horizon: between them no lobe is missed.
std::vector<double> slope_breaks(std::span<const LobeWidths> lobes, double horizon) {
  std::vector<double> breaks{0.0, horizon};
  const auto add = [&](double t) {
    if (t < 0.9 * horizon) breaks.push_back(t);
  };
  for (const LobeWidths& lobe : lobes) {
    add(3.0 * lobe.least);
    double t = 10.0 * lobe.least;
    for (; t < std::min(5.0 * lobe.greatest, 0.9 * horizon); t *= rung) add(t);
    add(t);
  }
  // At grazing incidence the horizon on the side of the normal lies far beyond all slopes.
  for (double t = 3.0; rung * t < horizon; t *= rung) add(t);
  std::sort(breaks.begin(), breaks.end());
  // Several lobes may ask for nearly the same.
  std::vector<double> apart;
  for (const double t : breaks)
    if (apart.empty() || t > 1.2 * apart.back() || t == horizon) apart.push_back(t);
  return apart;
}

/// Breaks of the facets' azimuth from 0 to π. Near grazing incidence the horizon changes sides
/// within about cos θi of π/2; long narrow lobes change there too, or at 0 and π.
std::vector<double> azimuth_breaks(std::span<const LobeWidths> lobes, double cos_i) {
  constexpr double quarter = 0.5 * optics::pi;
  double middle = cos_i, ends = 1.0;
  for (const LobeWidths& lobe : lobes) {
    middle = std::min(middle, lobe.across);
    ends = std::min(ends, 1.0 / lobe.across);
  }
  std::vector<double> breaks{0.0, quarter, optics::pi};
  for (double away = 3.0 * middle; away < 0.8; away *= rung) {
    breaks.push_back(quarter - away);
    breaks.push_back(quarter + away);
  }
  for (double away = 3.0 * ends; away < 0.8; away *= rung) {
    breaks.push_back(away);
    breaks.push_back(optics::pi - away);
  }
  std::sort(breaks.begin(), breaks.end());
  return breaks;
}

}  // namespace

Dhr dhr(const Model& whole, std::span<const double> parameters, double wavelength_um,
        double theta_i) {
  check_incidence(theta_i);
  whole.check(parameters);
  Model model = whole;
  const Integral tables = take_tables(model, wavelength_um, theta_i);
  std::vector<double> values(parameters.begin(), parameters.end());
  std::vector<LobeWidths> lobes;
  const double exact =
      take_exact_terms(model, values, wavelength_um, theta_i, lobes) + tables.value[0];
  constexpr double rounding = 1e-14;
  if (lobes.empty()) {
    return {exact, exact + tables.value[1], exact - tables.value[1],
            tables.error + rounding * std::abs(exact)};
  }

  // Exit directions by the slope (tangent t, azimuth ψ) of the facet that mirrors into them: every
  // lobe then sits at t = 0, whatever its width, and cones there (exponential slopes,
  // Maxwell-Beard) are smooth in t.
  const Incidence in(theta_i);
  double inner_error = 0.0;  // the worst, absolute below 1, relative above
  const auto along = [&](double psi) {
    const double c = std::cos(psi), s = std::sin(psi);
    const auto at = [&](double t) -> Pair {
      const optics::Vec3<double> to = mirrored(in, t * c, t * s);
      if (!(to.z > 0.0)) return {0.0, 0.0};
      const optics::Mueller<double> m = evaluate<double>(
          model, values, wavelength_um, geometry_of(theta_i, to), facet_frame(in, to));
      const double measure = Exit(in, to).sr_per_slope_area() * t * to.z;
      return {measure * optics::element(m, 0, 0), measure * optics::element(m, 0, 1)};
    };
    const Integral inner = integrate(at, slope_breaks(lobes, horizon_slope(in, c)), 2e-8);
    inner_error = std::max(inner_error, inner.error / std::max(1.0, std::abs(inner.value[0])));
    return inner.value;
  };
  // The lower half plane y < 0 mirrors the upper one: an isotropic surface, or axes along x and y.
  const Integral sum = integrate(along, azimuth_breaks(lobes, in.cosine), 2e-7);
  const double unpolarized = exact + 2.0 * sum.value[0];
  const double difference = 2.0 * sum.value[1] + tables.value[1];
  const double inner = inner_error * (optics::pi + std::abs(sum.value[0]));
  // s and p are each a sum of both functions.
  const double accuracy =
      4.0 * (sum.error + inner) + tables.error + rounding * std::abs(unpolarized);
  return {unpolarized, unpolarized + difference, unpolarized - difference, accuracy};
}

Dhr mirror_dhr(const Model& model, std::span<const double> parameters, double wavelength_um,
               double theta_i) {
  check_incidence(theta_i);
  model.check(parameters);
  const optics::Mueller<double> m =
      mirror_reflectance<double>(model, parameters, wavelength_um, theta_i);
  const double unpolarized = optics::element(m, 0, 0);
  const double difference = optics::element(m, 0, 1);
  return {unpolarized, unpolarized + difference, unpolarized - difference};
}

}  // namespace umov::brdf
