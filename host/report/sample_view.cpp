#include "host/report/sample_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "host/calibrate/dolp.hpp"

namespace umov::report {

namespace {

constexpr double same_wavelength_nm = 0.05;
constexpr double same_incidence_deg = 0.4;

void place_points(SampleView& view) {
  const auto& points = view.table->points;
  view.states = distinct_states(points.polarizer_deg, points.analyzer_deg);
  view.point_place.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    Place& place = view.point_place[i];
    place.wavelength = nearest(view.wavelengths_nm, points.wavelength_nm[i]);
    place.theta_i = nearest(view.theta_i_deg, points.theta_i_deg[i]);
    const State state{points.polarizer_deg[i], points.analyzer_deg[i]};
    place.state = static_cast<std::size_t>(
        std::find(view.states.begin(), view.states.end(), state) - view.states.begin());
    place.in_plane = in_plane(points.theta_r_deg[i], points.phi_r_deg[i]);
  }
  const auto& dolp = view.table->dolp;
  view.dolp_place.resize(dolp.dolp.size());
  for (std::size_t i = 0; i < dolp.dolp.size(); ++i) {
    view.dolp_place[i] = {nearest(view.wavelengths_nm, dolp.wavelength_nm[i]),
                          nearest(view.theta_i_deg, dolp.theta_i_deg[i]), 0,
                          in_plane(dolp.theta_r_deg[i], dolp.phi_r_deg[i])};
  }
}

std::vector<double> total_uncertainty(const formats::BrdfTable& table) {
  std::vector<double> total(table.points.size());
  for (std::size_t i = 0; i < total.size(); ++i) {
    double variance = table.points.brdf_u[i] * table.points.brdf_u[i];
    for (const auto& factor : table.factors) variance += factor.per_point[i] * factor.per_point[i];
    total[i] = std::sqrt(variance);
  }
  return total;
}

}  // namespace

std::string key_of(const formats::BrdfTable& table, const std::string& name) {
  for (const auto& [key, value] : table.keys)
    if (key == name) return value;
  return {};
}

std::optional<std::size_t> SampleView::fitted(std::size_t wavelength) const {
  if (fit == nullptr) return std::nullopt;
  for (std::size_t i = 0; i < fit->wavelengths_nm.size(); ++i)
    if (std::abs(fit->wavelengths_nm[i] - wavelengths_nm[wavelength]) <= 2 * same_wavelength_nm)
      return i;
  return std::nullopt;
}

SampleView view_of(const Sample& sample) {
  SampleView view;
  view.sample = &sample;
  std::vector<double> wavelengths, incidences;
  double solid_angle_sr = 0;
  if (sample.brdf) {
    view.table = sample.brdf->file.table;
    if (view.table->dolp.dolp.empty()) calibrate::add_dolp(*view.table);
    wavelengths = view.table->points.wavelength_nm;
    incidences = view.table->points.theta_i_deg;
    solid_angle_sr = std::strtod(key_of(*view.table, "solid_angle_sr").c_str(), nullptr);
  }
  if (sample.fit) {
    view.fit = &sample.fit->fit;
    view.model.emplace(*view.fit, solid_angle_sr);
    wavelengths.insert(wavelengths.end(), view.fit->wavelengths_nm.begin(),
                       view.fit->wavelengths_nm.end());
    if (incidences.empty())
      for (const auto& entry : view.fit->dhr) incidences.push_back(entry.theta_i_deg);
    if (incidences.empty()) incidences = {0, 30, 60};
  }
  view.wavelengths_nm = clusters(std::move(wavelengths), same_wavelength_nm);
  view.theta_i_deg = clusters(std::move(incidences), same_incidence_deg);
  if (view.table) {
    place_points(view);
    view.total_u = total_uncertainty(*view.table);
  }
  return view;
}

}  // namespace umov::report
