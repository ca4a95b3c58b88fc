// BRDF and DOLP against θr in the plane of incidence, with the model where one was fitted.
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "host/formats/scan_table.hpp"
#include "host/optics/angles.hpp"
#include "host/report/json_parts.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {

namespace {

/// Angles for a model line: every degree, and finer about the mirror direction.
std::vector<double> line_angles(double theta_i_deg) {
  std::vector<double> angles;
  for (int x = -88; x <= 88; ++x) angles.push_back(x);
  for (double off = -10; off <= 10; off += 0.25) angles.push_back(theta_i_deg + off);
  for (double off = -1; off <= 1; off += 0.05) angles.push_back(theta_i_deg + off);
  std::sort(angles.begin(), angles.end());
  std::vector<double> out;
  for (const double angle : angles)
    if (std::abs(angle) <= 88.5 && (out.empty() || angle - out.back() > 0.02)) out.push_back(angle);
  return out;
}

struct Series {
  std::vector<double> x, y, u, flagged_x, flagged_y;
};

void sort_by_x(Series& s) {
  std::vector<std::size_t> order(s.x.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return s.x[a] < s.x[b]; });
  const auto by = [&](std::vector<double>& list) {
    std::vector<double> sorted;
    for (const std::size_t i : order) sorted.push_back(list[i]);
    list = std::move(sorted);
  };
  by(s.x), by(s.y), by(s.u);
}

Json curve_json(Series series) {
  sort_by_x(series);
  Json out;
  out["x"] = rounded(series.x, 6);
  out["y"] = rounded(series.y);
  out["u"] = rounded(series.u, 3);
  if (!series.flagged_x.empty())
    out["flagged"] = {{"x", rounded(series.flagged_x, 6)}, {"y", rounded(series.flagged_y)}};
  return out;
}

/// Muellers of the model along the plane of incidence, made once for all states.
class ModelLines {
 public:
  explicit ModelLines(const SampleView& view) : view_(view) {}
  struct Line {
    std::vector<double> x;
    std::vector<MuellerRows> mueller;
  };
  const Line* at(std::size_t wavelength, std::size_t theta_i) {
    const auto fitted = view_.model ? view_.fitted(wavelength) : std::nullopt;
    if (!fitted) return nullptr;
    const auto [entry, fresh] = lines_.try_emplace({wavelength, theta_i});
    if (fresh) {
      const double incidence = view_.theta_i_deg[theta_i];
      entry->second.x = line_angles(incidence);
      for (const double x : entry->second.x)
        entry->second.mueller.push_back(view_.model->mueller(*fitted, incidence, x, 0));
    }
    return &entry->second;
  }

 private:
  const SampleView& view_;
  std::map<std::pair<std::size_t, std::size_t>, Line> lines_;
};

template <class Value>
Json line_json(const ModelLines::Line& line, Value&& value) {
  std::vector<double> y;
  for (const MuellerRows& m : line.mueller) y.push_back(value(m));
  return {{"x", rounded(line.x, 6)}, {"y", rounded(y)}};
}

}  // namespace

Json states_json(const std::vector<State>& states) {
  Json out = Json::array();
  for (const State& state : states)
    out.push_back({{"id", state.id()},
                   {"polarizer", axis_name(state.polarizer_deg)},
                   {"analyzer", axis_name(state.analyzer_deg)}});
  return out;
}

