#include "host/surface/gaussian_heights.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/trace/random_stream.hpp"

namespace umov::surface {
namespace {

// Unit variance, independent (Box and Muller), four at a time.
std::vector<double> white_noise(std::size_t count, std::uint64_t seed) {
  std::vector<double> noise;
  noise.reserve(count + 3);
  for (std::uint64_t i = 0; noise.size() < count; ++i) {
    const auto u = trace::uniforms(seed, i, 0);
    for (const std::size_t k : {std::size_t{0}, std::size_t{2}}) {
      const double radius = std::sqrt(-2.0 * std::log(u[k]));
      noise.push_back(radius * std::cos(2.0 * optics::pi * u[k + 1]));
      noise.push_back(radius * std::sin(2.0 * optics::pi * u[k + 1]));
    }
  }
  noise.resize(count);
  return noise;
}

// Along rows, periodically; the result is transposed, so that a second call does the columns.
std::vector<double> smoothed(const std::vector<double>& values, std::size_t side,
                             const std::vector<double>& kernel) {
  const std::size_t reach = kernel.size() / 2;
  std::vector<double> out(values.size());
  std::vector<double> row(side + 2 * reach);
  for (std::size_t y = 0; y < side; ++y) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      row[i] = values[y * side + (i + side - reach) % side];
    }
    for (std::size_t x = 0; x < side; ++x) {
      double sum = 0.0;
      for (std::size_t k = 0; k < kernel.size(); ++k) sum += kernel[k] * row[x + k];
      out[x * side + y] = sum;
    }
  }
  return out;
}

// Mean square of the triangles' slopes, along one direction.
double mean_square_slope(const std::vector<double>& z, std::size_t side, double cell) {
  double sum = 0.0;
  for (std::size_t y = 0; y < side; ++y) {
    const std::size_t above = (y + 1) % side;
    for (std::size_t x = 0; x < side; ++x) {
      const std::size_t right = (x + 1) % side;
      const double a = z[y * side + x];
      const double b = z[y * side + right];
      const double c = z[above * side + right];
      const double d = z[above * side + x];
      sum += (b - a) * (b - a) + (c - b) * (c - b) + (c - d) * (c - d) + (d - a) * (d - a);
    }
  }
  // Four squared steps a cell belong to two triangles of two directions each.
  return sum / (4.0 * static_cast<double>(side * side) * cell * cell);
}

}  // namespace

std::vector<double> gaussian_heights(std::size_t side, double size, double correlation,
                                     double slope_rms, std::uint64_t seed) {
  if (!(slope_rms >= 0.0 && slope_rms <= 3.0)) {
    throw Error(fmt::format("a rough surface with an rms slope of {}", slope_rms), "choose 0 to 3");
  }
  const double cell = size / static_cast<double>(side);
  if (side == 0 || !(correlation >= 4.0 * cell)) {
    throw Error(fmt::format("{} cells on {} do not resolve a correlation length of {}", side, size,
                            correlation),
                "use at least 4 cells a correlation length");
  }
  if (!(size >= 8.0 * correlation)) {
    throw Error(fmt::format("a correlation length of {} in a period of {}", correlation, size),
                "make the period at least 8 correlation lengths");
  }
  const double length = correlation / cell;
  const auto reach = static_cast<std::size_t>(std::ceil(2.5 * length));
  std::vector<double> kernel;
  for (std::size_t i = 0; i <= 2 * reach; ++i) {
    const double x = (static_cast<double>(i) - static_cast<double>(reach)) / length;
    kernel.push_back(std::exp(-2.0 * x * x));
  }
  std::vector<double> heights =
      smoothed(smoothed(white_noise(side * side, seed), side, kernel), side, kernel);
  const double scale = slope_rms / std::sqrt(mean_square_slope(heights, side, cell));
  for (double& z : heights) z *= scale;
  return heights;
}

}  // namespace umov::surface
