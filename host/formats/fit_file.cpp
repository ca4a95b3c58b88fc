#include "host/formats/fit_file.hpp"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"

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

/// Reading with a place in every complaint.
class Reader {
 public:
  Reader(const Json& root, std::string file) : root_(root), file_(std::move(file)) {
    if (!root_.is_object()) fail("", "is not a JSON object");
  }

  [[noreturn]] void fail(const std::string& member, const std::string& what) const {
    throw Error({file_, 0, member}, member.empty() ? what : "\"" + member + "\" " + what,
                "write the file again with umov invert");
  }

  const Json& need(const Json& object, const std::string& name) const {
    const auto found = object.find(name);
    if (found == object.end()) fail(name, "is missing");
    return *found;
  }

  double real(const Json& value, const std::string& name) const {
    if (value.is_null()) return std::numeric_limits<double>::quiet_NaN();
    if (!value.is_number()) fail(name, "is not a number");
    return value.get<double>();
  }

  double real_or(const Json& object, const std::string& name, double other) const {
    const auto found = object.find(name);
    return found == object.end() ? other : real(*found, name);
  }

  std::size_t count_or(const Json& object, const std::string& name, std::size_t other) const {
    const auto found = object.find(name);
    if (found == object.end()) return other;
    if (!found->is_number_unsigned()) fail(name, "is not a count");
    return found->get<std::size_t>();
  }

  std::string text(const Json& value, const std::string& name) const {
    if (!value.is_string()) fail(name, "is not text");
    return value.get<std::string>();
  }

  std::string text_or(const Json& object, const std::string& name) const {
    const auto found = object.find(name);
    return found == object.end() ? std::string() : text(*found, name);
  }

  bool truth_or(const Json& object, const std::string& name, bool other) const {
    const auto found = object.find(name);
    if (found == object.end()) return other;
    if (!found->is_boolean()) fail(name, "is neither true nor false");
    return found->get<bool>();
  }

  std::vector<std::string> texts_or(const Json& object, const std::string& name) const {
    std::vector<std::string> out;
    const auto found = object.find(name);
    if (found == object.end()) return out;
    for (const Json& item : array(*found, name)) out.push_back(text(item, name));
    return out;
  }

  const Json& array(const Json& value, const std::string& name) const {
    if (!value.is_array()) fail(name, "is not a list");
    return value;
  }

  Estimate estimate(const Json& value, const std::string& name) const {
    if (!value.is_object()) fail(name, "is not an object with value, lo and hi");
    Estimate out;
    out.value = real(need(value, "value"), name + ".value");
    out.lo = real(need(value, "lo"), name + ".lo");
    out.hi = real(need(value, "hi"), name + ".hi");
    out.standard_error = real_or(value, "standard_error", (out.hi - out.lo) / (2 * 1.959964));
    if (std::isnan(out.standard_error)) out.standard_error = 0;
    out.at_bound = text_or(value, "at_bound");
    out.identifiable = truth_or(value, "identifiable", true);
    return out;
  }

  std::vector<FitParameter> parameters(const std::string& member, std::size_t wavelengths,
                                       bool required) const {
    std::vector<FitParameter> out;
    const auto found = root_.find(member);
    if (found == root_.end()) {
      if (required) fail(member, "is missing");
      return out;
    }
    if (!found->is_object()) fail(member, "is not an object");
    for (const auto& [name, value] : found->items()) {
      FitParameter parameter;
      parameter.name = name;
      parameter.shared = !value.is_array();
      if (parameter.shared) {
        parameter.estimates.push_back(estimate(value, name));
      } else {
        for (const Json& item : value) parameter.estimates.push_back(estimate(item, name));
        if (parameter.estimates.size() != wavelengths) {
          fail(name, "has " + std::to_string(parameter.estimates.size()) + " values for " +
                         std::to_string(wavelengths) + " wavelengths");
        }
      }
      const Json& head = parameter.shared ? value : value.front();
      parameter.unit = text_or(head, "unit");
      parameter.fixed = truth_or(head, "fixed", false);
      out.push_back(std::move(parameter));
    }
    return out;
  }

 private:
  const Json& root_;
  std::string file_;
};

std::optional<double> optional_real(const Json& value) {
  if (!value.is_number()) return std::nullopt;
  return value.get<double>();
}

}  // namespace

std::vector<double> FitResult::values_at(std::size_t index) const {
  std::vector<double> out;
  out.reserve(parameters.size());
  for (const FitParameter& parameter : parameters) out.push_back(parameter.at(index).value);
  return out;
}

