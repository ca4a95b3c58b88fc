#include "host/formats/specular_table.hpp"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "host/brdf/table_axis.hpp"
#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/mueller.hpp"

namespace umov::formats {
namespace {

using optics::pi;

/// place_on() a circle: `deg` within [0, 360), the axis within [0, 360].
brdf::AxisPlace place_around(const std::vector<double>& axis, double deg) {
  const double gap = axis.front() + 360.0 - axis.back();
  if ((deg >= axis.front() && deg <= axis.back()) || !(gap > 0.0)) return brdf::place_on(axis, deg);
  const double past = deg > axis.back() ? deg - axis.back() : deg + 360.0 - axis.back();
  return {axis.size() - 1, 0, past / gap};
}

}  // namespace

SpecularAngles specular_angles(const brdf::Geometry<double>& geometry) {
  const double sine = std::sin(geometry.theta_r);
  const double x = sine * std::cos(geometry.phi_r);
  const double y = sine * std::sin(geometry.phi_r);
  const double z = std::cos(geometry.theta_r);
  const double ci = std::cos(geometry.theta_i), si = std::sin(geometry.theta_i);
  const double forward = x * ci - z * si;  // in the plane of incidence, away from the normal
  const double along = x * si + z * ci;
  double azimuth = std::atan2(-y, -forward);
  if (azimuth < 0.0) azimuth += 2.0 * pi;
  return {std::atan2(std::hypot(forward, y), along), azimuth};
}

brdf::Geometry<double> geometry_of(double theta_i, const SpecularAngles& angles) {
  const double sine = std::sin(angles.radial);
  const double forward = -sine * std::cos(angles.azimuth);
  const double y = -sine * std::sin(angles.azimuth);
  const double along = std::cos(angles.radial);
  const double ci = std::cos(theta_i), si = std::sin(theta_i);
  const double x = forward * ci + along * si;
  const double z = along * ci - forward * si;
  return {theta_i, std::atan2(std::hypot(x, y), z), std::atan2(y, x)};
}

SpecularTable::SpecularTable(SpecularAxes axes, std::vector<double> wavelengths_um,
                             std::vector<double> values, std::vector<double> tis,
                             std::string origin)
    : axes_(std::move(axes)),
      wavelengths_um_(std::move(wavelengths_um)),
      values_(std::move(values)),
      tis_(std::move(tis)),
      origin_(std::move(origin)) {
  brdf::check_axis(axes_.theta_i_deg, origin_, "incidence", 0.0, 90.0);
  if (axes_.theta_i_deg.back() >= 90.0)
    throw Error(Place{origin_, 0, "incidence"}, "an incidence of 90 degrees has no BRDF",
                "leave grazing incidence out");
  brdf::check_axis(axes_.azimuth_deg, origin_, "azimuth", 0.0, axes_.symmetric ? 180.0 : 360.0);
  brdf::check_axis(axes_.radial_deg, origin_, "radial angle", 0.0, 180.0);
  brdf::check_axis(wavelengths_um_, origin_, "wavelength_um", 1e-3, 1e4);
  const std::size_t slices = wavelengths_um_.size() * axes_.theta_i_deg.size();
  const std::size_t slice = axes_.azimuth_deg.size() * axes_.radial_deg.size();
  if (slices == 0 || tis_.size() != slices || values_.size() != slices * slice)
    throw Error(Place{origin_},
                fmt::format("has {} values and {} totals, not {} and {}", values_.size(),
                            tis_.size(), slices * slice, slices),
                "there is a value for every wavelength, incidence, azimuth and radial angle");
  for (const std::vector<double>* numbers : {&values_, &tis_})
    for (std::size_t i = 0; i < numbers->size(); ++i)
      if (!((*numbers)[i] >= 0.0) || !std::isfinite((*numbers)[i]))
        throw Error(Place{origin_}, fmt::format("value {} is {}", i + 1, (*numbers)[i]),
                    "a BRDF is a finite number of 0 or more");
  above_.reserve(axes_.theta_i_deg.size() * slice);
  for (const double theta_i : axes_.theta_i_deg)
    for (const double azimuth : axes_.azimuth_deg)
      for (const double radial : axes_.radial_deg) {
        const auto g = geometry_of(optics::radians(theta_i),
                                   {optics::radians(radial), optics::radians(azimuth)});
        above_.push_back(std::cos(g.theta_r) > 1e-6 ? 1 : 0);
      }
}

std::string SpecularTable::description() const {
  return fmt::format(
      "table around the mirror direction, {} incidences x {} azimuths x {} radial "
      "angles, from {}",
      axes_.theta_i_deg.size(), axes_.azimuth_deg.size(), axes_.radial_deg.size(), origin_);
}

double SpecularTable::slice_value(std::size_t wavelength, std::size_t incidence,
                                  const SpecularAngles& at) const {
  const std::size_t n_azimuth = axes_.azimuth_deg.size(), n_radial = axes_.radial_deg.size();
  double azimuth_deg = optics::degrees(at.azimuth);
  if (axes_.symmetric && azimuth_deg > 180.0) azimuth_deg = 360.0 - azimuth_deg;
  const brdf::AxisPlace a = axes_.symmetric ? brdf::place_on(axes_.azimuth_deg, azimuth_deg)
                                            : place_around(axes_.azimuth_deg, azimuth_deg);
  const brdf::AxisPlace r = brdf::place_on(axes_.radial_deg, optics::degrees(at.radial));
  const std::size_t slice = n_azimuth * n_radial;
  const unsigned char* above = above_.data() + incidence * slice;
  const double* values =
      values_.data() + (wavelength * axes_.theta_i_deg.size() + incidence) * slice;
  const auto ring = [&](std::size_t radial) {
    double sum = 0.0, weight = 0.0;
    for (const auto& [azimuth, share] :
         {std::pair(a.lower, 1.0 - a.weight), std::pair(a.upper, a.weight)}) {
      const std::size_t entry = azimuth * n_radial + radial;
      if (above[entry] == 0) continue;
      sum += share * values[entry];
      weight += share;
    }
    return std::pair(sum, weight);
  };
  const auto [low_sum, low_weight] = ring(r.lower);
  const auto [high_sum, high_weight] = ring(r.upper);
  const double weight = (1.0 - r.weight) * low_weight + r.weight * high_weight;
  if (weight > 1e-12) return ((1.0 - r.weight) * low_sum + r.weight * high_sum) / weight;
  for (std::size_t radial = r.lower + 1; radial-- > 0;)
    if (const auto [sum, known] = ring(radial); known > 1e-12) return sum / known;
  return 0.0;
}

optics::Mueller<double> SpecularTable::at(double wavelength_um,
                                          const brdf::Geometry<double>& geometry) const {
  optics::Mueller<double> m(0.0);
  if (!(std::cos(geometry.theta_i) > 0.0) || !(std::cos(geometry.theta_r) > 0.0)) return m;
  const SpecularAngles angles = specular_angles(geometry);
  const brdf::AxisPlace i = brdf::place_on(axes_.theta_i_deg, optics::degrees(geometry.theta_i));
  const brdf::AxisPlace w = brdf::place_on(wavelengths_um_, wavelength_um);
  const auto at_wavelength = [&](std::size_t wavelength) {
    const double lower = slice_value(wavelength, i.lower, angles);
    if (i.weight == 0.0) return lower;
    return (1.0 - i.weight) * lower + i.weight * slice_value(wavelength, i.upper, angles);
  };
  double value = at_wavelength(w.lower);
  if (w.weight != 0.0) value = (1.0 - w.weight) * value + w.weight * at_wavelength(w.upper);
  m[0][0] = value;
  return m;
}

}  // namespace umov::formats
