#include "host/cli/model_values.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <utility>

#include "host/errors/error.hpp"
#include "host/formats/table_file.hpp"
#include "host/optics/angles.hpp"

namespace umov::cli {
namespace {

double number(const std::string& setting, const std::string& text) {
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    throw Error("'" + text + "' in --set " + setting + " is not a number",
                "write for example --set n=1.5");
  }
  return value;
}

const brdf::TableSlot* slot_named(const std::vector<brdf::TableSlot>& slots,
                                  const std::string& name) {
  for (const brdf::TableSlot& slot : slots) {
    if (slot.name == name) return &slot;
  }
  return nullptr;
}

}  // namespace

ModelValues model_values(const std::string& name, const std::vector<std::string>& settings) {
  // Choices are made first, since they decide which parameters there are.
  brdf::Model model = brdf::Model::by_name(name);
  std::vector<std::pair<std::string, std::string>> numbers;
  for (const std::string& setting : settings) {
    const auto equals = setting.find('=');
    if (equals == std::string::npos) {
      throw Error("--set " + setting + " has no value", "write --set NAME=VALUE");
    }
    const std::string key = setting.substr(0, equals);
    const std::string value = setting.substr(equals + 1);
    const std::vector<brdf::TableSlot> slots = model.table_slots();
    if (model.has_choice(key)) {
      model = model.with_choice(key, value);
    } else if (const brdf::TableSlot* slot = slot_named(slots, key)) {
      model = model.with_table(formats::read_table(value), slot->part);
    } else {
      numbers.emplace_back(key, value);
    }
  }
  std::vector<double> values = model.initial_values();
  for (const auto& [key, value] : numbers) {
    values[model.index_of(key)] = number(key + "=" + value, value);
  }
  model.check(values);
  return {std::move(model), std::move(values)};
}

double checked_wavelength_um(double wavelength_nm) {
  if (wavelength_nm >= 100.0 && wavelength_nm <= 1e5) return wavelength_nm * 1e-3;
  throw Error(fmt::format("a wavelength of {:g} nm is out of range", wavelength_nm),
              "give --wavelength-nm from 100 to 100000");
}

double checked_incidence(double theta_i_deg) {
  if (theta_i_deg >= 0.0 && theta_i_deg < 90.0) return optics::radians(theta_i_deg);
  throw Error(fmt::format("an incidence of {:g} degrees is out of range", theta_i_deg),
              "give --theta-i from 0 up to, not including, 90");
}

}  // namespace umov::cli
