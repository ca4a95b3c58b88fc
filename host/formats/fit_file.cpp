#include "host/formats/fit_file.hpp"

#include <cmath>

#include "host/formats/atomic_file.hpp"

namespace umov::formats {

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

void write_fit(const std::string& path, const FitResult& fit) {
  replace_file(path, fit_to_json(fit));
}

FitResult read_fit(const std::string& path) {
  return fit_from_json(read_whole_file(path), path);
}

}  // namespace umov::formats
