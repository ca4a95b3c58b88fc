#include "hil/plant/spectrum.hpp"

#include <algorithm>
#include <cstddef>

namespace umov::plant {

double Spectrum::at(double wavelength_nm) const {
  if (wavelength_nm <= wavelength_nm_.front()) return value_.front();
  if (wavelength_nm >= wavelength_nm_.back()) return value_.back();
  const auto above = std::upper_bound(wavelength_nm_.begin(), wavelength_nm_.end(), wavelength_nm);
  const auto i = static_cast<std::size_t>(above - wavelength_nm_.begin());
  const double t =
      (wavelength_nm - wavelength_nm_[i - 1]) / (wavelength_nm_[i] - wavelength_nm_[i - 1]);
  return value_[i - 1] + t * (value_[i] - value_[i - 1]);
}

Spectrum Spectrum::scaled(double factor) const {
  Spectrum changed = *this;
  for (double& value : changed.value_) value *= factor;
  return changed;
}

}  // namespace umov::plant
