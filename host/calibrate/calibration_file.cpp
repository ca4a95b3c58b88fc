#include "host/calibrate/calibration_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "host/calibrate/polarization_columns.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/content_hash.hpp"
#include "host/formats/h5_header.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

constexpr const char* format_name = "umov cal h5";
constexpr const char* ranges_covariance = "/covariance/ranges";
constexpr const char* polarization_covariance = "/covariance/polarization";
constexpr const char* stray_covariance = "/covariance/stray_light";

/// A calibration as plain columns: one list for the writer, the reader and the checksum.
struct Column {
  std::vector<double> values;
  std::string unit;
};

struct Flat {
  std::map<std::string, Column> numbers;
  std::map<std::string, std::vector<std::string>> texts;

  void number(const std::string& path, double value, const std::string& unit) {
    numbers[path].values.push_back(value);
    numbers[path].unit = unit;
  }
  void text(const std::string& path, const std::string& value) { texts[path].push_back(value); }
  /// A column that may have no entry.
  void declare(const std::string& path, const std::string& unit) { numbers[path].unit = unit; }
  void declare_text(const std::string& path) { texts[path]; }
};

std::string per_wavelength(const std::string& path, const WavelengthCalibration& entry) {
  return fmt::format("{}_{:g}", path, entry.wavelength_nm);
}

/// Degrees with twelve digits: turning them to radians and back gives the same number again, so
/// that the checksum of a file read is that of the file written.
double stored_degrees(double radians) {
  return std::stod(fmt::format("{:.12g}", optics::degrees(radians)));
}

constexpr std::array<std::pair<Systematic::Kind, const char*>, 5> kind_names = {{
    {Systematic::Kind::dark, "dark"},
    {Systematic::Kind::range, "range"},
    {Systematic::Kind::nonlinearity, "nonlinearity"},
    {Systematic::Kind::stray, "stray light"},
    {Systematic::Kind::detector_zero, "detector zero"},
}};

std::string kind_name(Systematic::Kind kind) {
  for (const auto& [known, name] : kind_names)
    if (known == kind) return name;
  return {};
}

void flatten_matrix(const std::string& path, const Eigen::MatrixXd& matrix, Flat& flat) {
  for (Eigen::Index r = 0; r < matrix.rows(); ++r)
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) flat.number(path, matrix(r, c), "1");
}

/// Numbers of a reciprocity result: one list for the writer and the reader.
constexpr std::array<std::pair<const char*, double Reciprocity::*>, 10> reciprocity_columns = {{
    {"wavelength_nm", &Reciprocity::wavelength_nm},
    {"mean", &Reciprocity::mean},
    {"mean_u", &Reciprocity::mean_u},
    {"mean_absolute", &Reciprocity::mean_absolute},
    {"rms", &Reciprocity::rms},
    {"rms_expected", &Reciprocity::rms_expected},
    {"largest", &Reciprocity::largest},
    {"largest_theta_i_deg", &Reciprocity::largest_theta_i_deg},
    {"largest_theta_r_deg", &Reciprocity::largest_theta_r_deg},
    {"chi2", &Reciprocity::chi2},
}};

