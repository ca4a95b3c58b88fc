#include "host/invert/row_selection.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "host/errors/error.hpp"
#include "host/formats/order_statistics.hpp"
#include "host/formats/scan_table.hpp"
#include "host/invert/prediction.hpp"
#include "host/optics/angles.hpp"

namespace umov::invert {
namespace {

constexpr double in_plane_within_deg = 0.5;
constexpr double same_value_within = 0.01;

[[noreturn]] void refuse(const std::string& text) {
  throw Error("'" + text + "' does not select rows",
              "write in-plane, theta_i_deg=30,45, theta_r_deg=-60:60 or theta_i_deg!=60; columns "
              "are theta_i_deg, "
              "theta_r_deg, phi_r_deg, wavelength_nm");
}

double number(std::string_view part, const std::string& text) {
  double value = 0;
  const auto [end, code] = std::from_chars(part.data(), part.data() + part.size(), value);
  if (code != std::errc{} || end != part.data() + part.size()) refuse(text);
  return value;
}

double column_value(const formats::BrdfTable::Points& points, std::size_t i,
                    RowCondition::Column column) {
  switch (column) {
    case RowCondition::Column::theta_i:
      return points.theta_i_deg[i];
    case RowCondition::Column::theta_r:
      return points.theta_r_deg[i];
    case RowCondition::Column::phi_r:
      return points.phi_r_deg[i];
    case RowCondition::Column::wavelength:
      return points.wavelength_nm[i];
    case RowCondition::Column::in_plane:
      break;
  }
  return 0;
}

bool in_plane(const formats::BrdfTable::Points& points, std::size_t i) {
  const double out = std::sin(optics::radians(points.theta_r_deg[i])) *
                     std::sin(optics::radians(points.phi_r_deg[i]));
  return std::abs(out) <= std::sin(optics::radians(in_plane_within_deg));
}

bool holds(const RowCondition& condition, const formats::BrdfTable::Points& points, std::size_t i) {
  bool inside = false;
  if (condition.column == RowCondition::Column::in_plane) {
    inside = in_plane(points, i);
  } else {
    const double value = column_value(points, i, condition.column);
    inside = condition.range ? value >= condition.values[0] && value <= condition.values[1]
                             : std::any_of(condition.values.begin(), condition.values.end(),
                                           [&](double wanted) {
                                             return std::abs(value - wanted) <= same_value_within;
                                           });
  }
  return inside != condition.negated;
}

}  // namespace

RowCondition parse_row_condition(const std::string& text) {
  RowCondition condition;
  if (text == "in-plane") return condition;
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0) refuse(text);
  condition.negated = text[equals - 1] == '!';
  const std::string name = text.substr(0, equals - (condition.negated ? 1 : 0));
  using Column = RowCondition::Column;
  if (name == "theta_i_deg")
    condition.column = Column::theta_i;
  else if (name == "theta_r_deg")
    condition.column = Column::theta_r;
  else if (name == "phi_r_deg")
    condition.column = Column::phi_r;
  else if (name == "wavelength_nm")
    condition.column = Column::wavelength;
  else
    refuse(text);
  std::string_view rest = std::string_view(text).substr(equals + 1);
  if (const auto colon = rest.find(':'); colon != std::string_view::npos) {
    condition.range = true;
    condition.values = {number(rest.substr(0, colon), text), number(rest.substr(colon + 1), text)};
    return condition;
  }
  for (;;) {
    const auto comma = rest.find(',');
    condition.values.push_back(number(rest.substr(0, comma), text));
    if (comma == std::string_view::npos) return condition;
    rest.remove_prefix(comma + 1);
  }
}

formats::BrdfTable select_rows(const formats::BrdfTable& table,
                               const std::vector<RowCondition>& conditions) {
  formats::BrdfTable selected = table;
  std::size_t left = 0;
  for (std::size_t i = 0; i < table.points.size(); ++i) {
    const bool keep = std::all_of(conditions.begin(), conditions.end(),
                                  [&](const RowCondition& c) { return holds(c, table.points, i); });
    if (!keep) selected.points.used[i] = 0;
    left += selected.points.used[i] != 0 ? 1 : 0;
  }
  if (left == 0) throw Error("no usable point is left after --rows", "select other rows");
  return selected;
}

std::vector<PredictionError> prediction_errors(const formats::FitResult& fit,
                                               const formats::BrdfTable& table,
                                               const formats::BrdfTable& selected) {
  const Prediction prediction = predict(fit, selected);
  const auto& points = table.points;
  const auto unpolarised = [&](std::size_t i) {
    return formats::is_open(points.polarizer_deg[i]) && formats::is_open(points.analyzer_deg[i]);
  };
  bool any_unpolarised = false;
  for (std::size_t i = 0; i < points.size(); ++i)
    any_unpolarised = any_unpolarised || (points.used[i] != 0 && unpolarised(i));

  std::vector<PredictionError> errors;
  for (const double wavelength_nm : fit.wavelengths_nm) {
    for (const bool fitted : {true, false}) {
      std::vector<double> sizes;
      PredictionError error{.set = fitted ? "fitted" : "withheld", .wavelength_nm = wavelength_nm};
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (points.used[i] == 0 ||
            std::abs(points.wavelength_nm[i] - wavelength_nm) > same_value_within)
          continue;
        if ((selected.points.used[i] != 0) != fitted || (any_unpolarised && !unpolarised(i)))
          continue;
        if (!(points.brdf_per_sr[i] > 0)) continue;
        const double relative = prediction.calibrated_per_sr[i] / points.brdf_per_sr[i] - 1;
        sizes.push_back(std::abs(relative));
        error.mean += relative;
      }
      if (sizes.empty()) continue;
      error.points = sizes.size();
      error.mean /= static_cast<double>(sizes.size());
      error.median_abs = formats::median(sizes);
      error.p90_abs = formats::quantile(sizes, 0.9);
      errors.push_back(error);
    }
  }
  return errors;
}

}  // namespace umov::invert
