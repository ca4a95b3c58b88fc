#include "host/calibrate/polarization.hpp"

#include <algorithm>
#include <cmath>

#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

struct Axis {
  double q, u;
};

Axis axis_of(double angle_deg) {
  const double twice = 2.0 * optics::radians(angle_deg);
  return {-std::cos(twice), std::sin(twice)};
}

bool is_open_axis(double axis_deg) {
  return formats::is_open(axis_deg);
}

double get(const PolarizationVector& v, PolarizationParameter p) {
  return v(index_of(p));
}

}  // namespace

std::string name_of(PolarizationParameter p) {
  static const std::array<const char*, polarization_parameters> names = {
      "polarizer axis",        "analyzer axis",         "polarizer extinction",
      "analyzer extinction",   "detector bias",         "monitor bias",
      "source polarization Q", "source polarization U", "polarizer leak coherence"};
  return names[static_cast<std::size_t>(p)];
}

PolarizationVector PolarizationWavelength::values() const {
  PolarizationVector v;
  v << polarizer_axis_deg, analyzer_axis_deg, polarizer_extinction, analyzer_extinction,
      detector_bias, monitor_bias, source_q, source_u, leak_coherence;
  return v;
}

void PolarizationWavelength::set_values(const PolarizationVector& v) {
  polarizer_axis_deg = v(0);
  analyzer_axis_deg = v(1);
  polarizer_extinction = v(2);
  analyzer_extinction = v(3);
  detector_bias = v(4);
  monitor_bias = v(5);
  source_q = v(6);
  source_u = v(7);
  leak_coherence = v(8);
}

const PolarizationWavelength* PolarizationCalibration::find(double wavelength_nm) const {
  for (const PolarizationWavelength& entry : wavelengths)
    if (std::abs(entry.wavelength_nm - wavelength_nm) < 0.5) return &entry;
  return nullptr;
}

PolarizationMatrix PolarizationCalibration::block(std::size_t w) const {
  const auto at = static_cast<Eigen::Index>(w) * polarization_parameters;
  return covariance.block(at, at, polarization_parameters, polarization_parameters);
}

void PolarizationCalibration::set_uncertainties() {
  for (std::size_t w = 0; w < wavelengths.size(); ++w) {
    PolarizationWavelength& entry = wavelengths[w];
    const PolarizationVector u = block(w).diagonal().cwiseMax(0.0).cwiseSqrt();
    entry.polarizer_axis_u_deg = u(0);
    entry.analyzer_axis_u_deg = u(1);
    entry.polarizer_extinction_u = u(2);
    entry.analyzer_extinction_u = u(3);
    entry.detector_bias_u = u(4);
    entry.monitor_bias_u = u(5);
    entry.source_q_u = u(6);
    entry.source_u_u = u(7);
    entry.leak_coherence_u = u(8);
  }
}

Eigen::Vector3d source_vector(const PolarizationVector& parameters, double axis_deg) {
  using enum PolarizationParameter;
  const double q = get(parameters, source_q), u = get(parameters, source_u);
  Eigen::Vector3d beam(1.0, q, u);
  if (!is_open_axis(axis_deg)) {
    const double e = get(parameters, polarizer_extinction);
    const Axis n = axis_of(axis_deg + get(parameters, polarizer_axis_deg));
    const double along = n.q * q + n.u * u;
    const double mean = 0.5 * (1.0 + e), half_difference = 0.5 * (1.0 - e);
    const double kept = half_difference + mean * along;
    const double across = get(parameters, leak_coherence) * std::sqrt(std::max(e, 0.0));
    beam << mean + half_difference * along, kept * n.q + across * (q - along * n.q),
        kept * n.u + across * (u - along * n.u);
  }
  return beam / (beam(0) + get(parameters, monitor_bias) * beam(1));
}

Eigen::Vector3d analyzer_vector(const PolarizationVector& parameters, double axis_deg) {
  using enum PolarizationParameter;
  const double bias = get(parameters, detector_bias);
  if (is_open_axis(axis_deg)) return {1.0, bias, 0.0};
  const double e = get(parameters, analyzer_extinction);
  const Axis n = axis_of(axis_deg + get(parameters, analyzer_axis_deg));
  const double mean = 0.5 * (1.0 + e), half_difference = 0.5 * (1.0 - e);
  const double cross = std::sqrt(std::max(e, 0.0));
  return {mean + half_difference * bias * n.q,
          half_difference * n.q + bias * (mean * n.q * n.q + cross * n.u * n.u),
          half_difference * n.u + bias * (mean - cross) * n.q * n.u};
}

Eigen::Vector3d ideal_source_vector(double axis_deg) {
  if (is_open_axis(axis_deg)) return {1.0, 0.0, 0.0};
  const Axis n = axis_of(axis_deg);
  return {1.0, n.q, n.u};
}

Eigen::Vector3d ideal_analyzer_vector(double axis_deg) {
  if (is_open_axis(axis_deg)) return {1.0, 0.0, 0.0};
  return 0.5 * ideal_source_vector(axis_deg);
}

}  // namespace umov::calibrate
