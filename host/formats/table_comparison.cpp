#include "host/formats/table_comparison.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "host/brdf/table_dhr.hpp"
#include "host/formats/klems_means.hpp"
#include "host/formats/specular_table.hpp"
#include "host/formats/spread.hpp"
#include "host/formats/table_file.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/mueller.hpp"

namespace umov::formats {
namespace {

constexpr std::size_t directions = 1000;
constexpr double integral_accuracy = 1e-4;
constexpr int most_divisions = 512;

brdf::Geometry<double> direction(std::size_t index) {
  const double most = optics::radians(TableDifference::most_deg);
  const double a = spread(index + 1, 2), b = spread(index + 1, 3), c = spread(index + 1, 5);
  const double theta_i = most * a;
  if (index % 2 == 0) return {theta_i, most * b, optics::pi * (2.0 * c - 1.0)};
  auto g = geometry_of(theta_i, {optics::radians(20.0) * b * b, 2.0 * optics::pi * c});
  g.theta_r = std::min(g.theta_r, most);
  return g;
}

}  // namespace

std::string TableDifference::sentence(std::string_view from) const {
  return fmt::format(
      "differs from {} by {:.2g} % (median), {:.2g} % (95 % of {} directions with angles up to "
      "{:g} deg), {:.2g} % at most",
      from, 100 * median, 100 * p95, directions, most_deg, 100 * worst);
}

TableDifference compare_tables(const brdf::Table& table, const brdf::Table& reference,
                               const std::vector<double>& wavelengths_um,
                               const std::vector<double>& reference_wavelengths_um,
                               const std::function<bool(const brdf::Geometry<double>&)>& left_out) {
  // Many wavelengths share the directions between them.
  const std::size_t each = std::max<std::size_t>(directions / wavelengths_um.size(), 100);
  std::vector<double> differences;
  std::size_t next = 0;
  for (std::size_t w = 0; w < wavelengths_um.size(); ++w) {
    const double um = wavelengths_um[w];
    const double reference_um =
        reference_wavelengths_um.empty() ? um : reference_wavelengths_um.at(w);
    std::vector<double> found, expected;
    for (std::size_t i = 0; i < each; ++i) {
      const auto g = direction(next++ % directions);
      if (left_out && left_out(g)) continue;
      found.push_back(optics::element(table.at(um, g), 0, 0));
      expected.push_back(optics::element(reference.at(reference_um, g), 0, 0));
    }
    const double floor =
        expected.empty() ? 0.0 : 1e-4 * *std::max_element(expected.begin(), expected.end());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const double scale = std::max(expected[i], floor);
      differences.push_back(scale > 0.0 ? std::abs(found[i] - expected[i]) / scale : 0.0);
    }
  }
  if (differences.empty()) return {};
  std::sort(differences.begin(), differences.end());
  const auto at = [&](double share) {
    return differences[static_cast<std::size_t>(share *
                                                static_cast<double>(differences.size() - 1))];
  };
  return {differences.size(), at(0.5), at(0.95), differences.back()};
}

double ReflectanceDifference::largest() const {
  double most = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i)
    most = std::max(most, std::abs(found[i] - expected[i]));
  return most;
}

std::string ReflectanceDifference::sentence(std::string_view whose) const {
  return fmt::format("DHR at {} deg: {:.4f}; of {}: {:.4f}", fmt::join(theta_i_deg, ", "),
                     fmt::join(found, ", "), whose, fmt::join(expected, ", "));
}

ReflectanceDifference compare_reflectances(const brdf::Table& table, double wavelength_um,
                                           const brdf::Table& reference,
                                           double reference_wavelength_um, bool mirror_taken) {
  const auto reflectance = [](const brdf::Table& of, double um, double theta_i, bool mirror) {
    if (const auto* model = dynamic_cast<const ModelTable*>(&of))
      return model->dhr(um, theta_i) + (mirror ? model->mirror(um, theta_i) : 0.0);
    if (const auto* means = dynamic_cast<const KlemsMeans*>(&of))
      return means->reflectance(theta_i);
    return brdf::integrate_table(of, um, theta_i, integral_accuracy, most_divisions).value[0];
  };
  ReflectanceDifference result;
  for (std::size_t i = 0; i < result.found.size(); ++i) {
    const double theta_i = optics::radians(result.theta_i_deg[i]);
    result.found[i] = reflectance(table, wavelength_um, theta_i, mirror_taken);
    result.expected[i] = reflectance(reference, reference_wavelength_um, theta_i, mirror_taken);
  }
  return result;
}

}  // namespace umov::formats
