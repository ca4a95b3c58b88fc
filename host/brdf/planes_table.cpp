#include "host/brdf/planes_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/brdf/table_axis.hpp"
#include "host/errors/error.hpp"
#include "host/optics/frames.hpp"

namespace umov::brdf {
namespace {

using optics::degrees;
using optics::radians;

constexpr double just_below_right_angle_deg = 90.0 - 1e-9;
constexpr double longest_wavelength_um = 1e6;

double interpolate(const PlaneProfile& profile, std::size_t wavelength, double deg) {
  const AxisPlace place = place_on(profile.deg, deg);
  const std::vector<double>& values = profile.brdf_per_sr[wavelength];
  return values[place.lower] + place.weight * (values[place.upper] - values[place.lower]);
}

void check_profile(const PlaneProfile& profile, std::size_t wavelengths, const std::string& origin,
                   const std::string& name) {
  check_axis(profile.deg, origin, name + ".deg", -90.0, 90.0);
  if (profile.brdf_per_sr.size() != wavelengths) {
    throw Error(
        {origin, 0, name},
        fmt::format("values at {} wavelengths of {}", profile.brdf_per_sr.size(), wavelengths),
        "give a row of values for every wavelength");
  }
  for (std::size_t w = 0; w < wavelengths; ++w) {
    const std::vector<double>& values = profile.brdf_per_sr[w];
    if (values.size() != profile.deg.size()) {
      throw Error({origin, 0, fmt::format("{}[{}]", name, w)},
                  fmt::format("{} values for {} angles", values.size(), profile.deg.size()),
                  "give one value for every angle");
    }
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (std::isfinite(values[k]) && values[k] >= 0.0) continue;
      throw Error({origin, 0, fmt::format("{}[{}][{}]", name, w, k)},
                  fmt::format("{} at {:g}°", values[k], profile.deg[k]),
                  "a BRDF is a finite number that is not negative; leave out what could not be "
                  "measured");
    }
  }
}

/// Sets the entry at `deg` to `values` (one for each wavelength), which it adds where there is
/// none.
void set_entry(PlaneProfile& profile, double deg, const std::vector<double>& values) {
  const auto found = std::lower_bound(profile.deg.begin(), profile.deg.end(), deg);
  const auto index = found - profile.deg.begin();
  const bool exists = found != profile.deg.end() && *found == deg;
  if (!exists) profile.deg.insert(found, deg);
  for (std::size_t w = 0; w < values.size(); ++w) {
    std::vector<double>& row = profile.brdf_per_sr[w];
    if (exists) {
      row[static_cast<std::size_t>(index)] = values[w];
    } else {
      row.insert(row.begin() + index, values[w]);
    }
  }
}

/// Both profiles name the mirror direction: gives it one value in both.
PlanesAtIncidence joined(PlanesAtIncidence slice) {
  const auto has = [](const PlaneProfile& profile, double deg) {
    return std::binary_search(profile.deg.begin(), profile.deg.end(), deg);
  };
  const bool in_plane = has(slice.in_plane, slice.theta_i_deg);
  const bool across = has(slice.across, 0.0);
  std::vector<double> centre;
  for (std::size_t w = 0; w < slice.in_plane.brdf_per_sr.size(); ++w) {
    const double a = interpolate(slice.in_plane, w, slice.theta_i_deg);
    const double b = interpolate(slice.across, w, 0.0);
    centre.push_back(in_plane == across ? 0.5 * (a + b) : in_plane ? a : b);
  }
  set_entry(slice.in_plane, slice.theta_i_deg, centre);
  set_entry(slice.across, 0.0, centre);
  return slice;
}

}  // namespace

PlanesTable::PlanesTable(std::vector<double> wavelengths_um,
                         std::vector<PlanesAtIncidence> incidences, std::string origin)
    : wavelengths_um_(std::move(wavelengths_um)),
      given_(std::move(incidences)),
      origin_(std::move(origin)) {
  check_axis(wavelengths_um_, origin_, "wavelength_um", 1e-3, longest_wavelength_um);
  std::vector<double> theta_i_deg;
  for (const PlanesAtIncidence& slice : given_) theta_i_deg.push_back(slice.theta_i_deg);
  check_axis(theta_i_deg, origin_, "theta_i_deg", 0.0, just_below_right_angle_deg);
  for (const PlanesAtIncidence& slice : given_) {
    const std::string at = fmt::format(" at theta_i_deg {:g}", slice.theta_i_deg);
    check_profile(slice.in_plane, wavelengths_um_.size(), origin_, "in_plane" + at);
    check_profile(slice.across, wavelengths_um_.size(), origin_, "across" + at);
    joined_.push_back(joined(slice));
  }
}

