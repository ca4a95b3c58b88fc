// Which numbers a fit varies: the model's parameters, shared or one for each wavelength, fixed or
// free, laid out as one vector of coordinates.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/brdf/model.hpp"
#include "host/invert/coordinates.hpp"
#include "host/invert/invert.hpp"

namespace umov::invert {

/// One entry of the coordinate vector.
struct FreeParameter {
  std::size_t parameter = 0;              ///< index in the model's list
  std::optional<std::size_t> wavelength;  ///< absent where shared
  Coordinate coordinate;
  double start = 0;         ///< in the parameter's unit
  bool user_start = false;  ///< start was given by the user
};

class Layout {
 public:
  /// Throws umov::Error for unknown names, wavelengths that are not in the data, values outside the
  /// model's limits and contradictions.
  Layout(const brdf::Model& model, std::vector<double> wavelengths_nm, const Options& options);

  const brdf::Model& model() const { return *model_; }
  const std::vector<double>& wavelengths_nm() const { return wavelengths_nm_; }
  double wavelength_um(std::size_t wavelength) const { return wavelengths_nm_[wavelength] * 1e-3; }
  const std::vector<FreeParameter>& free() const { return free_; }
  std::size_t size() const { return free_.size(); }
  bool is_shared(std::size_t parameter) const { return shared_[parameter]; }

  /// Index in free() of a parameter at a wavelength; nullopt where fixed.
  std::optional<std::size_t> slot(std::size_t wavelength, std::size_t parameter) const {
    return slots_[wavelength][parameter];
  }
  /// Model indices of the parameters that are free at a wavelength.
  const std::vector<int>& active(std::size_t wavelength) const { return active_[wavelength]; }

  /// Parameter values at a wavelength in the model's order. `x` has size() coordinates.
  std::vector<double> values(std::size_t wavelength, std::span<const double> x) const;

  std::vector<double> start_x() const;
  /// "k_fs 532 nm", or "sigma_um" where shared.
  std::string label(std::size_t free_index) const;
  const std::string& parameter_name(std::size_t free_index) const;

 private:
  const brdf::Model* model_;
  std::vector<double> wavelengths_nm_;
  std::vector<bool> shared_;
  std::vector<FreeParameter> free_;
  std::vector<std::vector<std::optional<std::size_t>>> slots_;
  std::vector<std::vector<double>> fixed_;  ///< [wavelength][parameter]
  std::vector<std::vector<int>> active_;
};

/// "532", "632.8": a wavelength as people write it.
std::string wavelength_text(double wavelength_nm);

}  // namespace umov::invert
