#include <cmath>
#include <nlohmann/json.hpp>

#include "host/formats/fit_file.hpp"

namespace umov::formats {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json estimate_json(const Estimate& estimate, const FitParameter& parameter) {
  Json out;
  out["value"] = number(estimate.value);
  out["lo"] = number(estimate.lo);
  out["hi"] = number(estimate.hi);
  if (parameter.shared) out["shared"] = true;
  out["unit"] = parameter.unit;
  // An optimum on a limit has no linearised error.
  out["standard_error"] =
      estimate.at_bound.empty() ? number(estimate.standard_error) : Json(nullptr);
  if (parameter.fixed) out["fixed"] = true;
  if (!estimate.at_bound.empty()) out["at_bound"] = estimate.at_bound;
  out["identifiable"] = estimate.identifiable;
  return out;
}

Json parameters_json(const std::vector<FitParameter>& parameters) {
  Json out = Json::object();
  for (const FitParameter& parameter : parameters) {
    if (parameter.shared) {
      out[parameter.name] = estimate_json(parameter.estimates.at(0), parameter);
    } else {
      Json list = Json::array();
      for (const Estimate& e : parameter.estimates) list.push_back(estimate_json(e, parameter));
      out[parameter.name] = std::move(list);
    }
  }
  return out;
}

}  // namespace

std::string fit_to_json(const FitResult& fit) {
  Json out;
  out["model"] = fit.model;
  out["wavelengths_nm"] = fit.wavelengths_nm;
  out["parameters"] = parameters_json(fit.parameters);
  out["derived"] = parameters_json(fit.derived);
  out["at_bound"] = fit.at_bound;
  out["correlations"] = Json::array();
  out["correlations_wavelength_nm"] = Json::array();
  for (const auto& pair : fit.correlations) {
    out["correlations"].push_back(Json::array({pair.first, pair.second, number(pair.coefficient)}));
    // Entry by entry the wavelengths; null stands for a shared parameter.
    Json where = Json::array();
    for (const auto& nm : {pair.first_wavelength_nm, pair.second_wavelength_nm}) {
      where.push_back(nm ? Json(*nm) : Json(nullptr));
    }
    out["correlations_wavelength_nm"].push_back(std::move(where));
  }
  out["identifiability"] = fit.identifiability;
  out["notes"] = fit.notes;
  out["priors"] = fit.priors;
  out["remedies"] = Json::array();
  for (const auto& remedy : fit.remedies) {
    const auto optional = [](const std::optional<double>& value) {
      return value ? number(*value) : Json(nullptr);
    };
    out["remedies"].push_back({{"parameters", remedy.parameters},
                               {"data", remedy.data},
                               {"points", remedy.points},
                               {"sigma_ratio", number(remedy.sigma_ratio)},
                               {"correlation_now", optional(remedy.correlation_now)},
                               {"correlation_then", optional(remedy.correlation_then)}});
  }
  out["dhr"] = Json::array();
  for (const auto& dhr : fit.dhr) {
    out["dhr"].push_back({{"wavelength_nm", dhr.wavelength_nm},
                          {"theta_i_deg", dhr.theta_i_deg},
                          {"value", number(dhr.value)},
                          {"mirror", number(dhr.mirror)},
                          {"lo", number(dhr.lo)},
                          {"hi", number(dhr.hi)}});
  }
  out["factors"] = Json::array();
  for (const auto& factor : fit.factors) {
    out["factors"].push_back({{"name", factor.name},
                              {"value", number(factor.value)},
                              {"standard_error", number(factor.standard_error)}});
  }
  Json rows = Json::array();
  const std::size_t size = fit.covariance.names.size();
  for (std::size_t row = 0; row < size; ++row) {
    Json line = Json::array();
    for (std::size_t col = 0; col < size; ++col) {
      line.push_back(number(fit.covariance.values[row * size + col]));
    }
    rows.push_back(std::move(line));
  }
  out["covariance"] = {{"names", fit.covariance.names}, {"matrix", std::move(rows)}};
  Json coordinates = Json::array();
  for (const auto& k : fit.covariance.coordinates) {
    coordinates.push_back({{"scale", k.scale},
                           {"at", number(k.at)},
                           {"lo", number(k.lo)},
                           {"hi", number(k.hi)},
                           {"centre", number(k.centre)}});
  }
  out["covariance"]["coordinates"] = std::move(coordinates);
  Json orders = Json::array();
  for (const auto& order : fit.covariance.orders) {
    orders.push_back({{"value", number(order.value)}, {"slope", order.slope}});
  }
  out["covariance"]["orders"] = std::move(orders);
  out["objective_kind"] = fit.objective_kind;
  out["objective"] = number(fit.objective);
  out["chi2"] = number(fit.chi2);
  out["dof"] = fit.dof;
  out["interval_scale"] = number(fit.interval_scale);
  out["robust_scale_sigma"] = fit.robust_scale_sigma;
  out["floor_relative"] = fit.floor_relative;
  out["points"] = fit.points;
  out["outliers"] = fit.outliers;
  out["g2_held_out"] = fit.g2_held_out ? number(*fit.g2_held_out) : Json(nullptr);
  out["iterations"] = fit.iterations;
  out["starts"] = fit.starts;
  out["starts_agreeing"] = fit.starts_agreeing;
  out["converged"] = fit.converged;
  out["seed"] = fit.seed;
  out["seconds"] = fit.seconds;
  out["phase_seconds"] = Json::object();
  for (const auto& [phase, seconds] : fit.phase_seconds) out["phase_seconds"][phase] = seconds;
  out["data_file"] = fit.data_file;
  out["data_sha256"] = fit.data_sha256;
  out["program"] = fit.program;
  out["command"] = fit.command;
  return out.dump(1) + "\n";
}

}  // namespace umov::formats
