// The model against the measurement: residuals in the plane of incidence, prediction out of it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "host/invert/prediction.hpp"
#include "host/report/json_parts.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {

namespace {

struct Compared {
  std::vector<std::size_t> index;  ///< rows of the view's table
  invert::Prediction prediction;   ///< one entry for each of these
};

/// The rows that were used and whose wavelength was fitted.
Compared compare(const SampleView& view) {
  Compared out;
  formats::BrdfTable part;
  part.keys = view.table->keys;
  const auto& from = view.table->points;
  for (const auto& factor : view.table->factors) part.factors.push_back({factor.name, {}});
  for (std::size_t i = 0; i < from.size(); ++i) {
    const auto fitted = view.fitted(view.point_place[i].wavelength);
    if (from.used[i] == 0 || !fitted) continue;
    out.index.push_back(i);
    auto& to = part.points;
    to.theta_i_deg.push_back(from.theta_i_deg[i]);
    to.theta_r_deg.push_back(from.theta_r_deg[i]);
    to.phi_r_deg.push_back(from.phi_r_deg[i]);
    to.wavelength_nm.push_back(view.fit->wavelengths_nm[*fitted]);
    to.polarizer_deg.push_back(from.polarizer_deg[i]);
    to.analyzer_deg.push_back(from.analyzer_deg[i]);
    to.brdf_per_sr.push_back(from.brdf_per_sr[i]);
    to.brdf_u.push_back(from.brdf_u[i]);
    to.used.push_back(1);
    for (std::size_t k = 0; k < part.factors.size(); ++k)
      part.factors[k].per_point.push_back(view.table->factors[k].per_point[i]);
  }
  if (!out.index.empty()) out.prediction = invert::predict(*view.fit, part);
  return out;
}

/// Did the fit use these points? It says how many, not which: all, or those in the plane.
bool fit_saw_everything(const SampleView& view, const Compared& compared) {
  return view.fit->points >= compared.index.size();
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

Json statistics(const std::vector<double>& relative) {
  if (relative.empty()) return {{"points", "0"}, {"median", "–"}, {"p90", "–"}, {"mean", "–"}};
  std::vector<double> size;
  double sum = 0;
  for (const double r : relative) size.push_back(std::abs(r)), sum += r;
  const auto percent = [](double x) { return fmt::format("{:.2f} %", 100 * x); };
  std::string mean = percent(sum / static_cast<double>(relative.size()));
  mean = mean.front() == '-' ? "−" + mean.substr(1) : "+" + mean;
  return {{"points", count(static_cast<long long>(relative.size()))},
          {"median", percent(quantile(size, 0.5))},
          {"p90", percent(quantile(size, 0.9))},
          {"mean", mean}};
}

}  // namespace

Json residuals(const SampleView& view) {
  if (!view.table || !view.model) return nullptr;
  const Compared compared = compare(view);
  struct Group {
    std::vector<double> x, z;
  };
  std::map<std::tuple<std::size_t, std::size_t, std::size_t>, Group> groups;
  for (std::size_t n = 0; n < compared.index.size(); ++n) {
    const std::size_t i = compared.index[n];
    const Place& place = view.point_place[i];
    const double z = compared.prediction.residual[n];
    if (!place.in_plane || !std::isfinite(z)) continue;
    Group& group = groups[{place.theta_i, place.state, place.wavelength}];
    group.x.push_back(
        signed_theta_r(view.table->points.theta_r_deg[i], view.table->points.phi_r_deg[i]));
    group.z.push_back(z);
  }
  if (groups.empty()) return nullptr;
  Json list = Json::array(), theta = Json::array();
  std::vector<bool> state_used(view.states.size(), false);
  for (const auto& [key, group] : groups) {
    const auto& [theta_i, state, wavelength] = key;
    const State& axes = view.states[state];
    list.push_back({{"theta_i_deg", view.theta_i_deg[theta_i]},
                    {"wavelength_nm", view.wavelengths_nm[wavelength]},
                    {"state", axes.id()},
                    {"label", axis_name(axes.polarizer_deg) + " → " + axis_name(axes.analyzer_deg)},
                    {"x", rounded(group.x, 6)},
                    {"z", rounded(group.z, 4)}});
    const Json incidence = view.theta_i_deg[theta_i];
    if (std::find(theta.begin(), theta.end(), incidence) == theta.end()) theta.push_back(incidence);
    state_used[state] = true;
  }
  std::vector<State> states;
  for (std::size_t s = 0; s < state_used.size(); ++s)
    if (state_used[s]) states.push_back(view.states[s]);
  std::string note = "σ is the uncertainty that is independent from point to point";
  if (view.fit->floor_relative > 0)
    note += fmt::format(", with the {} % that the fit allowed for the model",
                        plain(100 * view.fit->floor_relative, 2));
  note += view.table->factors.empty()
              ? "."
              : "; the calibration shifts that the fit found are taken out first.";
  return {{"theta_i_deg", theta},
          {"states", states_json(states)},
          {"groups", std::move(list)},
          {"note", note}};
}

Json prediction(const SampleView& view) {
  if (!view.table || !view.model) return nullptr;
  if (std::none_of(view.point_place.begin(), view.point_place.end(),
                   [](const Place& p) { return !p.in_plane; }))
    return nullptr;
  const Compared compared = compare(view);
  struct Group {
    std::vector<double> theta_r, phi_r, measured, model;
  };
  using Key = std::tuple<std::size_t, std::size_t, std::size_t,
                         bool>;  // state, wavelength, incidence, in plane
  std::map<Key, Group> groups;
  std::map<std::pair<std::size_t, std::size_t>, std::array<std::vector<double>, 2>> errors;
  std::size_t outside = 0;
  for (std::size_t n = 0; n < compared.index.size(); ++n) {
    const std::size_t i = compared.index[n];
    const auto& points = view.table->points;
    const Place& place = view.point_place[i];
    const double measured = points.brdf_per_sr[i], model = compared.prediction.brdf_per_sr[n];
    // A relative error needs something to relate to.
    if (!(measured > 0) || !std::isfinite(model)) continue;
    Group& group = groups[{place.state, place.wavelength, place.theta_i, place.in_plane}];
    group.theta_r.push_back(points.theta_r_deg[i]);
    group.phi_r.push_back(points.phi_r_deg[i]);
    group.measured.push_back(measured);
    group.model.push_back(model);
    errors[{place.state, place.wavelength}][place.in_plane ? 0 : 1].push_back(model / measured - 1);
    if (!place.in_plane) ++outside;
  }
  if (outside == 0) return nullptr;
  Json list = Json::array();
  std::vector<double> incidences, wavelengths;
  for (const auto& [key, group] : groups) {
    const auto& [state, wavelength, theta_i, plane] = key;
    list.push_back({{"state", view.states[state].id()},
                    {"wavelength_nm", view.wavelengths_nm[wavelength]},
                    {"theta_i_deg", view.theta_i_deg[theta_i]},
                    {"in_plane", plane},
                    {"theta_r_deg", rounded(group.theta_r, 4)},
                    {"phi_r_deg", rounded(group.phi_r, 5)},
                    {"measured", rounded(group.measured, 5)},
                    {"model", rounded(group.model, 5)}});
    incidences.push_back(view.theta_i_deg[theta_i]);
    wavelengths.push_back(view.wavelengths_nm[wavelength]);
  }
  Json table = Json::array();
  std::vector<State> states;
  for (const auto& [key, sides] : errors) {
    const State& state = view.states[key.first];
    if (std::find(states.begin(), states.end(), state) == states.end()) states.push_back(state);
    table.push_back(
        {{"state", axis_name(state.polarizer_deg) + " → " + axis_name(state.analyzer_deg)},
         {"wavelength_nm", view.wavelengths_nm[key.second]},
         {"in_plane", statistics(sides[0])},
         {"out_of_plane", statistics(sides[1])}});
  }
  const bool all = fit_saw_everything(view, compared);
  return {{"lead", all ? "Directions outside the plane of incidence; the fit used them too."
                       : "The model knows only what was measured in the plane of incidence; here "
                         "it is held against directions "
                         "outside it, which the fit did not see."},
          {"note", all ? "All of them were fitted." : "Only part of them was fitted."},
          {"theta_i_deg", clusters(incidences, 0.005)},
          {"wavelengths_nm", clusters(wavelengths, 0.005)},
          {"states", states_json(states)},
          {"groups", std::move(list)},
          {"statistics", std::move(table)}};
}

}  // namespace umov::report
