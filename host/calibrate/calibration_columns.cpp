#include "host/calibrate/calibration_columns.hpp"

#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "host/calibrate/polarization_columns.hpp"
#include "host/formats/content_hash.hpp"
#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

/// Degrees with twelve digits: turning them to radians and back gives the same number again, so
/// that the checksum of a file read is that of the file written.
double stored_degrees(double radians) {
  return std::stod(fmt::format("{:.12g}", optics::degrees(radians)));
}

std::string kind_name(Systematic::Kind kind) {
  for (const auto& [known, name] : systematic_kind_names)
    if (known == kind) return name;
  return {};
}

void flatten_matrix(const std::string& path, const Eigen::MatrixXd& matrix,
                    CalibrationColumns& flat) {
  for (Eigen::Index r = 0; r < matrix.rows(); ++r)
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) flat.number(path, matrix(r, c), "1");
}

void flatten_reciprocity(const std::vector<Reciprocity>& results, CalibrationColumns& flat) {
  const std::string group = "/reciprocity/";
  flat.declare_text(group + "sample");
  flat.declare(group + "pairs", "1");
  for (const auto& [name, member] : reciprocity_columns) flat.declare(group + name, "1");
  for (const Reciprocity& result : results) {
    flat.text(group + "sample", result.sample);
    flat.number(group + "pairs", static_cast<double>(result.pairs), "1");
    for (const auto& [name, member] : reciprocity_columns)
      flat.number(group + name, result.*member, "1");
  }
}

void flatten_light(const Calibration& calibration, CalibrationColumns& flat) {
  const Nonlinearity& law = calibration.nonlinearity;
  const std::string linearity = "/linearity/";
  flat.number(linearity + "kappa_per_v", law.kappa_per_v, "1/V");
  flat.number(linearity + "kappa_u_per_v", law.kappa_u_per_v, "1/V");
  flat.number(linearity + "measured", law.measured ? 1 : 0, "1");
  flat.number(linearity + "strongest_v", law.strongest_v, "V");
  flat.number(linearity + "records", static_cast<double>(law.records), "1");
  flat.number(linearity + "degrees_of_freedom", law.dof, "1");
  flat.declare("/covariance_with_ranges/kappa", "1/V");
  for (double value : law.with_ranges) flat.number("/covariance_with_ranges/kappa", value, "1/V");
  const StrayLight& stray = calibration.stray;
  const std::string group = "/stray_light/";
  flat.number("/instrument/stray_forward_width_deg", stray.forward_width_deg, "deg");
  flat.number("/instrument/stray_chi2", stray.chi2, "1");
  flat.number("/instrument/stray_degrees_of_freedom", stray.dof, "1");
  flat.number("/instrument/stray_records", static_cast<double>(stray.records), "1");
  flat.declare(group + "wavelength_nm", "nm");
  flat.declare(group + "even_per_sr", "1/sr");
  flat.declare(group + "forward_per_sr", "1/sr");
  flat.declare(group + "measured", "1");
  for (std::size_t w = 0; w < stray.wavelength_nm.size(); ++w) {
    flat.number(group + "wavelength_nm", stray.wavelength_nm[w], "nm");
    flat.number(group + "even_per_sr", stray.even_per_sr[w], "1/sr");
    flat.number(group + "forward_per_sr", stray.forward_per_sr[w], "1/sr");
    flat.number(group + "measured", stray.measured[w], "1");
  }
  flatten_matrix(stray_covariance, stray.covariance, flat);
  for (const DeclaredKey& key : declared_keys) {
    const double value = calibration.declared.*key.value;
    if (always_declared(key) || value > 0)
      flat.number(std::string("/declared/") + key.name, value, key.unit);
  }
}