void flatten_reciprocity(const std::vector<Reciprocity>& results, Flat& flat) {
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

void flatten_light(const Calibration& calibration, Flat& flat) {
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
  const DeclaredDoubts& declared = calibration.declared;
  flat.number("/declared/theta_i_zero_u_deg", declared.theta_i_zero_u_deg, "deg");
  flat.number("/declared/theta_r_zero_u_deg", declared.theta_r_zero_u_deg, "deg");
  flat.number("/declared/aperture_half_angle_deg", declared.aperture_half_angle_deg, "deg");
  flat.number("/declared/solid_angle_relative_u", declared.solid_angle_relative_u, "1");
}

void flatten_wavelength(const WavelengthCalibration& entry, Flat& flat) {
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

void flatten_polarization(const PolarizationCalibration& polarization, Flat& flat) {
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

Flat flatten(const Calibration& calibration) {
  Flat flat;
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

std::string checksum(const Flat& flat, const formats::Keys& keys) {
  formats::ContentHash hash;
  hash.text(format_name);
  hash.pairs("header", keys);
  for (const auto& [path, column] : flat.numbers) hash.column(path, column.values);
  for (const auto& [path, lines] : flat.texts) {
    hash.text(path);
    for (const std::string& line : lines) hash.text(line);
  }
  return hash.hex_digest();
}

/// Columns of one group, all of one length.
class Group {
 public:
  Group(const formats::Hdf5Reader& file, std::string path) : file_(file), path_(std::move(path)) {}
  std::vector<double> numbers(const std::string& name) {
    return checked(name, file_.doubles(path_ + name));
  }
  std::vector<std::string> texts(const std::string& name) {
    return checked(name, file_.texts(path_ + name));
  }
  std::size_t size() const { return first_ ? 0 : size_; }

 private:
  template <class T>
  std::vector<T> checked(const std::string& name, std::vector<T> values) {
    if (!first_ && values.size() != size_)
      file_.fail(path_ + name, fmt::format("has {} entries, not {}", values.size(), size_));
    first_ = false;
    size_ = values.size();
    return values;
  }
  const formats::Hdf5Reader& file_;
  std::string path_;
  bool first_ = true;
  std::size_t size_ = 0;
};

void read_wavelengths(const formats::Hdf5Reader& file, Calibration& calibration) {
  Group group(file, "/wavelengths/");
  const auto wavelength = group.numbers("wavelength_nm"), gain = group.numbers("gain_constant_v"),
             reference_u = group.numbers("reference_relative_u"),
             bias = group.numbers("detector_bias"), bias_u = group.numbers("detector_bias_u"),
             active = group.numbers("detector_bias_active"),
             gain_lever = group.numbers("gain_bias_lever"), phase = group.numbers("phase_deg"),
             phase_u = group.numbers("phase_u_deg"), records = group.numbers("records"),
             rejected = group.numbers("rejected"), scatter = group.numbers("record_scatter"),
             own_scatter = group.numbers("standard_scatter"), chi2 = group.numbers("chi2"),
             dof = group.numbers("degrees_of_freedom");
  Group function(file, "/instrument_function/");
  const auto reference = function.numbers("reference_deg"), low = function.numbers("min_deg"),
             high = function.numbers("max_deg");
  if (function.size() != group.size())
    file.fail("/instrument_function", "has another number of wavelengths than /wavelengths");
  for (std::size_t w = 0; w < wavelength.size(); ++w) {
    WavelengthCalibration entry;
    entry.wavelength_nm = wavelength[w];
    entry.gain_constant_v = gain[w];
    if (!(gain[w] > 0)) file.fail("/wavelengths/gain_constant_v", "is not positive");
    entry.reference_relative_u = reference_u[w];
    entry.detector_bias = bias[w];
    entry.detector_bias_u = bias_u[w];
    entry.bias_active = active[w] != 0;
    entry.gain_bias_lever = gain_lever[w];
    entry.phase_rad = optics::radians(phase[w]);
    entry.phase_u_rad = optics::radians(phase_u[w]);
    entry.records = static_cast<std::size_t>(records[w]);
    entry.rejected = static_cast<std::size_t>(rejected[w]);
    entry.record_scatter = scatter[w];
    entry.standard_scatter = own_scatter[w];
    entry.chi2 = chi2[w];
    entry.dof = dof[w];
    entry.instrument_function.reference_deg = reference[w];
    entry.instrument_function.min_deg = low[w];
    entry.instrument_function.max_deg = high[w];
    const auto degrees = file.doubles(per_wavelength("/instrument_function/degrees", entry));
    entry.instrument_function.coefficients =
        file.doubles(per_wavelength("/instrument_function/coefficients", entry));
    if (degrees.size() != entry.instrument_function.coefficients.size())
      file.fail("/instrument_function", "has degrees and coefficients of different number");
    for (double degree : degrees)
      entry.instrument_function.degrees.push_back(static_cast<int>(std::lround(degree)));
    const std::string path = per_wavelength("/covariance/nm", entry);
    std::size_t rows = 0, columns = 0;
    const auto covariance = file.matrix(path, rows, columns);
    const auto expected = static_cast<std::size_t>(entry.parameters());
    if (rows != expected || columns != expected)
      file.fail(path, fmt::format("is {} x {}, not {} x {}", rows, columns, expected, expected));
    entry.covariance =
        Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
            covariance.data(), entry.parameters(), entry.parameters());
    const std::string shift = per_wavelength("/polarization_shift/nm", entry);
    if (file.has(shift)) {
      const auto values = file.doubles(shift);
      if (values.size() != expected * polarization_parameters)
        file.fail(shift, fmt::format("has {} entries, not {}", values.size(),
                                     expected * polarization_parameters));
      entry.polarization_shift =
          Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
              values.data(), entry.parameters(), polarization_parameters);
    }
    calibration.wavelengths.push_back(std::move(entry));
  }
}

double one_of(const formats::Hdf5Reader& file, const std::string& name) {
  const auto values = file.doubles(name);
  if (values.size() != 1) file.fail(name, "has not one entry");
  return values.front();
}

void read_light(const formats::Hdf5Reader& file, Calibration& calibration) {
  Nonlinearity& law = calibration.nonlinearity;
  law.kappa_per_v = one_of(file, "/linearity/kappa_per_v");
  law.kappa_u_per_v = one_of(file, "/linearity/kappa_u_per_v");
  law.measured = one_of(file, "/linearity/measured") != 0;
  law.strongest_v = one_of(file, "/linearity/strongest_v");
  law.records = static_cast<std::size_t>(one_of(file, "/linearity/records"));
  law.dof = one_of(file, "/linearity/degrees_of_freedom");
  const auto with_ranges = file.doubles("/covariance_with_ranges/kappa");
  law.with_ranges = Eigen::Map<const Eigen::VectorXd>(
      with_ranges.data(), static_cast<Eigen::Index>(with_ranges.size()));
  StrayLight& stray = calibration.stray;
  stray.forward_width_deg = one_of(file, "/instrument/stray_forward_width_deg");
  stray.chi2 = one_of(file, "/instrument/stray_chi2");
  stray.dof = one_of(file, "/instrument/stray_degrees_of_freedom");
  stray.records = static_cast<std::size_t>(one_of(file, "/instrument/stray_records"));
  Group group(file, "/stray_light/");
  stray.wavelength_nm = group.numbers("wavelength_nm");
  stray.even_per_sr = group.numbers("even_per_sr");
  stray.forward_per_sr = group.numbers("forward_per_sr");
  for (double measured : group.numbers("measured")) stray.measured.push_back(measured != 0 ? 1 : 0);
  if (!stray.empty()) {
    std::size_t rows = 0, columns = 0;
    const auto covariance = file.matrix(stray_covariance, rows, columns);
    const std::size_t expected = 2 * stray.wavelength_nm.size();
    if (rows != expected || columns != expected)
      file.fail(stray_covariance,
                fmt::format("is {} x {}, not {} x {}", rows, columns, expected, expected));
    const auto side = static_cast<Eigen::Index>(expected);
    stray.covariance =
        Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
            covariance.data(), side, side);
  }
  DeclaredDoubts& declared = calibration.declared;
  declared.theta_i_zero_u_deg = one_of(file, "/declared/theta_i_zero_u_deg");
  declared.theta_r_zero_u_deg = one_of(file, "/declared/theta_r_zero_u_deg");
  declared.aperture_half_angle_deg = one_of(file, "/declared/aperture_half_angle_deg");
  declared.solid_angle_relative_u = one_of(file, "/declared/solid_angle_relative_u");
}

void read_ranges(const formats::Hdf5Reader& file, Calibration& calibration) {
  Group dark(file, "/dark/");
  const auto gain = dark.numbers("gain"), x = dark.numbers("x_v"), x_u = dark.numbers("x_u_v"),
             y = dark.numbers("y_v"), y_u = dark.numbers("y_u_v"),
             records = dark.numbers("records");
  for (std::size_t k = 0; k < gain.size(); ++k)
    calibration.dark.levels.push_back(
        {gain[k], x[k], x_u[k], y[k], y_u[k], static_cast<std::size_t>(records[k])});
  Group ranges(file, "/ranges/");
  const auto range = ranges.numbers("gain"), error = ranges.numbers("error"),
             u = ranges.numbers("u"), measured = ranges.numbers("measured");
  for (std::size_t k = 0; k < range.size(); ++k)
    calibration.ranges.ranges.push_back({range[k], error[k], u[k], measured[k] != 0});
  if (!range.empty()) {
    std::size_t rows = 0, columns = 0;
    const auto covariance = file.matrix(ranges_covariance, rows, columns);
    if (rows != range.size() || columns != range.size())
      file.fail(ranges_covariance,
                fmt::format("is {} x {}, not {} x {}", rows, columns, range.size(), range.size()));
    const auto side = static_cast<Eigen::Index>(range.size());
    calibration.ranges.covariance =
        Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
            covariance.data(), side, side);
  }

  Group systematics(file, "/systematics/");
  const auto kind = systematics.texts("kind");
  const auto concerned = systematics.numbers("gain"), cause = systematics.numbers("cause");
  std::vector<std::vector<double>> shift;
  for (const WavelengthCalibration& entry : calibration.wavelengths) {
    shift.push_back(file.doubles(per_wavelength("/systematics/shift", entry)));
    if (shift.back().size() != kind.size() * static_cast<std::size_t>(entry.parameters()))
      file.fail("/systematics", "has a shift of the wrong length");
  }
  for (std::size_t k = 0; k < kind.size(); ++k) {
    Systematic systematic;
    const auto known = std::find_if(kind_names.begin(), kind_names.end(),
                                    [&](const auto& entry) { return kind[k] == entry.second; });
    if (known == kind_names.end()) file.fail("/systematics/kind", "is unknown: " + kind[k]);
    systematic.kind = known->first;
    systematic.gain = concerned[k];
    systematic.cause = static_cast<std::size_t>(cause[k]);
    if (systematic.kind == Systematic::Kind::stray &&
        systematic.cause >= 2 * calibration.stray.wavelength_nm.size())
      file.fail("/systematics/cause", "has no stray light that it belongs to");
    for (std::size_t w = 0; w < shift.size(); ++w) {
      const Eigen::Index m = calibration.wavelengths[w].parameters();
      systematic.shift.emplace_back(Eigen::Map<const Eigen::VectorXd>(
          shift[w].data() + static_cast<std::ptrdiff_t>(k) * m, m));
    }
    calibration.systematics.push_back(std::move(systematic));
  }
}