std::optional<std::size_t> FitResult::wavelength_index(double wavelength_nm) const {
  for (std::size_t i = 0; i < wavelengths_nm.size(); ++i) {
    if (std::abs(wavelengths_nm[i] - wavelength_nm) < 0.01) return i;
  }
  return std::nullopt;
}

const FitParameter* FitResult::find(const std::string& name) const {
  for (const auto* list : {&parameters, &derived}) {
    for (const FitParameter& parameter : *list) {
      if (parameter.name == name) return &parameter;
    }
  }
  return nullptr;
}

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

FitResult fit_from_json(const std::string& text, const std::string& file) {
  Json root;
  try {
    root = Json::parse(text);
  } catch (const Json::parse_error& error) {
    std::size_t line = 1;
    for (std::size_t i = 0; i < text.size() && i < error.byte; ++i) line += text[i] == '\n';
    throw Error({file, line}, "is not valid JSON", "write the file again with umov invert");
  }
  const Reader reader(root, file);
  FitResult fit;
  fit.model = reader.text(reader.need(root, "model"), "model");
  for (const Json& nm : reader.array(reader.need(root, "wavelengths_nm"), "wavelengths_nm")) {
    fit.wavelengths_nm.push_back(reader.real(nm, "wavelengths_nm"));
  }
  if (fit.wavelengths_nm.empty()) reader.fail("wavelengths_nm", "is empty");
  fit.parameters = reader.parameters("parameters", fit.wavelengths_nm.size(), true);
  fit.derived = reader.parameters("derived", fit.wavelengths_nm.size(), false);
  fit.at_bound = reader.texts_or(root, "at_bound");
  if (const auto pairs = root.find("correlations"); pairs != root.end()) {
    for (const Json& item : reader.array(*pairs, "correlations")) {
      if (!item.is_array() || item.size() != 3) {
        reader.fail("correlations", "needs entries of two names and a number");
      }
      FitResult::Correlation pair;
      pair.first = reader.text(item[0], "correlations");
      pair.second = reader.text(item[1], "correlations");
      pair.coefficient = reader.real(item[2], "correlations");
      fit.correlations.push_back(std::move(pair));
    }
  }
  const char* const where = "correlations_wavelength_nm";
  if (const auto list = root.find(where); list != root.end()) {
    if (reader.array(*list, where).size() != fit.correlations.size()) {
      reader.fail(where, "has not one entry for each of \"correlations\"");
    }
    for (std::size_t k = 0; k < fit.correlations.size(); ++k) {
      const Json& item = (*list)[k];
      if (!item.is_array() || item.size() != 2) {
        reader.fail(where, "needs entries of two wavelengths or null");
      }
      fit.correlations[k].first_wavelength_nm = optional_real(item[0]);
      fit.correlations[k].second_wavelength_nm = optional_real(item[1]);
    }
  }
  fit.identifiability = reader.texts_or(root, "identifiability");
  fit.notes = reader.texts_or(root, "notes");
  fit.priors = reader.texts_or(root, "priors");
  if (const auto list = root.find("remedies"); list != root.end()) {
    for (const Json& item : reader.array(*list, "remedies")) {
      if (!item.is_object()) reader.fail("remedies", "needs objects");
      FitResult::Remedy remedy;
      remedy.parameters = reader.texts_or(item, "parameters");
      remedy.data = reader.text_or(item, "data");
      remedy.points = reader.count_or(item, "points", 0);
      remedy.sigma_ratio = reader.real_or(item, "sigma_ratio", 1);
      if (const auto now = item.find("correlation_now"); now != item.end()) {
        remedy.correlation_now = optional_real(*now);
      }
      if (const auto then = item.find("correlation_then"); then != item.end()) {
        remedy.correlation_then = optional_real(*then);
      }
      fit.remedies.push_back(std::move(remedy));
    }
  }
  if (const auto list = root.find("dhr"); list != root.end()) {
    for (const Json& item : reader.array(*list, "dhr")) {
      if (!item.is_object()) reader.fail("dhr", "needs objects");
      fit.dhr.push_back({reader.real(reader.need(item, "wavelength_nm"), "dhr.wavelength_nm"),
                         reader.real(reader.need(item, "theta_i_deg"), "dhr.theta_i_deg"),
                         reader.real(reader.need(item, "value"), "dhr.value"),
                         reader.real(reader.need(item, "lo"), "dhr.lo"),
                         reader.real(reader.need(item, "hi"), "dhr.hi"),
                         reader.real_or(item, "mirror", 0)});
    }
  }
  if (const auto list = root.find("factors"); list != root.end()) {
    for (const Json& item : reader.array(*list, "factors")) {
      if (!item.is_object()) reader.fail("factors", "needs objects");
      fit.factors.push_back({reader.text(reader.need(item, "name"), "factors.name"),
                             reader.real(reader.need(item, "value"), "factors.value"),
                             reader.real_or(item, "standard_error", 1)});
    }
  }
  if (const auto block = root.find("covariance"); block != root.end()) {
    fit.covariance.names = reader.texts_or(*block, "names");
    for (const Json& line : reader.array(reader.need(*block, "matrix"), "covariance.matrix")) {
      for (const Json& value : reader.array(line, "covariance.matrix")) {
        fit.covariance.values.push_back(reader.real(value, "covariance.matrix"));
      }
    }
    const std::size_t size = fit.covariance.names.size();
    if (fit.covariance.values.size() != size * size) {
      reader.fail("covariance", "is not square in its names");
    }
    if (const auto list = block->find("coordinates"); list != block->end()) {
      for (const Json& item : reader.array(*list, "covariance.coordinates")) {
        if (!item.is_object()) reader.fail("covariance.coordinates", "needs objects");
        fit.covariance.coordinates.push_back(
            {reader.text_or(item, "scale"), reader.real_or(item, "at", 0),
             reader.real_or(item, "lo", 0), reader.real_or(item, "hi", 0),
             reader.real_or(item, "centre", 0)});
      }
      const std::size_t count = fit.covariance.coordinates.size();
      if (count != 0 && count != size) {
        reader.fail("covariance.coordinates", "has not one entry a name");
      }
    }
    if (const auto list = block->find("orders"); list != block->end()) {
      for (const Json& item : reader.array(*list, "covariance.orders")) {
        if (!item.is_object()) reader.fail("covariance.orders", "needs objects");
        FitResult::Covariance::Order order;
        order.value = reader.real_or(item, "value", 0);
        for (const Json& slope : reader.array(reader.need(item, "slope"), "covariance.orders")) {
          order.slope.push_back(reader.real(slope, "covariance.orders"));
        }
        if (order.slope.size() != size)
          reader.fail("covariance.orders", "has not one slope a name");
        fit.covariance.orders.push_back(std::move(order));
      }
    }
  }
  if (root.contains("objective_kind")) fit.objective_kind = reader.text_or(root, "objective_kind");
  fit.objective = reader.real_or(root, "objective", 0);
  fit.chi2 = reader.real_or(root, "chi2", 0);
  fit.dof = reader.count_or(root, "dof", 0);
  fit.interval_scale = reader.real_or(root, "interval_scale", 1);
  fit.robust_scale_sigma = reader.real_or(root, "robust_scale_sigma", 0);
  fit.floor_relative = reader.real_or(root, "floor_relative", 0);
  fit.points = reader.count_or(root, "points", 0);
  fit.outliers = reader.count_or(root, "outliers", 0);
  if (const auto g2 = root.find("g2_held_out"); g2 != root.end()) {
    fit.g2_held_out = optional_real(*g2);
  }
  fit.iterations = reader.count_or(root, "iterations", 0);
  fit.starts = reader.count_or(root, "starts", 0);
  fit.starts_agreeing = reader.count_or(root, "starts_agreeing", 0);
  fit.converged = reader.truth_or(root, "converged", false);
  fit.seed = reader.count_or(root, "seed", 1);
  fit.seconds = reader.real_or(root, "seconds", 0);
  if (const auto phases = root.find("phase_seconds"); phases != root.end()) {
    if (!phases->is_object()) reader.fail("phase_seconds", "is not an object");
    for (const auto& [phase, value] : phases->items()) {
      fit.phase_seconds.emplace_back(phase, reader.real(value, "phase_seconds"));
    }
  }
  fit.data_file = reader.text_or(root, "data_file");
  fit.data_sha256 = reader.text_or(root, "data_sha256");
  fit.program = reader.text_or(root, "program");
  fit.command = reader.text_or(root, "command");
  return fit;
}

void write_fit(const std::string& path, const FitResult& fit) {
  replace_file(path, fit_to_json(fit));
}

FitResult read_fit(const std::string& path) {
  return fit_from_json(read_whole_file(path), path);
}

}  // namespace umov::formats
