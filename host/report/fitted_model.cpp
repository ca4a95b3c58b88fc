#include "host/report/fitted_model.hpp"

#include <cmath>
#include <limits>

#include "host/brdf/evaluate.hpp"
#include "host/formats/mueller_table.hpp"
#include "host/formats/scan_table.hpp"
#include "host/optics/angles.hpp"

namespace umov::report {

namespace {

constexpr double p_axis = 0.0;
constexpr double s_axis = 90.0;

MuellerRows rows(const optics::Mueller<double>& m) {
  MuellerRows out{};
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      out[static_cast<std::size_t>(4 * row + column)] = optics::element(m, row, column);
  return out;
}

}  // namespace

FittedModel::FittedModel(const formats::FitResult& fit, double solid_angle_sr)
    : model_(brdf::Model::by_name(fit.model)), solid_angle_sr_(solid_angle_sr) {
  for (std::size_t i = 0; i < fit.wavelengths_nm.size(); ++i) {
    wavelengths_um_.push_back(fit.wavelengths_nm[i] * 1e-3);
    values_.push_back(fit.values_at(i));
    model_.check(values_.back());
  }
}

MuellerRows FittedModel::mueller(std::size_t wavelength, double theta_i_deg, double theta_r_deg,
                                 double phi_r_deg) const {
  using optics::radians;
  const brdf::Geometry<double> geometry{radians(theta_i_deg), radians(theta_r_deg),
                                        radians(phi_r_deg)};
  const std::span<const double> values(values_[wavelength]);
  MuellerRows out =
      rows(brdf::evaluate<double, double>(model_, values, wavelengths_um_[wavelength], geometry));
  if (solid_angle_sr_ <= 0) return out;
  // The detector takes in a cap around its direction; 2π(1 − cos a) is the solid angle of one.
  const double towards_mirror =
      std::sin(geometry.theta_i) * std::sin(geometry.theta_r) * std::cos(geometry.phi_r) +
      std::cos(geometry.theta_i) * std::cos(geometry.theta_r);
  if (1 - towards_mirror <= solid_angle_sr_ / (2 * optics::pi)) {
    const MuellerRows mirror = rows(brdf::mirror_reflectance<double, double>(
        model_, values, wavelengths_um_[wavelength], geometry.theta_i));
    const double per_sr = 1 / (std::cos(geometry.theta_r) * solid_angle_sr_);
    for (std::size_t k = 0; k < out.size(); ++k) out[k] += per_sr * mirror[k];
  }
  return out;
}

double FittedModel::mirror_reflectance(std::size_t wavelength, double theta_i_deg) const {
  return optics::element(brdf::mirror_reflectance<double, double>(
                             model_, std::span<const double>(values_[wavelength]),
                             wavelengths_um_[wavelength], optics::radians(theta_i_deg)),
                         0, 0);
}

double contracted(const MuellerRows& mueller, double polarizer_deg, double analyzer_deg) {
  return formats::contract(mueller, {polarizer_deg, analyzer_deg});
}

double dolp_p4(const MuellerRows& mueller) {
  const double total = contracted(mueller, p_axis, formats::open_axis);
  if (!(total > 0)) return std::numeric_limits<double>::quiet_NaN();
  return (contracted(mueller, p_axis, p_axis) - contracted(mueller, p_axis, s_axis)) / total;
}

double linear_polarisation(const MuellerRows& mueller) {
  // P-polarised light in: Stokes (1, −1, 0, 0).
  const auto out = [&](std::size_t row) { return mueller[4 * row] - mueller[4 * row + 1]; };
  if (!(out(0) > 0)) return std::numeric_limits<double>::quiet_NaN();
  return std::hypot(out(1), out(2)) / out(0);
}

}  // namespace umov::report