std::optional<PolarizationCalibration> read_polarization(const formats::Hdf5Reader& file) {
  if (!file.has("/polarization")) return std::nullopt;
  PolarizationCalibration polarization;
  Group group(file, "/polarization/");
  const auto records = group.numbers("records"), rejected = group.numbers("rejected");
  polarization.wavelengths.resize(group.size());
  for_each_polarization_column([&](const char* name, const char*, auto member) {
    const auto values = group.numbers(name);
    for (std::size_t w = 0; w < values.size(); ++w) polarization.wavelengths[w].*member = values[w];
  });
  for (std::size_t w = 0; w < records.size(); ++w) {
    polarization.wavelengths[w].records = static_cast<std::size_t>(records[w]);
    polarization.wavelengths[w].rejected = static_cast<std::size_t>(rejected[w]);
  }
  Group mirror(file, "/mirror/");
  const auto sample = mirror.texts("sample"), index = mirror.texts("index");
  if (mirror.size() != 1) file.fail("/mirror/sample", "has not one entry");
  polarization.mirror = sample.front();
  polarization.index = index.front();
  for_each_mirror_geometry(
      [&](const char* name, auto member) { polarization.*member = mirror.numbers(name).front(); });
  polarization.notes = file.texts("/mirror/notes");
  std::size_t rows = 0, columns = 0;
  const auto covariance = file.matrix(polarization_covariance, rows, columns);
  const std::size_t side = polarization.wavelengths.size() * polarization_parameters;
  if (rows != side || columns != side)
    file.fail(polarization_covariance,
              fmt::format("is {} x {}, not {} x {}", rows, columns, side, side));
  const auto n = static_cast<Eigen::Index>(side);
  polarization.covariance =
      Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          covariance.data(), n, n);
  return polarization;
}

}  // namespace

