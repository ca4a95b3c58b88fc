#include "host/chamber/figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/errors/error.hpp"

namespace umov::chamber {

Map cut(const Map& map, const Region& region) {
  const auto first = [&](double mm) {
    return static_cast<std::size_t>(std::max(0.0, std::ceil(mm / map.pixel_mm - 0.5 - 1e-9)));
  };
  const auto behind = [&](double mm, std::size_t size) {
    const double n = std::floor(mm / map.pixel_mm + 0.5 + 1e-9);
    return std::min(size, static_cast<std::size_t>(std::max(0.0, n)));
  };
  const std::size_t x0 = first(region.x_from_mm);
  const std::size_t y0 = first(region.y_from_mm);
  const std::size_t x1 = behind(region.x_to_mm, map.width);
  const std::size_t y1 = behind(region.y_to_mm, map.height);
  if (x1 <= x0 || y1 <= y0) {
    throw Error(
        "the region holds no pixel of the map",
        fmt::format("the map is {:g} mm × {:g} mm", map.pixel_mm * static_cast<double>(map.width),
                    map.pixel_mm * static_cast<double>(map.height)));
  }
  Map part;
  part.width = x1 - x0;
  part.height = y1 - y0;
  part.pixel_mm = map.pixel_mm;
  part.rays_per_pixel = map.rays_per_pixel;
  for (std::size_t y = y0; y < y1; ++y) {
    for (std::size_t x = x0; x < x1; ++x) {
      part.luminance_cd_m2.push_back(map.at(x, y));
      part.luminance_se.push_back(map.luminance_se[y * map.width + x]);
    }
  }
  return part;
}

Map joined(const Map& map, std::size_t n) {
  if (n == 0 || map.width < n || map.height < n) {
    throw Error(
        fmt::format("{} × {} pixels cannot be joined {} by {}", map.width, map.height, n, n),
        "join fewer");
  }
  Map out = map;
  for (auto* bands : {&out.wavelengths_um, &out.radiance, &out.radiance_se}) bands->clear();
  out.width = map.width / n;
  out.height = map.height / n;
  out.pixel_mm = map.pixel_mm * static_cast<double>(n);
  out.rays_per_pixel = map.rays_per_pixel * n * n;
  out.luminance_cd_m2.assign(out.width * out.height, 0.0);
  out.luminance_se.assign(out.width * out.height, 0.0);
  const double of_all = 1.0 / static_cast<double>(n * n);
  for (std::size_t y = 0; y < out.height * n; ++y) {
    for (std::size_t x = 0; x < out.width * n; ++x) {
      const std::size_t pixel = y * map.width + x;
      const std::size_t whole = y / n * out.width + x / n;
      out.luminance_cd_m2[whole] += of_all * map.luminance_cd_m2[pixel];
      out.luminance_se[whole] =
          std::hypot(out.luminance_se[whole], of_all * map.luminance_se[pixel]);
    }
  }
  return out;
}

Evenness evenness(const Map& map) {
  Evenness e{0.0, 0.0, std::numeric_limits<double>::infinity(), 0.0};
  for (const double value : map.luminance_cd_m2) {
    e.maximum = std::max(e.maximum, value);
    e.minimum = std::min(e.minimum, value);
    e.mean += value / static_cast<double>(map.luminance_cd_m2.size());
  }
  e.uniformity = e.mean > 0.0 ? e.minimum / e.mean : 0.0;
  return e;
}

Likeness likeness(const Map& a, const Map& b) {
  if (a.width != b.width || a.height != b.height) {
    throw Error(fmt::format("maps of {} × {} and {} × {} pixels cannot be compared", a.width,
                            a.height, b.width, b.height),
                "take both with the same camera");
  }
  const std::size_t count = a.luminance_cd_m2.size();
  const double n = static_cast<double>(count);
  const double mean_a = evenness(a).mean;
  const double mean_b = evenness(b).mean;
  double ab = 0.0, aa = 0.0, bb = 0.0, squares = 0.0, sizes = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = a.luminance_cd_m2[i];
    const double y = b.luminance_cd_m2[i];
    ab += (x - mean_a) * (y - mean_b);
    aa += (x - mean_a) * (x - mean_a);
    bb += (y - mean_b) * (y - mean_b);
    squares += (x - y) * (x - y);
    sizes += std::abs(x - y);
    largest = std::max({largest, x, y});
  }
  const double product = std::sqrt(aa * bb);
  Likeness l{product > 0.0 ? ab / product : 0.0, 0.0, 0.0};
  if (largest > 0.0) {
    l.nrmse = std::sqrt(squares / n) / largest;
    l.mean_deviation = sizes / n / largest;
  }
  return l;
}

