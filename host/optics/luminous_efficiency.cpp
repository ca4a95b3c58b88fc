#include "host/optics/luminous_efficiency.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace umov::optics {
namespace {

constexpr double first_um = 0.380, step_um = 0.005;

constexpr std::array<double, 81> middle{
    0.000039, 0.000064, 0.00012,  0.000217, 0.000396, 0.00064,  0.00121, 0.00218,  0.004,
    0.0073,   0.0116,   0.01684,  0.023,    0.0298,   0.038,    0.048,   0.06,     0.0739,
    0.09098,  0.1126,   0.13902,  0.1693,   0.20802,  0.2586,   0.323,   0.4073,   0.503,
    0.6082,   0.71,     0.7932,   0.862,    0.91485,  0.954,    0.9803,  0.99495,  1.0,
    0.995,    0.9786,   0.952,    0.9154,   0.87,     0.8163,   0.757,   0.6949,   0.631,
    0.5668,   0.503,    0.4412,   0.381,    0.321,    0.265,    0.217,   0.175,    0.1382,
    0.107,    0.0816,   0.061,    0.04458,  0.032,    0.0232,   0.017,   0.01192,  0.00821,
    0.005723, 0.004102, 0.002929, 0.002091, 0.001484, 0.001047, 0.00074, 0.00052,  0.000361,
    0.000249, 0.000172, 0.00012,  0.000085, 0.00006,  0.000042, 0.00003, 0.000021, 0.000015};

// 360, 370 and 380 nm; 780 to 830 nm.
constexpr std::array<double, 3> violet{3.917e-6, 1.239e-5, 3.9e-5};
constexpr std::array<double, 6> deep_red{1.5e-5, 7.49e-6, 3.703e-6, 1.836e-6, 9.11e-7, 4.52e-7};

template <std::size_t Count>
double linear(const std::array<double, Count>& values, double place) {
  const auto lower = std::min(static_cast<std::size_t>(place), Count - 2);
  return values[lower] + (place - static_cast<double>(lower)) * (values[lower + 1] - values[lower]);
}

}  // namespace

double luminous_efficiency(double wavelength_um) {
  if (!(wavelength_um >= visible_from_um && wavelength_um <= visible_to_um)) return 0.0;
  constexpr double last_um = first_um + step_um * (middle.size() - 1);
  if (wavelength_um < first_um) {
    return linear(violet, (wavelength_um - visible_from_um) / (2.0 * step_um));
  }
  if (wavelength_um > last_um) return linear(deep_red, (wavelength_um - last_um) / (2.0 * step_um));
  return linear(middle, (wavelength_um - first_um) / step_um);
}

}  // namespace umov::optics
