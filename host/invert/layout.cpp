#include "host/invert/layout.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/errors/error.hpp"

namespace umov::invert {
namespace {

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::string names_of(const brdf::Model& model) {
  std::string out;
  for (const auto& parameter : model.parameters()) {
    out += (out.empty() ? "" : ", ") + parameter.name;
  }
  return out;
}

std::size_t index_of(const brdf::Model& model, const std::string& name) {
  const auto& list = model.parameters();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].name == name) return i;
  }
  throw Error("model " + model.name() + " has no parameter \"" + name + "\"",
              "its parameters are " + names_of(model));
}

}  // namespace

std::string wavelength_text(double wavelength_nm) {
  return number_text(wavelength_nm);
}

Layout::Layout(const brdf::Model& model, std::vector<double> wavelengths_nm, const Options& options)
    : model_(&model), wavelengths_nm_(std::move(wavelengths_nm)) {
  const auto& list = model.parameters();
  const std::size_t wavelengths = wavelengths_nm_.size();

  for (const auto& parameter : list) shared_.push_back(!parameter.spectral);
  for (const std::string& name : options.share) shared_[index_of(model, name)] = true;
  for (const std::string& name : options.spectral) {
    if (std::find(options.share.begin(), options.share.end(), name) != options.share.end()) {
      throw Error("parameter \"" + name + "\" is asked for both shared and spectral",
                  "leave one of the two out");
    }
    shared_[index_of(model, name)] = false;
  }

  for (const std::string& name : options.free) index_of(model, name);

  const auto wavelengths_of = [&](const std::string& name, const std::optional<double>& nm) {
    std::vector<std::size_t> out;
    for (std::size_t w = 0; w < wavelengths; ++w) {
      if (!nm || std::abs(wavelengths_nm_[w] - *nm) < 0.01) out.push_back(w);
    }
    if (out.empty()) {
      throw Error("a setting of \"" + name + "\" names " + number_text(*nm) +
                      " nm, which the data do not have",
                  "take a wavelength of the data");
    }
    if (nm && wavelengths > 1 && shared_[index_of(model, name)]) {
      throw Error("\"" + name + "\" is shared by all wavelengths, so it cannot be set at one",
                  "add --spectral " + name + " or leave out the wavelength");
    }
    return out;
  };

  struct Cell {
    double lo = 0, hi = 0, start = 0;
    bool fixed = false, user_start = false;
  };
  std::vector<std::vector<Cell>> cells(wavelengths);
  for (std::size_t w = 0; w < wavelengths; ++w) {
    for (const auto& p : list) {
      const bool freed =
          std::find(options.free.begin(), options.free.end(), p.name) != options.free.end();
      cells[w].push_back({p.min, p.max, p.initial, p.held && !freed});
    }
  }
  for (const Limits& limits : options.bound) {
    const std::size_t i = index_of(model, limits.name);
    if (!(limits.lo < limits.hi) || limits.lo < list[i].min || limits.hi > list[i].max) {
      throw Error("bounds " + number_text(limits.lo) + ":" + number_text(limits.hi) + " of \"" +
                      limits.name + "\" are not an interval within " + number_text(list[i].min) +
                      ":" + number_text(list[i].max),
                  "give the lower limit first, inside the model's own range");
    }
    for (const std::size_t w : wavelengths_of(limits.name, limits.wavelength_nm)) {
      cells[w][i].lo = limits.lo;
      cells[w][i].hi = limits.hi;
      cells[w][i].start = std::clamp(cells[w][i].start, limits.lo, limits.hi);
    }
  }
  const auto inside = [&](const Setting& setting, const Cell& cell) {
    if (setting.value >= cell.lo && setting.value <= cell.hi) return;
    throw Error("\"" + setting.name + "\" = " + number_text(setting.value) + " lies outside " +
                    number_text(cell.lo) + ":" + number_text(cell.hi),
                "choose a value inside the limits");
  };
  for (const Setting& setting : options.start) {
    const std::size_t i = index_of(model, setting.name);
    for (const std::size_t w : wavelengths_of(setting.name, setting.wavelength_nm)) {
      inside(setting, cells[w][i]);
      cells[w][i].start = setting.value;
      cells[w][i].user_start = true;
    }
  }
  for (const Setting& setting : options.fix) {
    const std::size_t i = index_of(model, setting.name);
    for (const std::size_t w : wavelengths_of(setting.name, setting.wavelength_nm)) {
      inside(setting, cells[w][i]);
      cells[w][i].start = setting.value;
      cells[w][i].fixed = true;
    }
  }

  slots_.assign(wavelengths, std::vector<std::optional<std::size_t>>(list.size()));
  fixed_.assign(wavelengths, std::vector<double>(list.size()));
  active_.resize(wavelengths);
  for (std::size_t i = 0; i < list.size(); ++i) {
    for (std::size_t w = 0; w < wavelengths; ++w) {
      const Cell& cell = cells[w][i];
      fixed_[w][i] = cell.start;
      if (cell.fixed) continue;
      if (!shared_[i] || w == 0) {
        slots_[w][i] = free_.size();
        FreeParameter parameter;
        parameter.parameter = i;
        if (!shared_[i]) parameter.wavelength = w;
        parameter.coordinate = {suitable_scale(list[i].name, cell.lo, cell.hi), cell.lo, cell.hi};
        parameter.start = cell.start;
        parameter.user_start = cell.user_start;
        free_.push_back(parameter);
      } else {
        slots_[w][i] = slots_[0][i];
      }
    }
  }
  for (std::size_t w = 0; w < wavelengths; ++w) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (slots_[w][i]) active_[w].push_back(static_cast<int>(i));
    }
  }
}

std::vector<double> Layout::values(std::size_t wavelength, std::span<const double> x) const {
  std::vector<double> out = fixed_[wavelength];
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (const auto free_index = slots_[wavelength][i]) {
      out[i] = free_[*free_index].coordinate.to_parameter(x[*free_index]);
    }
  }
  return out;
}

std::vector<double> Layout::start_x() const {
  std::vector<double> x;
  for (const FreeParameter& parameter : free_) {
    x.push_back(parameter.coordinate.to_x(parameter.start));
  }
  return x;
}

const std::string& Layout::parameter_name(std::size_t free_index) const {
  return model_->parameters()[free_[free_index].parameter].name;
}

std::string Layout::label(std::size_t free_index) const {
  const FreeParameter& parameter = free_[free_index];
  std::string out = parameter_name(free_index);
  if (parameter.wavelength) {
    out += " " + wavelength_text(wavelengths_nm_[*parameter.wavelength]) + " nm";
  }
  return out;
}

}  // namespace umov::invert
