// BRDF tables in the file formats of other programs: one list of formats, one way in, one way out.
//
// A format is a line in the list of table_formats.cpp: its name, how its bytes are told, a reader
// and a writer. Readers keep the sampling of the file (a brdf::Table of their own where the grid of
// host/brdf does not fit), so that writing the same format again loses nothing. Writers sample any
// brdf::Table on the grid that their format wants.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/brdf/model.hpp"
#include "host/brdf/table.hpp"

namespace umov::formats {

struct BrdfTable;  // host/formats/brdf_table.hpp

using TablePtr = std::shared_ptr<const brdf::Table>;

/// What a written file says about itself in words, where its format has room for comments: the five
/// things that users of BRDF files otherwise have to guess.
struct TableHeader {
  std::string description;             ///< of the data: Table::description()
  std::string program;                 ///< "umov 0.1.0"
  std::string command;                 ///< command line; may be empty
  std::vector<double> wavelengths_um;  ///< of the values in the file, in the file's order
  bool polarised = false;              ///< the file holds Mueller elements, not only m00
  std::vector<std::string> notes;      ///< sentences: what the format cannot hold, resampling
  /// What a number in the file is. Formats that store something else than the BRDF say so here.
  std::string quantity = "BRDF in 1/sr (radiance over irradiance), not multiplied by cos theta";
  /// How the file counts azimuths.
  std::string azimuth =
      "0 is the specular direction, the side away from the source; 180 is back towards it";
  std::string solid_angle = "values stand for directions, not for averages over a solid angle";

  /// Lines without comment signs or ends: "quantity: BRDF in 1/sr, not multiplied by cos θ" and so
  /// on for azimuth, solid angle, wavelengths and polarisation, then origin and notes. ASCII only.
  std::vector<std::string> lines() const;
};

/// How to write.
struct TableWriting {
  std::vector<double> wavelengths_um;  ///< wanted in the file, ascending; empty: all of the table
  std::string program;
  std::string command;
  std::vector<std::string> notes;                           ///< go to TableHeader::notes
  std::function<void(double done, double total)> progress;  ///< may be empty
};

/// One format. Functions that a format lacks are nullptr.
struct TableFormat {
  std::string_view name;   ///< for --format and --kind: "merl"
  std::string_view title;  ///< for help texts: "MERL half-angle table, 3 channels (.binary)"
  /// Whether bytes are (meant as) this format. Looks at the start and the size only; a damaged file
  /// is still recognised and then refused by read() with its place.
  bool (*recognises)(std::string_view bytes);
  /// The whole file or umov::Error with line or byte. `name` stands in errors and descriptions.
  /// Never allocates by a size that the file only claims.
  TablePtr (*read)(std::string_view bytes, const std::string& name) = nullptr;
  /// The bytes of a file. Throws umov::Error where the table does not fit (say, more wavelengths
  /// than the format holds: single_wavelength()).
  std::string (*write)(const brdf::Table& table, const TableWriting& writing) = nullptr;
  /// For formats that list measured points in any directions: to and from the points of a brdf.h5
  /// as they are, without interpolation. `umov import` prefers `read` where there are both.
  BrdfTable (*read_points)(std::string_view bytes, const std::string& name) = nullptr;
  std::string (*write_points)(const BrdfTable& points, const TableWriting& writing) = nullptr;
  /// A file holds what a model reflects exactly in the mirror direction too: as power in a patch,
  /// or because it holds the model itself.
  bool takes_mirror = false;
};

/// All formats, in the order in which their content is tried.
std::span<const TableFormat> table_formats();
/// What a format is wanted for.
enum class FormatUse { any, reading, writing };
/// Names of those that serve: "table, merl, …".
std::string format_names(FormatUse use);
/// By name. Throws umov::Error where there is none or it does not serve, listing those that do.
const TableFormat& table_format(std::string_view name, FormatUse use = FormatUse::any);
/// By content; nullptr where no format recognises the bytes.
const TableFormat* recognised_format(std::string_view bytes);

/// A table of any kind, told by content or, where `format` is not empty, by name. Throws
/// umov::Error.
TablePtr read_table(const std::filesystem::path& path, std::string_view format = {});
/// The same from bytes; `name` stands in errors and descriptions.
TablePtr parse_table(std::string_view bytes, const std::string& name, std::string_view format = {});
/// Replaces `path` by the table in that format. Throws umov::Error; then the old file is whole.
void write_table(const std::filesystem::path& path, std::string_view format,
                 const brdf::Table& table, const TableWriting& writing);

/// The wavelengths to write: those asked for, else the table's own. Never empty.
std::vector<double> written_wavelengths(const brdf::Table& table, const TableWriting& writing);
/// The same for formats that hold one. Throws umov::Error naming --wavelength-nm where there are
/// more. `format` stands in the error.
double single_wavelength(const brdf::Table& table, const TableWriting& writing,
                         std::string_view format);
/// Header of a file written now with these wavelengths.
TableHeader table_header(const brdf::Table& table, const TableWriting& writing,
                         std::vector<double> wavelengths_um, bool polarised);

/// A model with parameters, seen as a table: what `umov export --model` and fits are written from.
/// The part that leaves exactly in the mirror direction (mirror_reflectance()) has no finite BRDF
/// and is not in it; notes() says so where there is one.
class ModelTable final : public brdf::Table {
 public:
  /// One parameter vector a wavelength (both non-empty, wavelengths ascending), or one for all;
  /// `remarks` are sentences for notes().
  /// Between wavelengths that have vectors of their own the BRDF is interpolated; a single vector
  /// serves every wavelength. Throws umov::Error as Model::check() does.
  ModelTable(brdf::Model model, std::vector<double> wavelengths_um,
             std::vector<std::vector<double>> values, std::string description,
             std::vector<std::string> remarks = {});

  optics::Mueller<double> at(double wavelength_um,
                             const brdf::Geometry<double>& geometry) const override;
  const std::vector<double>& wavelengths_um() const override { return wavelengths_um_; }
  bool polarised() const override { return true; }
  std::string description() const override { return description_; }

  const brdf::Model& model() const { return model_; }
  /// Parameters at a wavelength's position, in the model's order.
  const std::vector<double>& values(std::size_t wavelength) const {
    return values_[values_.size() == 1 ? 0 : wavelength];
  }
  /// One vector serves all wavelengths.
  bool shared() const { return values_.size() == 1; }
  /// Sentences for TableWriting::notes: the `remarks`, and where there is one the mirror part,
  /// unless the format takes it (TableFormat::takes_mirror).
  std::vector<std::string> notes(bool mirror_taken = false) const;
  bool has_mirror() const;
  /// Reflectance for unpolarised light of what leaves exactly in the mirror direction; `theta_i`
  /// in radians.
  double mirror(double wavelength_um, double theta_i) const;
  /// DHR for unpolarised light without that.
  double dhr(double wavelength_um, double theta_i) const;

 private:
  brdf::Model model_;
  std::vector<double> wavelengths_um_;
  std::vector<std::vector<double>> values_;
  std::string description_;
  std::vector<std::string> remarks_;

  /// `of(index of a parameter vector, wavelength)`, linear between vectors of their own.
  template <class Function>
  auto interpolated(double wavelength_um, Function of) const;
};

/// The model of a fit.json's bytes; `name` stands in errors. Throws umov::Error.
std::shared_ptr<const ModelTable> fitted_table(std::string_view bytes, const std::string& name);

}  // namespace umov::formats
