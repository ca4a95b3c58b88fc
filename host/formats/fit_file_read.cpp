#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "host/errors/error.hpp"
#include "host/formats/fit_file.hpp"

namespace umov::formats {
namespace {

using Json = nlohmann::ordered_json;

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

void read_correlations(const Json& root, const Reader& reader, FitResult& fit) {
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
}

void read_remedies(const Json& root, const Reader& reader, FitResult& fit) {
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
}

void read_dhr(const Json& root, const Reader& reader, FitResult& fit) {
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
}

void read_factors(const Json& root, const Reader& reader, FitResult& fit) {
  if (const auto list = root.find("factors"); list != root.end()) {
    for (const Json& item : reader.array(*list, "factors")) {
      if (!item.is_object()) reader.fail("factors", "needs objects");
      fit.factors.push_back({reader.text(reader.need(item, "name"), "factors.name"),
                             reader.real(reader.need(item, "value"), "factors.value"),
                             reader.real_or(item, "standard_error", 1)});
    }
  }
}

FitResult::Covariance covariance(const Json& block, const Reader& reader) {
  FitResult::Covariance out;
  out.names = reader.texts_or(block, "names");
  for (const Json& line : reader.array(reader.need(block, "matrix"), "covariance.matrix")) {
    for (const Json& value : reader.array(line, "covariance.matrix")) {
      out.values.push_back(reader.real(value, "covariance.matrix"));
    }
  }
  const std::size_t size = out.names.size();
  if (out.values.size() != size * size) {
    reader.fail("covariance", "is not square in its names");
  }
  if (const auto list = block.find("coordinates"); list != block.end()) {
    for (const Json& item : reader.array(*list, "covariance.coordinates")) {
      if (!item.is_object()) reader.fail("covariance.coordinates", "needs objects");
      out.coordinates.push_back({reader.text_or(item, "scale"), reader.real_or(item, "at", 0),
                                 reader.real_or(item, "lo", 0), reader.real_or(item, "hi", 0),
                                 reader.real_or(item, "centre", 0)});
    }
    const std::size_t count = out.coordinates.size();
    if (count != 0 && count != size) {
      reader.fail("covariance.coordinates", "has not one entry a name");
    }
  }
  if (const auto list = block.find("orders"); list != block.end()) {
    for (const Json& item : reader.array(*list, "covariance.orders")) {
      if (!item.is_object()) reader.fail("covariance.orders", "needs objects");
      FitResult::Covariance::Order order;
      order.value = reader.real_or(item, "value", 0);
      for (const Json& slope : reader.array(reader.need(item, "slope"), "covariance.orders")) {
        order.slope.push_back(reader.real(slope, "covariance.orders"));
      }
      if (order.slope.size() != size) reader.fail("covariance.orders", "has not one slope a name");
      out.orders.push_back(std::move(order));
    }
  }
  return out;
}

}  // namespace

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
  read_correlations(root, reader, fit);
  fit.identifiability = reader.texts_or(root, "identifiability");
  fit.notes = reader.texts_or(root, "notes");
  fit.priors = reader.texts_or(root, "priors");
  read_remedies(root, reader, fit);
  read_dhr(root, reader, fit);
  read_factors(root, reader, fit);
  if (const auto block = root.find("covariance"); block != root.end())
    fit.covariance = covariance(*block, reader);
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

}  // namespace umov::formats
