#include "host/brdf/grid_table.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "host/brdf/table_axis.hpp"
#include "host/errors/error.hpp"

namespace umov::brdf {
namespace {

constexpr double just_below_right_angle_deg = 90.0 - 1e-9;
constexpr double longest_wavelength_um = 1e6;

/// Signs of the elements on the other side of the plane of incidence: U and V change theirs.
constexpr std::array<double, 4> mirrored{1.0, 1.0, -1.0, -1.0};

}  // namespace

GridTable::GridTable(GridAxes axes, std::vector<double> values, int elements, std::string origin)
    : axes_(std::move(axes)),
      values_(std::move(values)),
      elements_(elements),
      origin_(std::move(origin)) {
  check_axis(axes_.theta_i_deg, origin_, "theta_i_deg", 0.0, just_below_right_angle_deg);
  check_axis(axes_.theta_r_deg, origin_, "theta_r_deg", 0.0, 90.0);
  check_axis(axes_.phi_r_deg, origin_, "phi_r_deg", -180.0, 180.0);
  check_axis(axes_.wavelength_um, origin_, "wavelength_um", 1e-3, longest_wavelength_um);
  full_circle_ = axes_.phi_r_deg.front() < 0.0;
  if (elements_ != 1 && elements_ != 16) {
    throw Error({origin_}, fmt::format("a table with {} elements per direction", elements_),
                "give 1 (m00) or 16 (the Mueller matrix, row by row)");
  }
  const auto stride = static_cast<std::size_t>(elements_);
  const std::size_t ni = axes_.theta_i_deg.size(), nr = axes_.theta_r_deg.size(),
                    np = axes_.phi_r_deg.size();
  const std::size_t expected = axes_.wavelength_um.size() * ni * nr * np * stride;
  if (values_.size() != expected) {
    throw Error({origin_}, fmt::format("{} values for a grid of {}", values_.size(), expected),
                "give one for every direction and wavelength; a grid has no holes");
  }
  for (std::size_t k = 0; k < expected; ++k) {
    const std::size_t element = k % stride;
    if (std::isfinite(values_[k]) && (element != 0 || values_[k] >= 0.0)) continue;
    const std::size_t p = k / stride % np, r = k / stride / np % nr, i = k / stride / np / nr % ni,
                      w = k / stride / np / nr / ni;
    throw Error({origin_, 0, fmt::format("[{}][{}][{}][{}]", w, i, r, p)},
                fmt::format("m{}{} = {} at θi {:g}°, θr {:g}°, φ {:g}°, {:g} µm", element / 4,
                            element % 4, values_[k], axes_.theta_i_deg[i], axes_.theta_r_deg[r],
                            axes_.phi_r_deg[p], axes_.wavelength_um[w]),
                std::isfinite(values_[k]) ? "a BRDF is not negative; set noise about zero to 0"
                                          : "fill holes before making a table");
  }
}

optics::Mueller<double> GridTable::at(double wavelength_um,
                                      const Geometry<double>& geometry) const {
  optics::Mueller<double> m(0.0);
  double theta_r = geometry.theta_r, phi = geometry.phi_r;
  if (theta_r < 0.0) {
    theta_r = -theta_r;
    phi += optics::pi;
  }
  if (!(std::abs(geometry.theta_i) < 0.5 * optics::pi) || !(theta_r < 0.5 * optics::pi)) return m;
  double phi_deg = optics::degrees(std::remainder(phi, 2.0 * optics::pi));
  const bool flipped = !full_circle_ && phi_deg < 0.0;
  if (flipped) phi_deg = -phi_deg;

  const AxisPlace w = place_on(axes_.wavelength_um, wavelength_um);
  const AxisPlace i = place_on(axes_.theta_i_deg, optics::degrees(geometry.theta_i));
  const AxisPlace r = place_on(axes_.theta_r_deg, optics::degrees(theta_r));
  AxisPlace p = place_on(axes_.phi_r_deg, phi_deg);
  if (full_circle_ && p.lower == p.upper) {
    // Outside the entries on a circle is between its last and its first.
    const std::vector<double>& axis = axes_.phi_r_deg;
    const double gap = axis.front() + 360.0 - axis.back();
    const double beyond =
        phi_deg >= axis.back() ? phi_deg - axis.back() : phi_deg + 360.0 - axis.back();
    p = {axis.size() - 1, 0, gap > 0.0 ? beyond / gap : 0.0};
  }

  const auto stride = static_cast<std::size_t>(elements_);
  for (const bool w_up : {false, true}) {
    const double weight_w = w_up ? w.weight : 1.0 - w.weight;
    if (weight_w == 0.0) continue;
    for (const bool i_up : {false, true}) {
      const double weight_i = weight_w * (i_up ? i.weight : 1.0 - i.weight);
      if (weight_i == 0.0) continue;
      const std::size_t row =
          (w_up ? w.upper : w.lower) * axes_.theta_i_deg.size() + (i_up ? i.upper : i.lower);
      for (const bool r_up : {false, true}) {
        const double weight_r = weight_i * (r_up ? r.weight : 1.0 - r.weight);
        if (weight_r == 0.0) continue;
        const std::size_t ring = row * axes_.theta_r_deg.size() + (r_up ? r.upper : r.lower);
        for (const bool p_up : {false, true}) {
          const double weight = weight_r * (p_up ? p.weight : 1.0 - p.weight);
          if (weight == 0.0) continue;
          const double* entry =
              values_.data() +
              (ring * axes_.phi_r_deg.size() + (p_up ? p.upper : p.lower)) * stride;
          for (std::size_t k = 0; k < stride; ++k) {
            m[static_cast<int>(k % 4)][static_cast<int>(k / 4)] += weight * entry[k];
          }
        }
      }
    }
  }
  if (flipped) {
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) {
        m[column][row] *=
            mirrored[static_cast<std::size_t>(row)] * mirrored[static_cast<std::size_t>(column)];
      }
    }
  }
  return m;
}

ExitBreaks GridTable::exit_breaks() const {
  ExitBreaks breaks;
  breaks.theta_r.push_back(0.0);
  for (const double deg : axes_.theta_r_deg) {
    if (deg > 0.0 && deg < 90.0) breaks.theta_r.push_back(optics::radians(deg));
  }
  breaks.theta_r.push_back(0.5 * optics::pi);

  std::vector<double> circle{-180.0, 180.0};
  for (const double deg : axes_.phi_r_deg) {
    circle.push_back(deg);
    if (!full_circle_) circle.push_back(-deg);
  }
  std::sort(circle.begin(), circle.end());
  circle.erase(std::unique(circle.begin(), circle.end()), circle.end());
  for (const double deg : circle) breaks.phi_r.push_back(optics::radians(deg));
  return breaks;
}

std::string GridTable::description() const {
  return fmt::format("grid of {} theta_i x {} theta_r x {} phi_r x {} wavelengths, {}, from {}",
                     axes_.theta_i_deg.size(), axes_.theta_r_deg.size(), axes_.phi_r_deg.size(),
                     axes_.wavelength_um.size(), polarised() ? "Mueller" : "unpolarised", origin_);
}

}  // namespace umov::brdf
