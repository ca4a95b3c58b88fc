#include "host/brdf/checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "host/brdf/evaluate.hpp"
#include "host/brdf/sampling_directions.hpp"
#include "host/optics/realisability.hpp"

namespace umov::brdf {
namespace {

using optics::element;
using optics::Mueller;
using optics::radians;

constexpr double steepest = 85.0;

/// Radical inverse: evenly spread numbers in (0, 1).
double halton(int index, int base) {
  double value = 0.0, digit = 1.0;
  for (int i = index + 1; i > 0; i /= base) {
    digit /= base;
    value += digit * (i % base);
  }
  return value;
}

Geometry<double> probe(int index) {
  const double theta_i = radians(steepest) * halton(index, 2);
  const double a = halton(index, 3), b = halton(index, 5);
  if (index % 2 == 0) return {theta_i, radians(steepest) * a, optics::pi * b};
  // Facet slopes from 1e-4 to 1.
  const double slope = std::pow(10.0, -4.0 * a);
  const optics::Vec3<double> to = mirrored(Incidence(theta_i), slope * std::cos(optics::pi * b),
                                           slope * std::sin(optics::pi * b));
  const Geometry<double> g = geometry_of(theta_i, to);
  if (g.theta_r < radians(steepest)) return g;
  return {theta_i, theta_i, optics::pi * slope};
}

Mueller<double> reversed(const Mueller<double>& m) {
  constexpr double sign[4] = {1.0, 1.0, -1.0, 1.0};
  Mueller<double> r(0.0);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column)
      optics::set_element(r, row, column, sign[row] * sign[column] * element(m, column, row));
  }
  return r;
}

template <class Measure>
WorstCase worst(const Model& model, std::span<const double> values, double wavelength_um,
                int geometries, Measure measure) {
  const auto at = [&](const Geometry<double>& g) {
    return evaluate<double>(model, values, wavelength_um, g);
  };
  WorstCase found;
  for (int i = 0; i < geometries; ++i) {
    const Geometry<double> g = probe(i);
    const double amount = measure(at(g), g, at);
    if (amount > found.amount) found = {amount, g};
  }
  return found;
}

}  // namespace

std::optional<std::vector<double>> lossless(const Model& model, std::span<const double> values) {
  if (model.components().size() != 1) return std::nullopt;
  switch (model.components().front().kind) {
    case Kind::nef:
    case Kind::beard_maxwell:
    case Kind::tabulated:
      return std::nullopt;
    default:
      break;
  }
  std::vector<double> without_loss(values.begin(), values.end());
  // An interface to cross must not become a mirror.
  bool crossed = true;
  for (const Parameter& parameter : model.parameters()) crossed &= parameter.name != "kappa";
  for (std::size_t i = 0; i < without_loss.size(); ++i) {
    const std::string_view name = model.parameters()[i].name;
    double& value = without_loss[i];
    if (name == "n" && !crossed) value = 0.05;
    if (name == "kappa") value = 100.0;
    if (name == "rho" || name == "albedo" || name == "ks" || name == "bias" || name == "k_dd")
      value = 1.0;
    if (name == "k_udf" || name == "k_uds" || name == "k_fs") value = 0.0;
  }
  return without_loss;
}

WorstCase reciprocity_violation(const Model& model, std::span<const double> values,
                                double wavelength_um, int geometries) {
  return worst(model, values, wavelength_um, geometries,
               [](const Mueller<double>& there, const Geometry<double>& g, const auto& at) {
                 const Mueller<double> back = reversed(at({g.theta_r, g.theta_i, -g.phi_r}));
                 const double scale = std::max(element(there, 0, 0), element(back, 0, 0));
                 if (!(scale > 1e-200)) return 0.0;  // far outside a narrow lobe: no digits
                 double difference = 0.0;
                 for (int k = 0; k < 16; ++k) {
                   difference = std::max(difference, std::abs(element(there, k / 4, k % 4) -
                                                              element(back, k / 4, k % 4)));
                 }
                 return difference / scale;
               });
}

double unrealisable_share(const Mueller<double>& m) {
  const double m00 = element(m, 0, 0);
  if (!(m00 > 0.0)) return 0.0;
  std::array<double, 16> rows;
  for (int k = 0; k < 16; ++k) rows[static_cast<std::size_t>(k)] = element(m, k / 4, k % 4) / m00;
  return -optics::realisability(rows).least_eigenvalue;
}

WorstCase realisability_violation(const Model& model, std::span<const double> values,
                                  double wavelength_um, int geometries) {
  return worst(model, values, wavelength_um, geometries,
               [](const Mueller<double>& m, const Geometry<double>&, const auto&) {
                 return element(m, 0, 0) > 1e-200 ? unrealisable_share(m) : 0.0;
               });
}

}  // namespace umov::brdf
