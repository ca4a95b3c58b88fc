#include "host/formats/astm_points.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/optics/angles.hpp"

namespace umov::formats::astm {
namespace {

constexpr double assumed_relative_u = 0.05;
constexpr double not_stated = -1;  ///< stands for an uncertainty until one is assumed

}  // namespace

void add_point(BrdfTable::Points& out, const RawPoint& p, double degrees,
               std::optional<double> relative_u, const std::string& file) {
  const auto refuse = [&](const char* column, const std::string& problem) {
    throw Error(Place{file, p.line, column}, problem, "angles follow the header's ANGLE_UNITS");
  };
  // Six decimals of a radian are what such files have.
  const auto tidy = [&](double angle) {
    return degrees == 1 ? angle : std::round(angle * degrees * 1e3) / 1e3;
  };
  const double theta_i = tidy(p.theta_i);
  double theta_s = tidy(p.theta_s);
  if (!(theta_i >= 0 && theta_i < 90))
    refuse("THETA_I", decimal_text(theta_i) + " deg is out of range");
  if (!(std::abs(theta_s) <= 90)) refuse("THETA_S", decimal_text(theta_s) + " deg is out of range");
  const double phi_s = tidy(p.phi_s), phi_i = tidy(p.phi_i);
  if (!(std::abs(phi_s) <= 360)) refuse("PHI_S", decimal_text(phi_s) + " deg is out of range");
  if (!(std::abs(phi_i) <= 360)) refuse("PHI_I", decimal_text(phi_i) + " deg is out of range");
  // The two offsets first: where they cancel, phi_s keeps all its digits.
  const double forward = std::remainder(phi_i + p.specular_azimuth_deg, 360);
  double phi = std::remainder(phi_s - forward, 360);
  if (std::abs(std::abs(phi) - 180) < 1e-9) {
    theta_s = -theta_s;
    phi = 0;
  }
  if (theta_s < 0 && phi != 0) refuse("THETA_S", "is negative out of the plane of incidence");
  double scale = 1;
  if (p.times_cosine) {
    scale = 1 / std::cos(optics::radians(theta_s));
    if (!(scale < 1e6))
      refuse("THETA_S", "a cosine-corrected value at the horizon says nothing of the BRDF");
  }
  out.theta_i_deg.push_back(theta_i + 0.0);
  out.theta_r_deg.push_back(theta_s + 0.0);
  out.phi_r_deg.push_back(phi + 0.0);
  out.wavelength_nm.push_back(p.wavelength_nm);
  out.polarizer_deg.push_back(p.polarizer_deg);
  out.analyzer_deg.push_back(p.analyzer_deg);
  out.brdf_per_sr.push_back(p.value * scale);
  const bool stated = p.uncertainty || relative_u;
  const double u = p.uncertainty ? *p.uncertainty * scale
                   : relative_u  ? std::abs(p.value) * scale * *relative_u
                                 : not_stated;
  out.brdf_u.push_back(u);
  // A value without any uncertainty cannot be weighed against others.
  out.used.push_back(stated && u == 0 ? 0 : p.used);
}

void assume_uncertainties(BrdfTable::Points& points) {
  struct Scale {
    double noise = 0, smallest = 0;
  };
  std::map<double, Scale> scales;
  for (std::size_t n = 0; n < points.size(); ++n) {
    const double value = points.brdf_per_sr[n];
    Scale& scale = scales[points.wavelength_nm[n]];
    scale.noise = std::max(scale.noise, -value);
    if (value > 0 && (scale.smallest == 0 || value < scale.smallest)) scale.smallest = value;
  }
  for (std::size_t n = 0; n < points.size(); ++n) {
    if (points.brdf_u[n] != not_stated) continue;
    const double value = points.brdf_per_sr[n];
    const Scale& scale = scales[points.wavelength_nm[n]];
    const double floor = value == 0 && scale.noise == 0 ? scale.smallest : scale.noise;
    points.brdf_u[n] = std::hypot(assumed_relative_u * value, floor);
    if (points.brdf_u[n] == 0) points.used[n] = 0;
  }
}

}  // namespace umov::formats::astm
