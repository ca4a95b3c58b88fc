#include "host/formats/table_file.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/fit_file.hpp"

namespace umov::formats {
namespace {

bool serves(const TableFormat& format, FormatUse use) {
  return use == FormatUse::any || (use == FormatUse::reading && format.read != nullptr) ||
         (use == FormatUse::writing && format.write != nullptr);
}

std::string in_nm(const std::vector<double>& wavelengths_um) {
  std::vector<std::string> texts;
  for (const double um : wavelengths_um) texts.push_back(fmt::format("{:.6g}", um * 1e3));
  return fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace

std::vector<std::string> TableHeader::lines() const {
  std::vector<std::string> lines = {
      "quantity: " + quantity,
      "azimuth: " + azimuth,
      "solid angle: " + solid_angle,
      "wavelength: " + in_nm(wavelengths_um) + " nm, in vacuum",
      polarised
          ? "polarisation: Mueller matrix, row outgoing, column incoming, Stokes I Q U V; Q > 0 is "
            "s "
            "(perpendicular to the plane of the beam and the normal), U > 0 is s + p"
          : "polarisation: unpolarised light in, detector blind to polarisation (Mueller m00)",
      "surface: isotropic; the incident azimuth does not matter"};
  if (!description.empty()) lines.push_back("origin: " + description);
  if (!program.empty()) lines.push_back("program: " + program);
  if (!command.empty()) lines.push_back("command: " + command);
  for (const std::string& note : notes) lines.push_back("note: " + note);
  for (std::string& line : lines)
    for (char& c : line)
      if (c < ' ' || c > '~') c = '?';
  return lines;
}

std::string format_names(FormatUse use) {
  std::vector<std::string_view> names;
  for (const TableFormat& format : table_formats())
    if (serves(format, use)) names.push_back(format.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

const TableFormat& table_format(std::string_view name, FormatUse use) {
  for (const TableFormat& format : table_formats()) {
    if (format.name != name) continue;
    if (serves(format, use)) return format;
    throw Error(fmt::format("{} files are not {} tables", name,
                            use == FormatUse::reading ? "read as" : "written from"),
                "formats that are: " + format_names(use));
  }
  throw Error(fmt::format("there is no table format '{}'", name), "formats: " + format_names(use));
}

const TableFormat* recognised_format(std::string_view bytes) {
  for (const TableFormat& format : table_formats())
    if (format.recognises != nullptr && format.recognises(bytes)) return &format;
  return nullptr;
}

TablePtr read_table(const std::filesystem::path& path, std::string_view format) {
  return parse_table(read_whole_file(path), path.string(), format);
}

TablePtr parse_table(std::string_view bytes, const std::string& name, std::string_view format) {
  const TableFormat* chosen =
      format.empty() ? recognised_format(bytes) : &table_format(format, FormatUse::reading);
  const std::string read = format_names(FormatUse::reading);
  if (chosen == nullptr)
    throw Error(Place{name}, "is no table of a known format", "formats that are read: " + read);
  if (chosen->read == nullptr)
    throw Error(Place{name}, fmt::format("{} files hold points, not a table", chosen->name),
                "umov import makes a brdf.h5 of them; tables are " + read);
  return chosen->read(bytes, name);
}

void write_table(const std::filesystem::path& path, std::string_view format,
                 const brdf::Table& table, const TableWriting& writing) {
  replace_file(path, table_format(format, FormatUse::writing).write(table, writing));
}

std::vector<double> written_wavelengths(const brdf::Table& table, const TableWriting& writing) {
  return writing.wavelengths_um.empty() ? table.wavelengths_um() : writing.wavelengths_um;
}

double single_wavelength(const brdf::Table& table, const TableWriting& writing,
                         std::string_view format) {
  const std::vector<double> wavelengths = written_wavelengths(table, writing);
  if (wavelengths.size() == 1) return wavelengths.front();
  throw Error(
      fmt::format("a {} file holds one wavelength, there are {}", format, wavelengths.size()),
      "choose one with --wavelength-nm: " + in_nm(wavelengths));
}

TableHeader table_header(const brdf::Table& table, const TableWriting& writing,
                         std::vector<double> wavelengths_um, bool polarised) {
  TableHeader header;
  header.description = table.description();
  header.program = writing.program;
  header.command = writing.command;
  header.wavelengths_um = std::move(wavelengths_um);
  header.polarised = polarised;
  header.notes = writing.notes;
  return header;
}

ModelTable::ModelTable(brdf::Model model, std::vector<double> wavelengths_um,
                       std::vector<std::vector<double>> values, std::string description,
                       std::vector<std::string> remarks)
    : model_(std::move(model)),
      wavelengths_um_(std::move(wavelengths_um)),
      values_(std::move(values)),
      description_(std::move(description)),
      remarks_(std::move(remarks)) {
  if (wavelengths_um_.empty() || values_.empty() ||
      (values_.size() != 1 && values_.size() != wavelengths_um_.size()))
    throw Error("a model needs one set of parameters, or one a wavelength",
                "give the parameters at every wavelength");
  if (!std::is_sorted(wavelengths_um_.begin(), wavelengths_um_.end(), std::less_equal<>()))
    throw Error("wavelengths do not ascend", "give each wavelength once, in ascending order");
  for (const std::vector<double>& one : values_) model_.check(one);
}

template <class Function>
auto ModelTable::interpolated(double wavelength_um, Function of) const {
  if (shared()) return of(0, wavelength_um);
  const auto above =
      std::lower_bound(wavelengths_um_.begin(), wavelengths_um_.end(), wavelength_um);
  if (above == wavelengths_um_.end()) return of(values_.size() - 1, wavelengths_um_.back());
  const auto upper = static_cast<std::size_t>(above - wavelengths_um_.begin());
  if (upper == 0 || *above == wavelength_um) return of(upper, *above);
  const double below = wavelengths_um_[upper - 1];
  const double share = (wavelength_um - below) / (*above - below);
  return of(upper - 1, below) * (1.0 - share) + of(upper, *above) * share;
}

optics::Mueller<double> ModelTable::at(double wavelength_um,
                                       const brdf::Geometry<double>& geometry) const {
  return interpolated(wavelength_um, [&](std::size_t index, double um) {
    return brdf::evaluate<double>(model_, std::span<const double>(values(index)), um, geometry);
  });
}

double ModelTable::mirror(double wavelength_um, double theta_i) const {
  return interpolated(wavelength_um, [&](std::size_t index, double um) {
    return brdf::mirror_dhr(model_, values(index), um, theta_i).unpolarized;
  });
}

double ModelTable::dhr(double wavelength_um, double theta_i) const {
  return interpolated(wavelength_um, [&](std::size_t index, double um) {
    return brdf::dhr(model_, values(index), um, theta_i).unpolarized;
  });
}

bool ModelTable::has_mirror() const {
  return std::any_of(wavelengths_um_.begin(), wavelengths_um_.end(),
                     [&](double um) { return mirror(um, 0.0) > 0.0; });
}

std::vector<std::string> ModelTable::notes(bool mirror_taken) const {
  std::vector<std::string> notes = remarks_;
  if (mirror_taken || !has_mirror()) return notes;
  double most = 0.0;
  for (const double um : wavelengths_um_) most = std::max(most, mirror(um, 0.0));
  notes.push_back(
      fmt::format("the share that leaves exactly in the mirror direction (reflectance {:.4g} at "
                  "normal incidence) has no finite BRDF and is not in the table",
                  most));
  return notes;
}

std::shared_ptr<const ModelTable> fitted_table(std::string_view bytes, const std::string& name) {
  const FitResult fit = fit_from_json(std::string(bytes), name);
  std::vector<std::size_t> order(fit.wavelengths_nm.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return fit.wavelengths_nm[a] < fit.wavelengths_nm[b];
  });
  std::vector<double> wavelengths_um;
  std::vector<std::vector<double>> values;
  for (const std::size_t i : order) {
    wavelengths_um.push_back(fit.wavelengths_nm[i] * 1e-3);
    values.push_back(fit.values_at(i));
  }
  // One vector would serve every wavelength; a fit at one wavelength says nothing about others.
  return std::make_shared<ModelTable>(
      brdf::Model::by_name(fit.model), std::move(wavelengths_um), std::move(values),
      fmt::format("model {} fitted to {} ({})", fit.model, fit.data_file, name));
}

}  // namespace umov::formats