void flatten_wavelength(const WavelengthCalibration& entry, CalibrationColumns& flat) {
  const std::string base = "/wavelengths/";
  flat.number(base + "wavelength_nm", entry.wavelength_nm, "nm");
  flat.number(base + "gain_constant_v", entry.gain_constant_v, "V");
  flat.number(base + "gain_constant_relative_u", std::sqrt(entry.covariance(0, 0)), "1");
  flat.number(base + "reference_relative_u", entry.reference_relative_u, "1");
  flat.number(base + "detector_bias", entry.detector_bias, "1");
  flat.number(base + "detector_bias_u", entry.detector_bias_u, "1");
  flat.number(base + "detector_bias_active", entry.bias_active ? 1 : 0, "1");
  flat.number(base + "gain_bias_lever", entry.gain_bias_lever, "1");
  flat.number(base + "phase_deg", stored_degrees(entry.phase_rad), "deg");
  flat.number(base + "phase_u_deg", stored_degrees(entry.phase_u_rad), "deg");
  flat.number(base + "records", static_cast<double>(entry.records), "1");
  flat.number(base + "rejected", static_cast<double>(entry.rejected), "1");
  flat.number(base + "record_scatter", entry.record_scatter, "1");
  flat.number(base + "standard_scatter", entry.standard_scatter, "1");
  flat.number(base + "chi2", entry.chi2, "1");
  flat.number(base + "degrees_of_freedom", entry.dof, "1");
  const InstrumentFunction& f = entry.instrument_function;
  const std::string group = "/instrument_function/";
  flat.number(group + "reference_deg", f.reference_deg, "deg");
  flat.number(group + "min_deg", f.min_deg, "deg");
  flat.number(group + "max_deg", f.max_deg, "deg");
  const std::string degrees = per_wavelength(group + "degrees", entry);
  const std::string coefficients = per_wavelength(group + "coefficients", entry);
  flat.declare(degrees, "1");
  flat.declare(coefficients, "1");
  for (std::size_t k = 0; k < f.degrees.size(); ++k) {
    flat.number(degrees, f.degrees[k], "1");
    flat.number(coefficients, f.coefficients[k], "1");
  }
  for (Eigen::Index r = 0; r < entry.polarization_shift.rows(); ++r)
    for (Eigen::Index c = 0; c < entry.polarization_shift.cols(); ++c)
      flat.number(per_wavelength("/polarization_shift/nm", entry), entry.polarization_shift(r, c),
                  "1");
  const std::string covariance = per_wavelength("/covariance/nm", entry);
  for (Eigen::Index r = 0; r < entry.covariance.rows(); ++r)
    for (Eigen::Index c = 0; c < entry.covariance.cols(); ++c)
      flat.number(covariance, entry.covariance(r, c), "1");
}

void flatten_polarization(const PolarizationCalibration& polarization, CalibrationColumns& flat) {
  const std::string base = "/polarization/";
  for (const PolarizationWavelength& entry : polarization.wavelengths) {
    for_each_polarization_column([&](const char* name, const char* unit, auto member) {
      flat.number(base + name, entry.*member, unit);
    });
    flat.number(base + "records", static_cast<double>(entry.records), "1");
    flat.number(base + "rejected", static_cast<double>(entry.rejected), "1");
  }
  for_each_mirror_geometry([&](const char* name, auto member) {
    flat.number(std::string("/mirror/") + name, polarization.*member, "deg");
  });
  flat.text("/mirror/sample", polarization.mirror);
  flat.text("/mirror/index", polarization.index);
  flat.declare_text("/mirror/notes");
  for (const std::string& note : polarization.notes) flat.text("/mirror/notes", note);
  for (Eigen::Index r = 0; r < polarization.covariance.rows(); ++r)
    for (Eigen::Index c = 0; c < polarization.covariance.cols(); ++c)
      flat.number(polarization_covariance, polarization.covariance(r, c), "1");
}

}  // namespace

std::string per_wavelength(const std::string& path, const WavelengthCalibration& entry) {
  return fmt::format("{}_{:g}", path, entry.wavelength_nm);
}

bool always_declared(const DeclaredKey& key) {
  const std::string_view name = key.name;
  return name == "theta_i_zero_u_deg" || name == "theta_r_zero_u_deg" ||
         name == "aperture_half_angle_deg" || name == "solid_angle_relative_u";
}

