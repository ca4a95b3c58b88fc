#include "host/formats/visible_band.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "host/optics/luminous_efficiency.hpp"

namespace umov::formats {
namespace {

constexpr double first_um = 0.400, step_um = 0.010;

constexpr std::array<double, 31> daylight_d65{
    82.7549, 91.486,  93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861,
    115.923, 108.811, 109.354, 107.802, 104.79,  107.689, 104.405, 104.046,
    100.0,   96.3342, 95.788,  88.6856, 90.0062, 89.5991, 87.6987, 83.2886,
    83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091};

}  // namespace

std::vector<double> visible_shares(std::span<const double> wavelengths_um) {
  std::vector<double> shares(wavelengths_um.size(), 0.0);
  double total = 0;
  // Finer than the tables, so that wavelengths closer than 10 nm each get their part.
  constexpr int substeps = 20;
  for (std::size_t n = 0; n + 1 < daylight_d65.size(); ++n)
    for (int s = 0; s < substeps; ++s) {
      const double part = (s + 0.5) / substeps;
      const double um = first_um + step_um * (static_cast<double>(n) + part);
      const double weight = (daylight_d65[n] * (1 - part) + daylight_d65[n + 1] * part) *
                            optics::luminous_efficiency(um);
      const auto above = std::upper_bound(wavelengths_um.begin(), wavelengths_um.end(), um);
      const auto upper = static_cast<std::size_t>(above - wavelengths_um.begin());
      if (upper == 0 || upper == wavelengths_um.size()) {
        shares[upper == 0 ? 0 : upper - 1] += weight;
      } else {
        const double x =
            (um - wavelengths_um[upper - 1]) / (wavelengths_um[upper] - wavelengths_um[upper - 1]);
        shares[upper - 1] += weight * (1 - x);
        shares[upper] += weight * x;
      }
      total += weight;
    }
  for (double& share : shares) share /= total;
  return shares;
}

}  // namespace umov::formats