Map moved(const Map& map, double x_pixels, double y_pixels) {
  Map out = map;
  for (auto* bands : {&out.wavelengths_um, &out.radiance, &out.radiance_se}) bands->clear();
  const auto value = [&](long x, long y) {
    const long w = static_cast<long>(map.width) - 1;
    const long h = static_cast<long>(map.height) - 1;
    return map.at(static_cast<std::size_t>(std::clamp(x, 0L, w)),
                  static_cast<std::size_t>(std::clamp(y, 0L, h)));
  };
  for (std::size_t y = 0; y < map.height; ++y) {
    for (std::size_t x = 0; x < map.width; ++x) {
      const double from_x = static_cast<double>(x) - x_pixels;
      const double from_y = static_cast<double>(y) - y_pixels;
      const long x0 = static_cast<long>(std::floor(from_x));
      const long y0 = static_cast<long>(std::floor(from_y));
      const double wx = from_x - static_cast<double>(x0);
      const double wy = from_y - static_cast<double>(y0);
      out.luminance_cd_m2[y * map.width + x] =
          (1.0 - wy) * ((1.0 - wx) * value(x0, y0) + wx * value(x0 + 1, y0)) +
          wy * ((1.0 - wx) * value(x0, y0 + 1) + wx * value(x0 + 1, y0 + 1));
    }
  }
  return out;
}

Registration registered(const Map& a, const Map& b, double reach) {
  double best_x = 0.0;
  double best_y = 0.0;
  Likeness best = likeness(a, b);
  for (double step = std::max(1.0, std::floor(reach / 2.0)); step > 0.04; step /= 2.0) {
    for (bool better = true; better;) {
      better = false;
      const double x = best_x;
      const double y = best_y;
      for (const int i : {-1, 0, 1}) {
        for (const int j : {-1, 0, 1}) {
          const double tx = x + i * step;
          const double ty = y + j * step;
          if ((i == 0 && j == 0) || std::abs(tx) > reach || std::abs(ty) > reach) continue;
          const Likeness l = likeness(a, moved(b, tx, ty));
          if (l.ncc <= best.ncc + 1e-12) continue;
          best = l;
          best_x = tx;
          best_y = ty;
          better = true;
        }
      }
    }
  }
  return {best_x, best_y, best};
}

DistributionDifference difference(const Distribution& a, const Distribution& b, int plane) {
  if (a.c_deg.size() != b.c_deg.size() || a.gamma_deg.size() != b.gamma_deg.size()) {
    throw Error("distributions on different directions cannot be compared",
                "take both with the same planes and angles");
  }
  const std::size_t planes = a.c_deg.size();
  const auto chosen = static_cast<std::size_t>(std::max(0, plane));
  const double peak = *std::max_element(a.intensity_cd.begin(), a.intensity_cd.end());
  double largest = 0.0, squares = 0.0, count = 0.0;
  for (std::size_t c = 0; c < planes; ++c) {
    if (plane >= 0 && c != chosen && 2 * c != 2 * chosen + planes && 2 * chosen != 2 * c + planes)
      continue;
    for (std::size_t g = 0; g < a.gamma_deg.size(); ++g) {
      if (a.gamma_deg[g] > 90.0) continue;
      const double d = std::abs(a.intensity(c, g) - b.intensity(c, g));
      largest = std::max(largest, d);
      squares += d * d;
      count += 1.0;
    }
  }
  return {largest / peak, std::sqrt(squares / count) / peak};
}

GlareRating glare_rating(const Map& map, const Glare& glare) {
  const double distance_mm = 1000.0 * glare.observer_distance_m;
  const double solid_angle = map.pixel_mm * map.pixel_mm / (distance_mm * distance_mm);
  double squares = 0.0, sum = 0.0, bright = 0.0;
  for (const double value : map.luminance_cd_m2) {
    squares += value * value * solid_angle;
    if (value > 0.0) {
      sum += value * solid_angle;
      bright += solid_angle;
    }
  }
  const auto rating = [&](double l2_sr) {
    const double p2 = glare.position_index * glare.position_index;
    return 8.0 * std::log10(0.25 / glare.background_cd_m2 * l2_sr / p2);
  };
  return {rating(squares), rating(bright > 0.0 ? sum * sum / bright : 0.0)};
}

}  // namespace umov::chamber
