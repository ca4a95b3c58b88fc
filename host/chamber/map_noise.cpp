#include "host/chamber/map_noise.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "host/errors/error.hpp"

namespace umov::chamber {
namespace {

constexpr double least_share = 1e-4;
constexpr std::size_t fewest = 64;
constexpr std::size_t of_a_class = 200;
constexpr std::size_t most_classes = 12;
/// Standard deviation over median size, of the normal distribution.
constexpr double over_median = 1.4826022185056018;

/// Mean luminance about a pixel, and what the mask leaves there.
using Reading = std::pair<double, double>;

std::vector<Reading> readings_of(const Map& map) {
  constexpr int mask[3] = {1, -2, 1};
  std::vector<Reading> readings;
  for (std::size_t y = 1; y + 1 < map.height; ++y) {
    for (std::size_t x = 1; x + 1 < map.width; ++x) {
      double left = 0.0, mean = 0.0;
      bool lit = true;
      for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t i = 0; i < 3; ++i) {
          const double value = map.at(x + i - 1, y + j - 1);
          left += mask[i] * mask[j] * value;
          mean += value / 9.0;
          lit = lit && value > 0.0;
        }
      }
      if (lit) readings.emplace_back(mean, std::abs(left));
    }
  }
  return readings;
}

/// Noise of the pixels [first, last), which are of about one luminance.
double deviation(std::vector<Reading>::iterator first, std::vector<Reading>::iterator last) {
  const auto middle = first + (last - first) / 2;
  std::nth_element(first, middle, last,
                   [](const Reading& a, const Reading& b) { return a.second < b.second; });
  constexpr double of_mask = 6.0;
  return over_median * middle->second / of_mask;
}

}  // namespace

std::vector<double> estimated_noise(const Map& map) {
  std::vector<Reading> readings = readings_of(map);
  if (readings.size() < fewest) {
    throw Error(
        fmt::format("only {} pixels shine, too few to estimate the noise from", readings.size()),
        "give the standard error of each pixel");
  }
  std::sort(readings.begin(), readings.end());
  const std::size_t classes =
      std::clamp<std::size_t>(readings.size() / of_a_class, 1, most_classes);
  std::vector<double> luminance, noise;
  for (std::size_t k = 0; k < classes; ++k) {
    const auto at = [&](std::size_t part) {
      return readings.begin() + static_cast<std::ptrdiff_t>(readings.size() * part / classes);
    };
    luminance.push_back((at(k) + (at(k + 1) - at(k)) / 2)->first);
    noise.push_back(deviation(at(k), at(k + 1)));
  }
  std::vector<double> out;
  for (const double value : map.luminance_cd_m2) {
    const auto above = std::upper_bound(luminance.begin(), luminance.end(), value);
    const auto i = static_cast<std::size_t>(above - luminance.begin());
    double sigma = i == 0 ? noise.front() : noise[i - 1];
    if (i > 0 && i < classes) {
      const double part = (value - luminance[i - 1]) / (luminance[i] - luminance[i - 1]);
      sigma += part * (noise[i] - noise[i - 1]);
    }
    out.push_back(std::max(sigma, least_share * value));
  }
  return out;
}

}  // namespace umov::chamber
