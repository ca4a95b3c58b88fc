#include "host/calibrate/calibration.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::calibrate {

std::size_t Calibration::index_of(double wavelength_nm) const {
  std::string known;
  for (std::size_t w = 0; w < wavelengths.size(); ++w) {
    if (std::abs(wavelengths[w].wavelength_nm - wavelength_nm) < 0.5) return w;
    known += fmt::format("{}{:g}", w == 0 ? "" : ", ", wavelengths[w].wavelength_nm);
  }
  throw Error(
      fmt::format("the calibration has no wavelength {:g} nm, only {}", wavelength_nm, known),
      "calibrate with a white scan that has this wavelength");
}

const WavelengthCalibration& Calibration::at(double wavelength_nm) const {
  return wavelengths[index_of(wavelength_nm)];
}

double record_variance(const NoiseModel& noise, const WavelengthCalibration& entry, double gain,
                       double signal_v) {
  const double law = noise.variance_normalised(entry.wavelength_nm, gain, signal_v);
  const double more =
      entry.record_scatter * entry.record_scatter - noise.relative2_normalised(entry.wavelength_nm);
  return law + std::max(0.0, more) * signal_v * signal_v;
}

double detector_shift_deg(const Systematic& systematic, const DeclaredDoubts& declared,
                          double theta_r_deg, int direction) {
  switch (systematic.kind) {
    case Systematic::Kind::detector_zero:
      return declared.theta_r_zero_u_deg;
    case Systematic::Kind::detector_eccentricity: {
      const double angle = optics::radians(theta_r_deg);
      return declared.theta_r_eccentricity_u_deg *
             (systematic.cause == 0 ? std::cos(angle) : std::sin(angle));
    }
    case Systematic::Kind::detector_play:
      return -0.5 * declared.theta_r_play_u_deg * (direction < 0 ? -1.0 : 1.0);
    case Systematic::Kind::standard_lean:
      return -declared.sample_lean_u_deg;
    default:
      return 0;
  }
}

std::vector<Systematic> angle_systematics(const DeclaredDoubts& declared) {
  std::vector<Systematic> result;
  const auto add = [&result](double u, Systematic::Kind kind, std::size_t cause) {
    if (u > 0) result.push_back({kind, 0, cause});
  };
  add(declared.theta_r_zero_u_deg, Systematic::Kind::detector_zero, 0);
  add(declared.theta_r_eccentricity_u_deg, Systematic::Kind::detector_eccentricity, 0);
  add(declared.theta_r_eccentricity_u_deg, Systematic::Kind::detector_eccentricity, 1);
  add(declared.theta_r_play_u_deg, Systematic::Kind::detector_play, 0);
  add(declared.sample_lean_u_deg, Systematic::Kind::standard_lean, 0);
  return result;
}

std::vector<double> wavelengths_of(const formats::ScanTable& scan) {
  std::vector<double> result;
  for (double wavelength : scan.wavelength_nm)
    if (std::none_of(result.begin(), result.end(),
                     [wavelength](double known) { return std::abs(known - wavelength) < 0.5; }))
      result.push_back(wavelength);
  std::sort(result.begin(), result.end());
  return result;
}

Calibration calibration_from_header(const formats::ScanTable& scan) {
  const std::string remedy =
      "give --calibration FILE (made by `umov calibrate`), or state the key in the scan's header";
  const auto positive = [&](const std::string& name) {
    const auto value = scan.number(name);
    if (!value)
      throw Error(fmt::format("the scan has no key `{}` and no calibration is given", name),
                  remedy);
    if (!(*value > 0) || !std::isfinite(*value))
      throw Error(fmt::format("key `{}` is {:g}, which is no positive number", name, *value),
                  remedy);
    return *value;
  };
  Calibration calibration;
  calibration.solid_angle_sr = positive("solid_angle_sr");
  double relative_u = 0.01;
  if (scan.number("gain_constant_relative_u"))
    relative_u = positive("gain_constant_relative_u");
  else
    calibration.notes.push_back(
        "the scan has no key `gain_constant_relative_u`: 0.01 is taken for its gain constants");
  calibration.ranges.ranges.push_back({1.0, 0.0, 0.0, false});
  calibration.ranges.covariance = Eigen::MatrixXd::Zero(1, 1);

  const ScanRows set_up = sort_rows(scan);
  const NoiseModel noise = fit_noise(scan);
  calibration.dark = find_dark(scan, set_up, noise);
  const auto phases = find_phase(scan, set_up, noise, calibration.dark);
  for (double wavelength : wavelengths_of(scan)) {
    WavelengthCalibration entry;
    entry.wavelength_nm = wavelength;
    entry.gain_constant_v = positive(fmt::format("gain_constant_{:g}", wavelength));
    entry.covariance = Eigen::MatrixXd::Constant(1, 1, relative_u * relative_u);
    entry.instrument_function.min_deg = -90;
    entry.instrument_function.max_deg = 90;
    for (const LockinPhase& phase : phases)
      if (std::abs(phase.wavelength_nm - wavelength) < 0.5) {
        entry.phase_rad = phase.phase_rad;
        entry.phase_u_rad = phase.u_rad;
      }
    calibration.wavelengths.push_back(entry);
  }
  calibration.notes.push_back(
      "gain constants from the scan's header; the instrument function is one");
  calibration.keys.emplace_back("calibration", "header keys gain_constant_<nm>");
  return calibration;
}

}  // namespace umov::calibrate
