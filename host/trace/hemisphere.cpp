#include "host/trace/hemisphere.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::trace {

using optics::pi;

Hemisphere::Hemisphere(std::size_t rings, std::size_t strip_cells, double strip_half_width)
    : strip_cells_(strip_cells),
      strip_half_width_(strip_half_width),
      strip_sine_(std::sin(strip_half_width)) {
  if (rings < 1 || rings > 180) {
    throw Error(fmt::format("a hemisphere of {} rings", rings), "choose 1 to 180");
  }
  if (strip_cells > 3600 || !(strip_half_width >= 0.0 && strip_half_width <= 0.25 * pi)) {
    throw Error(fmt::format("a strip of {} cells, {}° to each side", strip_cells,
                            optics::degrees(strip_half_width)),
                "choose up to 3600 cells and at most 45°");
  }
  const double width = 0.5 * pi / static_cast<double>(rings);
  first_.push_back(0);
  for (std::size_t ring = 0; ring < rings; ++ring) {
    const double middle = (static_cast<double>(ring) + 0.5) * width;
    const double count = std::max(1.0, std::round(2.0 * pi * std::sin(middle) / width));
    first_.push_back(first_.back() + static_cast<std::size_t>(count));
  }
  cells_ = first_.back();
  for (const std::size_t n : first_) {
    boundary_.push_back(1.0 - static_cast<double>(n) / static_cast<double>(cells_));
  }
}

Cell Hemisphere::cell(std::size_t index) const {
  if (index >= cells_) {
    const double step = pi / static_cast<double>(strip_cells_);
    const double low = -0.5 * pi + static_cast<double>(index - cells_) * step;
    const double w = strip_half_width_;
    return {low,
            low + step,
            -w,
            w,
            2.0 * strip_sine_ * step,
            (std::sin(low + step) - std::sin(low)) * (w + std::sin(w) * std::cos(w))};
  }
  const auto above = std::upper_bound(first_.begin(), first_.end(), index);
  const auto ring = static_cast<std::size_t>(above - first_.begin()) - 1;
  const double count = static_cast<double>(first_[ring + 1] - first_[ring]);
  const double step = 2.0 * pi / count;
  const double low = (static_cast<double>(index - first_[ring]) - 0.5) * step;
  const double high_z = boundary_[ring];
  const double low_z = boundary_[ring + 1];
  return {
      std::acos(high_z), std::acos(low_z),        low,
      low + step,        step * (high_z - low_z), 0.5 * step * (high_z * high_z - low_z * low_z)};
}

std::size_t Hemisphere::ring_of(double z) const {
  // Boundaries fall; the ring is the last whose upper boundary is at or above z.
  const auto below = std::upper_bound(boundary_.begin(), boundary_.end(), z, std::greater<>());
  const auto ring = static_cast<std::size_t>(below - boundary_.begin());
  return std::clamp<std::size_t>(ring, 1, boundary_.size() - 1) - 1;
}

std::size_t Hemisphere::find(const Vec3& direction) const {
  const std::size_t ring = ring_of(direction.z);
  const std::size_t count = first_[ring + 1] - first_[ring];
  double turn = std::atan2(direction.y, direction.x) / (2.0 * pi);
  turn = turn * static_cast<double>(count) + 0.5;
  if (turn < 0.0) turn += static_cast<double>(count);
  return first_[ring] + std::min(static_cast<std::size_t>(turn), count - 1);
}

std::optional<std::size_t> Hemisphere::find_in_strip(const Vec3& direction) const {
  if (strip_cells_ == 0 || std::abs(direction.y) > strip_sine_) return std::nullopt;
  const double turn = std::atan2(direction.x, direction.z) / pi + 0.5;
  const double place = std::max(0.0, turn * static_cast<double>(strip_cells_));
  return cells_ + std::min(static_cast<std::size_t>(place), strip_cells_ - 1);
}

}  // namespace umov::trace