CalibrationColumns calibration_columns(const Calibration& calibration) {
  CalibrationColumns flat;
  if (calibration.polarization) flatten_polarization(*calibration.polarization, flat);
  flat.number("/instrument/solid_angle_sr", calibration.solid_angle_sr, "sr");
  flat.number("/instrument/reference_shape", calibration.shape_amplitude, "1");
  flat.number("/instrument/reference_shape_u", calibration.shape_u, "1");
  flat.number("/instrument/retro_shadow_deg", calibration.retro_shadow_deg, "deg");
  flat.number("/instrument/range_tolerance", calibration.ranges.tolerance, "1");
  for (const char* name : {"gain", "records"}) flat.declare(fmt::format("/dark/{}", name), "1");
  for (const char* name : {"x_v", "x_u_v", "y_v", "y_u_v"})
    flat.declare(fmt::format("/dark/{}", name), "V");
  for (const DarkLevel& level : calibration.dark.levels) {
    flat.number("/dark/gain", level.gain, "1");
    flat.number("/dark/x_v", level.x_v, "V");
    flat.number("/dark/x_u_v", level.x_u, "V");
    flat.number("/dark/y_v", level.y_v, "V");
    flat.number("/dark/y_u_v", level.y_u, "V");
    flat.number("/dark/records", static_cast<double>(level.records), "1");
  }
  for (const char* name : {"gain", "error", "u", "measured"})
    flat.declare(fmt::format("/ranges/{}", name), "1");
  for (const RangeError& range : calibration.ranges.ranges) {
    flat.number("/ranges/gain", range.gain, "1");
    flat.number("/ranges/error", range.error, "1");
    flat.number("/ranges/u", range.u, "1");
    flat.number("/ranges/measured", range.measured ? 1 : 0, "1");
  }
  const Eigen::MatrixXd& between_ranges = calibration.ranges.covariance;
  for (Eigen::Index r = 0; r < between_ranges.rows(); ++r)
    for (Eigen::Index c = 0; c < between_ranges.cols(); ++c)
      flat.number(ranges_covariance, between_ranges(r, c), "1");
  flatten_light(calibration, flat);
  flat.declare_text("/systematics/kind");
  flat.declare("/systematics/gain", "1");
  flat.declare("/systematics/cause", "1");
  for (const WavelengthCalibration& entry : calibration.wavelengths) {
    flatten_wavelength(entry, flat);
    flat.declare(per_wavelength("/systematics/shift", entry), "1");
  }
  for (const Systematic& systematic : calibration.systematics) {
    flat.text("/systematics/kind", kind_name(systematic.kind));
    flat.number("/systematics/gain", systematic.gain, "1");
    flat.number("/systematics/cause", static_cast<double>(systematic.cause), "1");
    for (std::size_t w = 0; w < calibration.wavelengths.size(); ++w)
      for (Eigen::Index k = 0; k < systematic.shift[w].size(); ++k)
        flat.number(per_wavelength("/systematics/shift", calibration.wavelengths[w]),
                    systematic.shift[w](k), "1");
  }
  flat.declare_text("/checks/standard");
  for (const char* name : {"wavelength_nm", "stated", "computed", "computed_u", "used_for_gain"})
    flat.declare(fmt::format("/checks/{}", name), "1");
  for (const StandardCheck& check : calibration.checks) {
    flat.text("/checks/standard", check.standard);
    flat.number("/checks/wavelength_nm", check.wavelength_nm, "nm");
    flat.number("/checks/stated", check.stated, "1");
    flat.number("/checks/computed", check.computed, "1");
    flat.number("/checks/computed_u", check.computed_u, "1");
    flat.number("/checks/used_for_gain", check.used_for_gain ? 1 : 0, "1");
  }
  flatten_reciprocity(calibration.reciprocity, flat);
  for (const char* name : {"name", "role", "sha256"})
    flat.declare_text(fmt::format("/inputs/{}", name));
  for (const CalibrationInput& input : calibration.inputs) {
    flat.text("/inputs/name", input.name);
    flat.text("/inputs/role", input.role);
    flat.text("/inputs/sha256", input.sha256);
  }
  flat.declare_text("/notes/text");
  for (const std::string& note : calibration.notes) flat.text("/notes/text", note);
  return flat;
}

std::string checksum(const CalibrationColumns& flat, const formats::Keys& keys) {
  formats::ContentHash hash;
  hash.text(calibration_format_name);
  hash.pairs("header", keys);
  for (const auto& [path, column] : flat.numbers) hash.column(path, column.values);
  for (const auto& [path, lines] : flat.texts) {
    hash.text(path);
    for (const std::string& line : lines) hash.text(line);
  }
  return hash.hex_digest();
}

}  // namespace umov::calibrate