void write_calibration(const std::filesystem::path& path, const Calibration& calibration,
                       const formats::Provenance& provenance) {
  const Flat flat = flatten(calibration);
  formats::check_storable(calibration.keys, path.string());
  formats::Hdf5Builder file(path.string());
  formats::write_h5_header(file, format_name, calibration.keys, provenance,
                           checksum(flat, calibration.keys));
  std::set<std::string> groups;
  for (const auto& [name, column] : flat.numbers) groups.insert(name.substr(0, name.find('/', 1)));
  for (const auto& [name, lines] : flat.texts) groups.insert(name.substr(0, name.find('/', 1)));
  for (const std::string& group : groups) file.group(group);
  for (const auto& [name, column] : flat.numbers) {
    if (name.starts_with("/covariance/")) {
      const auto side = static_cast<std::size_t>(
          std::lround(std::sqrt(static_cast<double>(column.values.size()))));
      file.matrix(name, column.values, side, side, column.unit);
    } else {
      file.column(name, column.values, column.unit);
    }
  }
  for (const auto& [name, lines] : flat.texts) file.column(name, lines);
  formats::replace_file(path, file.finish());
}

Calibration read_calibration(const std::filesystem::path& path) {
  const std::string bytes = formats::read_whole_file(path);
  if (!formats::looks_like_hdf5(bytes))
    throw Error(Place{path.string()}, "is no calibration file",
                "give a file made by `umov calibrate`");
  const formats::Hdf5Reader file(bytes, path.string());
  Calibration calibration;
  formats::read_h5_header(file, format_name, calibration.keys);
  calibration.solid_angle_sr = one_of(file, "/instrument/solid_angle_sr");
  calibration.shape_amplitude = one_of(file, "/instrument/reference_shape");
  calibration.shape_u = one_of(file, "/instrument/reference_shape_u");
  calibration.retro_shadow_deg = one_of(file, "/instrument/retro_shadow_deg");
  calibration.ranges.tolerance = one_of(file, "/instrument/range_tolerance");
  read_wavelengths(file, calibration);
  read_light(file, calibration);
  read_ranges(file, calibration);
  calibration.polarization = read_polarization(file);
  Group checks(file, "/checks/");
  const auto standard = checks.texts("standard");
  const auto wavelength = checks.numbers("wavelength_nm"), stated = checks.numbers("stated"),
             computed = checks.numbers("computed"), computed_u = checks.numbers("computed_u"),
             used = checks.numbers("used_for_gain");
  for (std::size_t k = 0; k < standard.size(); ++k)
    calibration.checks.push_back(
        {standard[k], wavelength[k], stated[k], computed[k], computed_u[k], used[k] != 0});
  Group reciprocity(file, "/reciprocity/");
  for (const std::string& sample : reciprocity.texts("sample"))
    calibration.reciprocity.push_back({.sample = sample});
  const auto pairs = reciprocity.numbers("pairs");
  for (std::size_t k = 0; k < pairs.size(); ++k)
    calibration.reciprocity[k].pairs = static_cast<std::size_t>(pairs[k]);
  for (const auto& [column, member] : reciprocity_columns) {
    const auto values = reciprocity.numbers(column);
    for (std::size_t k = 0; k < values.size(); ++k) calibration.reciprocity[k].*member = values[k];
  }
  Group inputs(file, "/inputs/");
  const auto name = inputs.texts("name"), role = inputs.texts("role"),
             sha256 = inputs.texts("sha256");
  for (std::size_t k = 0; k < name.size(); ++k)
    calibration.inputs.push_back({name[k], role[k], sha256[k]});
  calibration.notes = file.texts("/notes/text");
  formats::verify_h5_content(file, checksum(flatten(calibration), calibration.keys));
  return calibration;
}

}  // namespace umov::calibrate
