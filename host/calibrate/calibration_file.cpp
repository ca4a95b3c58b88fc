#include "host/calibrate/calibration_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "host/calibrate/calibration_columns.hpp"
#include "host/calibrate/polarization_columns.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/content_hash.hpp"
#include "host/formats/h5_header.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

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
  for (const DeclaredKey& key : declared_keys) {
    const std::string name = std::string("/declared/") + key.name;
    if (always_declared(key) || file.has(name))
      calibration.declared.*key.value = one_of(file, name);
  }
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
    const auto known = std::find_if(systematic_kind_names.begin(), systematic_kind_names.end(),
                                    [&](const auto& entry) { return kind[k] == entry.second; });
    if (known == systematic_kind_names.end())
      file.fail("/systematics/kind", "is unknown: " + kind[k]);
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
  const CalibrationColumns flat = calibration_columns(calibration);
  formats::check_storable(calibration.keys, path.string());
  formats::Hdf5Builder file(path.string());
  formats::write_h5_header(file, calibration_format_name, calibration.keys, provenance,
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
  formats::read_h5_header(file, calibration_format_name, calibration.keys);
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
  formats::verify_h5_content(file, checksum(calibration_columns(calibration), calibration.keys));
  return calibration;
}

}  // namespace umov::calibrate
