#include "host/chamber/bands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/errors/error.hpp"
#include "host/optics/luminous_efficiency.hpp"

namespace umov::chamber {

using optics::luminous_efficiency;
using optics::visible_from_um;
using optics::visible_to_um;

template <class Visitor>
void Bands::belongs(double wavelength_um, const Visitor& visit) const {
  const auto above =
      std::upper_bound(wavelengths_um_.begin(), wavelengths_um_.end(), wavelength_um);
  if (above == wavelengths_um_.begin()) return visit(0, 1.0);
  if (above == wavelengths_um_.end()) return visit(size() - 1, 1.0);
  const auto upper = static_cast<std::size_t>(above - wavelengths_um_.begin());
  const double part =
      (wavelength_um - wavelengths_um_[upper - 1]) / (*above - wavelengths_um_[upper - 1]);
  visit(upper - 1, 1.0 - part);
  visit(upper, part);
}

Bands::Bands(std::vector<double> wavelengths_um) : wavelengths_um_(std::move(wavelengths_um)) {
  if (wavelengths_um_.empty() || wavelengths_um_.size() > most) {
    throw Error(fmt::format("{} bands", wavelengths_um_.size()), fmt::format("give 1 to {}", most));
  }
  for (std::size_t b = 0; b < size(); ++b) {
    const double um = wavelengths_um_[b];
    if (!(um >= visible_from_um && um <= visible_to_um) ||
        (b > 0 && um <= wavelengths_um_[b - 1])) {
      throw Error(fmt::format("a band at {:g} nm after {:g} nm", 1e3 * um,
                              b > 0 ? 1e3 * wavelengths_um_[b - 1] : 1e3 * visible_from_um),
                  "list wavelengths in rising order, from 360 to 830 nm");
    }
  }
  lumens_.assign(size(), 0.0);
  // V(λ) is linear over pieces of 5 nm: midpoints of .1 nm leave 1e-6 of its integral.
  constexpr double step_nm = 0.1;
  const auto steps =
      static_cast<int>(std::lround(1e3 * (visible_to_um - visible_from_um) / step_nm));
  for (int i = 0; i < steps; ++i) {
    const double um = visible_from_um + 1e-3 * step_nm * (i + 0.5);
    if (size() > 1 && (um < wavelengths_um_.front() || um > wavelengths_um_.back())) continue;
    const double lumens = optics::luminous_efficacy_lm_w * luminous_efficiency(um) * step_nm;
    belongs(um, [&](std::size_t band, double share) { lumens_[band] += share * lumens; });
  }
}

double Bands::luminous(std::span<const double> spectral) const {
  double sum = 0.0;
  for (std::size_t b = 0; b < size(); ++b) sum += lumens_[b] * spectral[b];
  return sum;
}

std::vector<double> Bands::fine_um() const {
  std::vector<double> fine;
  const double first = wavelengths_um_.front();
  const double last = wavelengths_um_.back();
  double step = 1e-3;
  for (std::size_t b = 1; b < size(); ++b)
    step = std::min(step, 0.25 * (wavelengths_um_[b] - wavelengths_um_[b - 1]));
  const auto steps = static_cast<int>(std::ceil((last - first) / step - 1e-3));
  for (int i = 0; i < steps; ++i) fine.push_back(first + step * i);
  fine.push_back(last);
  return fine;
}

std::vector<double> Bands::means(std::span<const double> fine) const {
  const std::vector<double> um = fine_um();
  std::vector<double> sums(size(), 0.0);
  std::vector<double> weights(size(), 0.0);
  for (std::size_t i = 0; i < um.size(); ++i) {
    belongs(um[i], [&](std::size_t band, double share) {
      const double weight = share * luminous_efficiency(um[i]);
      sums[band] += weight * fine[i];
      weights[band] += weight;
    });
  }
  for (std::size_t b = 0; b < size(); ++b) sums[b] /= weights[b];
  return sums;
}

}  // namespace umov::chamber