double PlanesTable::value(std::size_t wavelength, const PlanesAtIncidence& slice,
                          const Facet& facet) const {
  const double theta_i = radians(slice.theta_i_deg);
  const double bend = std::sin(theta_i) * std::cos(theta_i);
  const bool signed_axis = slice.across.deg.front() < 0.0;
  // The direction across that the slope `tangent` mirrors into: there hx = -sin θi cos θi hy².
  const auto across = [&](double tangent) {
    const double root = 1.0 + std::sqrt(1.0 + 4.0 * bend * bend * tangent * tangent);
    const double half = std::atan(std::cos(theta_i) * tangent * std::sqrt(2.0 / root));
    const double beta = 2.0 * degrees(half);
    return interpolate(slice.across, wavelength, signed_axis && facet.left ? -beta : beta);
  };
  const double side = across(facet.tangent);
  if (facet.in_plane_share == 0.0) return side;
  const double turn = 2.0 * degrees(std::atan(facet.tangent));
  const double theta_r = slice.theta_i_deg + (facet.backward ? -turn : turn);
  double ahead = interpolate(slice.in_plane, wavelength, theta_r);
  if (std::abs(theta_r) > 90.0) {
    // No light was measured below the horizon; it would have fallen off as across.
    const double room = facet.backward ? 90.0 + slice.theta_i_deg : 90.0 - slice.theta_i_deg;
    const double at_horizon = across(std::tan(radians(0.5 * room)));
    if (side < at_horizon) ahead *= side / at_horizon;
  }
  return facet.in_plane_share * ahead + (1.0 - facet.in_plane_share) * side;
}

optics::Mueller<double> PlanesTable::at(double wavelength_um,
                                        const Geometry<double>& geometry) const {
  optics::Mueller<double> m(0.0);
  const optics::Vec3<double> k = optics::exit_direction(geometry.theta_r, geometry.phi_r);
  const double cos_i = std::cos(geometry.theta_i), sin_i = std::sin(geometry.theta_i);
  if (!(cos_i > 0.0) || !(k.z > 0.0)) return m;
  const double x = (k.x - sin_i) / (k.z + cos_i), y = k.y / (k.z + cos_i);
  const double along = x + sin_i * cos_i * y * y;  // 0 in the plane across, x in that of incidence
  const double squares = along * along + y * y;
  const Facet facet{std::hypot(x, y), squares > 0.0 ? along * along / squares : 1.0, along < 0.0,
                    y < 0.0};

  const AxisPlace w = place_on(wavelengths_um_, wavelength_um);
  const double theta_i_deg = degrees(geometry.theta_i);
  const auto above =
      std::upper_bound(joined_.begin(), joined_.end(), theta_i_deg,
                       [](double deg, const PlanesAtIncidence& s) { return deg < s.theta_i_deg; });
  const PlanesAtIncidence& upper = above == joined_.end() ? joined_.back() : *above;
  const PlanesAtIncidence& lower = above == joined_.begin() ? joined_.front() : *(above - 1);
  const double span = upper.theta_i_deg - lower.theta_i_deg;
  const double weight = span > 0.0 ? (theta_i_deg - lower.theta_i_deg) / span : 0.0;

  const auto at_wavelength = [&](std::size_t index) {
    const double low = value(index, lower, facet);
    if (weight == 0.0) return low;
    return low + weight * (value(index, upper, facet) - low);
  };
  double result = at_wavelength(w.lower);
  if (w.weight > 0.0) result += w.weight * (at_wavelength(w.upper) - result);
  m[0][0] = result;
  return m;
}

std::string PlanesTable::description() const {
  return fmt::format(
      "plane of incidence and the plane across the mirror direction, {} incidences x {} "
      "wavelengths, from {}",
      given_.size(), wavelengths_um_.size(), origin_);
}

}  // namespace umov::brdf