Json brdf_curves(const SampleView& view) {
  using Key = std::tuple<std::size_t, std::size_t, std::size_t>;  // incidence, state, wavelength
  std::map<Key, Series> measured;
  std::vector<State> states = view.states;
  double lowest = INFINITY, highest = 0;
  if (view.table) {
    const auto& points = view.table->points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Place& place = view.point_place[i];
      if (!place.in_plane) continue;
      Series& series = measured[{place.theta_i, place.state, place.wavelength}];
      const double x = signed_theta_r(points.theta_r_deg[i], points.phi_r_deg[i]);
      if (points.used[i] == 0) {
        series.flagged_x.push_back(x);
        series.flagged_y.push_back(points.brdf_per_sr[i]);
        continue;
      }
      series.x.push_back(x);
      series.y.push_back(points.brdf_per_sr[i]);
      series.u.push_back(view.total_u[i]);
      if (points.brdf_per_sr[i] > 0) {
        lowest = std::min(lowest, points.brdf_per_sr[i]);
        highest = std::max(highest, points.brdf_per_sr[i]);
      }
    }
  } else if (view.model) {
    // A model by itself: unpolarised light at the incidences of its reflectances.
    states = {{formats::open_axis, formats::open_axis}};
    for (std::size_t t = 0; t < view.theta_i_deg.size(); ++t)
      for (std::size_t w = 0; w < view.wavelengths_nm.size(); ++w) measured[{t, 0, w}];
  }
  if (measured.empty()) return nullptr;

  ModelLines lines(view);
  std::vector<std::size_t> incidences, used_states;
  Json curves = Json::array();
  for (auto& [key, series] : measured) {
    const auto& [theta_i, state, wavelength] = key;
    const State& axes = states[state];
    Json curve = curve_json(std::move(series));
    curve["wavelength_nm"] = view.wavelengths_nm[wavelength];
    curve["theta_i_deg"] = view.theta_i_deg[theta_i];
    curve["state"] = axes.id();
    if (const auto* line = lines.at(wavelength, theta_i)) {
      curve["model"] = line_json(*line, [&](const MuellerRows& m) {
        return contracted(m, axes.polarizer_deg, axes.analyzer_deg);
      });
    }
    curves.push_back(std::move(curve));
    if (std::find(incidences.begin(), incidences.end(), theta_i) == incidences.end())
      incidences.push_back(theta_i);
    if (std::find(used_states.begin(), used_states.end(), state) == used_states.end())
      used_states.push_back(state);
  }
  std::sort(used_states.begin(), used_states.end());
  std::vector<State> shown;
  for (const std::size_t s : used_states) shown.push_back(states[s]);
  Json theta = Json::array();
  for (const std::size_t t : incidences) theta.push_back(view.theta_i_deg[t]);
  // Two factors of two do not need a logarithm; without measurements assume a lobe.
  const bool log = !view.table || highest / lowest > 4;
  return {{"log", log},
          {"theta_i_deg", theta},
          {"states", states_json(shown)},
          {"curves", std::move(curves)}};
}

Json dolp_curves(const SampleView& view) {
  if (!view.table || view.table->dolp.dolp.empty()) return nullptr;
  const auto& dolp = view.table->dolp;
  std::map<std::pair<std::size_t, std::size_t>, Series> measured;
  for (std::size_t i = 0; i < dolp.dolp.size(); ++i) {
    if (!view.dolp_place[i].in_plane) continue;
    Series& series = measured[{view.dolp_place[i].theta_i, view.dolp_place[i].wavelength}];
    series.x.push_back(signed_theta_r(dolp.theta_r_deg[i], dolp.phi_r_deg[i]));
    series.y.push_back(dolp.dolp[i]);
    series.u.push_back(dolp.dolp_u[i]);
  }
  if (measured.empty()) return nullptr;
  ModelLines lines(view);
  Json curves = Json::array(), theta = Json::array();
  for (auto& [key, series] : measured) {
    Json curve = curve_json(std::move(series));
    curve["wavelength_nm"] = view.wavelengths_nm[key.second];
    curve["theta_i_deg"] = view.theta_i_deg[key.first];
    if (const auto* line = lines.at(key.second, key.first))
      curve["model"] = line_json(*line, dolp_p4);
    curves.push_back(std::move(curve));
    const Json incidence = view.theta_i_deg[key.first];
    if (std::find(theta.begin(), theta.end(), incidence) == theta.end()) theta.push_back(incidence);
  }
  return {{"theta_i_deg", theta}, {"curves", std::move(curves)}};
}

Json directions(const SampleView& view) {
  if (!view.table) return Json::array();
  const auto& points = view.table->points;
  std::map<std::pair<std::size_t, std::size_t>, std::vector<std::pair<double, double>>> seen;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.used[i] == 0) continue;
    const double rho = std::sin(optics::radians(points.theta_r_deg[i]));
    const double phi = optics::radians(points.phi_r_deg[i]);
    const auto two_places = [](double x) { return std::round(x * 500) / 500; };
    seen[{view.point_place[i].theta_i, view.point_place[i].wavelength}].emplace_back(
        two_places(rho * std::cos(phi)), two_places(rho * std::sin(phi)));
  }
  Json out = Json::array();
  for (auto& [key, list] : seen) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    Json u = Json::array(), v = Json::array();
    for (const auto& [x, y] : list) u.push_back(x), v.push_back(y);
    out.push_back({{"theta_i_deg", view.theta_i_deg[key.first]},
                   {"wavelength_nm", view.wavelengths_nm[key.second]},
                   {"u", std::move(u)},
                   {"v", std::move(v)}});
  }
  return out;
}

}  // namespace umov::report
