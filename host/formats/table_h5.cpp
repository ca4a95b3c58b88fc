#include "host/formats/table_h5.hpp"

#include <array>
#include <memory>

#include <fmt/format.h>

#include "host/brdf/grid_table.hpp"
#include "host/brdf/planes_table.hpp"
#include "host/errors/error.hpp"
#include "host/formats/content_hash.hpp"
#include "host/formats/dense_grid.hpp"
#include "host/formats/half_angle_table.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/formats/rgl_table.hpp"
#include "host/formats/specular_table.hpp"

namespace umov::formats {
namespace {

constexpr const char* format_name = "umov table h5";

/// What a table file holds besides its header: named arrays, in order. Both the HDF5 image and the
/// checksum are made from it.
struct Arrays {
  struct One {
    std::string path;
    std::vector<std::size_t> shape;
    std::vector<double> values;
    std::string unit;
  };
  std::string layout;
  std::string origin;
  std::vector<One> all;

  void add(std::string path, std::vector<double> values, std::string unit) {
    const std::size_t size = values.size();
    all.push_back({std::move(path), {size}, std::move(values), std::move(unit)});
  }
  void add(std::string path, std::vector<std::size_t> shape, std::span<const double> values,
           std::string unit) {
    all.push_back(
        {std::move(path), std::move(shape), {values.begin(), values.end()}, std::move(unit)});
  }
  template <class T>
  void add_numbers(std::string path, std::vector<std::size_t> shape, const std::vector<T>& values,
                   std::string unit) {
    all.push_back(
        {std::move(path), std::move(shape), {values.begin(), values.end()}, std::move(unit)});
  }
};

Arrays arrays_of(const brdf::GridTable& table) {
  const brdf::GridAxes& axes = table.axes();
  Arrays arrays{"grid", table.origin(), {}};
  arrays.add("/axes/wavelength_um", axes.wavelength_um, "um");
  arrays.add("/axes/theta_i_deg", axes.theta_i_deg, "deg");
  arrays.add("/axes/theta_r_deg", axes.theta_r_deg, "deg");
  arrays.add("/axes/phi_r_deg", axes.phi_r_deg, "deg");
  arrays.add("/values",
             {axes.wavelength_um.size(), axes.theta_i_deg.size(), axes.theta_r_deg.size(),
              axes.phi_r_deg.size(), static_cast<std::size_t>(table.elements())},
             table.values(), "1/sr");
  return arrays;
}

Arrays arrays_of(const brdf::PlanesTable& table) {
  Arrays arrays{"planes", table.origin(), {}};
  arrays.add("/axes/wavelength_um", table.wavelengths_um(), "um");
  std::vector<double> incidences;
  for (const auto& slice : table.incidences()) incidences.push_back(slice.theta_i_deg);
  arrays.add("/axes/theta_i_deg", incidences, "deg");
  for (const bool across : {false, true}) {
    std::vector<double> counts, degrees, values;
    for (const auto& slice : table.incidences()) {
      const brdf::PlaneProfile& profile = across ? slice.across : slice.in_plane;
      counts.push_back(static_cast<double>(profile.deg.size()));
      degrees.insert(degrees.end(), profile.deg.begin(), profile.deg.end());
      for (const auto& row : profile.brdf_per_sr)
        values.insert(values.end(), row.begin(), row.end());
    }
    const std::string group = across ? "/across" : "/in_plane";
    arrays.add(group + "/count", counts, "1");
    arrays.add(group + "/deg", degrees, "deg");
    arrays.add(group + "/brdf_per_sr", values, "1/sr");
  }
  return arrays;
}

Arrays arrays_of(const HalfAngleTable& table) {
  const HalfAngleCells& cells = table.cells();
  Arrays arrays{"half angle", table.origin(), {}};
  arrays.add("/values", {3, cells.theta_h, cells.theta_d, cells.phi_d}, table.stored(),
             "1/sr over the channel's scale");
  return arrays;
}

Arrays arrays_of(const SpecularTable& table) {
  const SpecularAxes& axes = table.axes();
  Arrays arrays{
      axes.symmetric ? "specular, symmetric" : "specular, asymmetric", table.origin(), {}};
  arrays.add("/axes/wavelength_um", table.wavelengths_um(), "um");
  arrays.add("/axes/theta_i_deg", axes.theta_i_deg, "deg");
  arrays.add("/axes/azimuth_deg", axes.azimuth_deg, "deg");
  arrays.add("/axes/radial_deg", axes.radial_deg, "deg");
  arrays.add("/values",
             {table.wavelengths_um().size(), axes.theta_i_deg.size(), axes.azimuth_deg.size(),
              axes.radial_deg.size()},
             table.values(), "1/sr");
  arrays.add("/tis", {table.wavelengths_um().size(), axes.theta_i_deg.size()}, table.tis(), "1");
  return arrays;
}

Arrays arrays_of(const RglTable& table) {
  const RglData& d = table.data();
  const std::size_t phis = d.phi_i.size(), thetas = d.theta_i.size();
  Arrays arrays{d.jacobian ? "rgl, jacobian" : "rgl", table.origin(), {}};
  arrays.add_numbers("/rgl/phi_i", {phis}, d.phi_i, "rad");
  arrays.add_numbers("/rgl/theta_i", {thetas}, d.theta_i, "rad");
  arrays.add_numbers("/rgl/wavelengths", {d.wavelengths_nm.size()}, d.wavelengths_nm, "nm");
  arrays.add_numbers("/rgl/ndf", {d.ndf_rows, d.ndf_columns}, d.ndf, "");
  arrays.add_numbers("/rgl/sigma", {d.sigma_rows, d.sigma_columns}, d.sigma, "");
  arrays.add_numbers("/rgl/vndf", {phis, thetas, d.vndf_rows, d.vndf_columns}, d.vndf, "");
  arrays.add_numbers("/rgl/luminance", {phis, thetas, d.resolution, d.resolution}, d.luminance, "");
  arrays.add_numbers("/rgl/spectra", {phis, thetas, d.channels(), d.resolution, d.resolution},
                     d.spectra, "");
  arrays.add_numbers("/rgl/valid", {d.valid.size()}, d.valid, "");
  return arrays;
}

/// Empty layout for tables that have none of their own.
Arrays native_arrays(const brdf::Table& table) {
  if (const auto* t = dynamic_cast<const brdf::GridTable*>(&table)) return arrays_of(*t);
  if (const auto* t = dynamic_cast<const brdf::PlanesTable*>(&table)) return arrays_of(*t);
  if (const auto* t = dynamic_cast<const HalfAngleTable*>(&table)) return arrays_of(*t);
  if (const auto* t = dynamic_cast<const SpecularTable*>(&table)) return arrays_of(*t);
  if (const auto* t = dynamic_cast<const RglTable*>(&table)) return arrays_of(*t);
  return {};
}

std::string sha256_of(const Arrays& arrays) {
  ContentHash hash;
  hash.text(format_name);
  hash.text(arrays.layout);
  for (const Arrays::One& array : arrays.all) {
    for (const std::size_t length : array.shape) hash.integer(static_cast<std::int64_t>(length));
    hash.column(array.path, array.values);
  }
  return hash.hex_digest();
}

/// "quantity: BRDF …" as key and value.
Keys keys_of(const TableHeader& header) {
  Keys keys;
  for (const std::string& line : header.lines()) {
    const std::size_t colon = line.find(": ");
    keys.emplace_back(line.substr(0, colon), line.substr(colon + 2));
  }
  return keys;
}

std::vector<double> list(const Hdf5Reader& file, const std::string& path) {
  std::array<std::size_t, 1> shape{};
  return file.array(path, shape);
}

template <std::size_t dimensions>
std::vector<double> block(const Hdf5Reader& file, const std::string& path,
                          std::array<std::size_t, dimensions>& shape) {
  return file.array(path, shape);
}

void require_shape(const Hdf5Reader& file, const std::string& path,
                   std::span<const std::size_t> found, std::span<const std::size_t> expected) {
  for (std::size_t d = 0; d < expected.size(); ++d)
    if (found[d] != expected[d])
      file.fail(path, fmt::format("has length {} along dimension {}, its axis has {}", found[d],
                                  d + 1, expected[d]));
}

TablePtr grid_table(const Hdf5Reader& file, const std::string& origin) {
  brdf::GridAxes axes{list(file, "/axes/theta_i_deg"), list(file, "/axes/theta_r_deg"),
                      list(file, "/axes/phi_r_deg"), list(file, "/axes/wavelength_um")};
  std::array<std::size_t, 5> shape{};
  std::vector<double> values = block(file, "/values", shape);
  require_shape(file, "/values", shape,
                std::array{axes.wavelength_um.size(), axes.theta_i_deg.size(),
                           axes.theta_r_deg.size(), axes.phi_r_deg.size()});
  if (shape[4] != 1 && shape[4] != 16)
    file.fail("/values", fmt::format("has {} elements a direction, not 1 or 16", shape[4]));
  return std::make_shared<brdf::GridTable>(std::move(axes), std::move(values),
                                           static_cast<int>(shape[4]), origin);
}

TablePtr planes_table(const Hdf5Reader& file, const std::string& origin) {
  const std::vector<double> wavelengths = list(file, "/axes/wavelength_um");
  const std::vector<double> theta_i = list(file, "/axes/theta_i_deg");
  std::vector<brdf::PlanesAtIncidence> slices(theta_i.size());
  for (const bool across : {false, true}) {
    const std::string group = across ? "/across" : "/in_plane";
    const std::vector<double> counts = list(file, group + "/count");
    const std::vector<double> degrees = list(file, group + "/deg");
    const std::vector<double> values = list(file, group + "/brdf_per_sr");
    if (counts.size() != theta_i.size()) file.fail(group, "has not one count an incidence");
    if (values.size() != degrees.size() * wavelengths.size())
      file.fail(group, "has not one value a direction and wavelength");
    std::size_t start = 0;
    for (std::size_t i = 0; i < slices.size(); ++i) {
      slices[i].theta_i_deg = theta_i[i];
      brdf::PlaneProfile& profile = across ? slices[i].across : slices[i].in_plane;
      if (!(counts[i] >= 0.0) || counts[i] > static_cast<double>(degrees.size() - start))
        file.fail(group,
                  fmt::format("count {} is {}, more than there are directions", i + 1, counts[i]));
      const auto count = static_cast<std::size_t>(counts[i]);
      const auto at = [](const std::vector<double>& from, std::size_t first, std::size_t size) {
        const auto begin = from.begin() + static_cast<std::ptrdiff_t>(first);
        return std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(size));
      };
      profile.deg = at(degrees, start, count);
      for (std::size_t w = 0; w < wavelengths.size(); ++w)
        profile.brdf_per_sr.push_back(at(values, start * wavelengths.size() + w * count, count));
      start += count;
    }
    if (start != degrees.size()) file.fail(group, "has directions that belong to no incidence");
  }
  return std::make_shared<brdf::PlanesTable>(wavelengths, std::move(slices), origin);
}

TablePtr half_angle_table(const Hdf5Reader& file, const std::string& origin) {
  std::array<std::size_t, 4> shape{};
  std::vector<double> values = block(file, "/values", shape);
  require_shape(file, "/values", shape, std::array{std::size_t{3}});
  return std::make_shared<HalfAngleTable>(HalfAngleCells{shape[1], shape[2], shape[3]},
                                          std::move(values), origin);
}

TablePtr specular_table(const Hdf5Reader& file, const std::string& origin, bool symmetric) {
  SpecularAxes axes{list(file, "/axes/theta_i_deg"), list(file, "/axes/azimuth_deg"),
                    list(file, "/axes/radial_deg"), symmetric};
  std::vector<double> wavelengths = list(file, "/axes/wavelength_um");
  std::array<std::size_t, 4> shape{};
  std::vector<double> values = block(file, "/values", shape);
  require_shape(file, "/values", shape,
                std::array{wavelengths.size(), axes.theta_i_deg.size(), axes.azimuth_deg.size(),
                           axes.radial_deg.size()});
  std::array<std::size_t, 2> tis_shape{};
  std::vector<double> tis = block(file, "/tis", tis_shape);
  require_shape(file, "/tis", tis_shape, std::array{wavelengths.size(), axes.theta_i_deg.size()});
  return std::make_shared<SpecularTable>(std::move(axes), std::move(wavelengths), std::move(values),
                                         std::move(tis), origin);
}

TablePtr rgl_table(const Hdf5Reader& file, const std::string& origin, bool jacobian,
                   const std::string& description) {
  const auto floats = [](const std::vector<double>& values) {
    std::vector<float> result;
    result.reserve(values.size());
    for (const double value : values) result.push_back(static_cast<float>(value));
    return result;
  };
  RglData d;
  d.jacobian = jacobian;
  d.description = description;
  d.phi_i = floats(list(file, "/rgl/phi_i"));
  d.theta_i = floats(list(file, "/rgl/theta_i"));
  d.wavelengths_nm = floats(list(file, "/rgl/wavelengths"));
  for (const double byte : list(file, "/rgl/valid")) {
    if (!(byte >= 0.0 && byte <= 255.0)) file.fail("/rgl/valid", "holds more than bytes");
    d.valid.push_back(static_cast<std::uint8_t>(byte));
  }
  const std::array images{d.phi_i.size(), d.theta_i.size()};
  std::array<std::size_t, 2> flat{};
  d.ndf = floats(block(file, "/rgl/ndf", flat));
  d.ndf_rows = flat[0];
  d.ndf_columns = flat[1];
  d.sigma = floats(block(file, "/rgl/sigma", flat));
  d.sigma_rows = flat[0];
  d.sigma_columns = flat[1];
  std::array<std::size_t, 4> shape{};
  d.vndf = floats(block(file, "/rgl/vndf", shape));
  require_shape(file, "/rgl/vndf", shape, images);
  d.vndf_rows = shape[2];
  d.vndf_columns = shape[3];
  d.luminance = floats(block(file, "/rgl/luminance", shape));
  d.resolution = shape[2];
  require_shape(file, "/rgl/luminance", shape,
                std::array{images[0], images[1], d.resolution, d.resolution});
  std::array<std::size_t, 5> spectral{};
  d.spectra = floats(block(file, "/rgl/spectra", spectral));
  require_shape(file, "/rgl/spectra", spectral,
                std::array{images[0], images[1], d.channels(), d.resolution, d.resolution});
  check_rgl(d, [&](const char* field, std::size_t entry, const std::string& problem) {
    file.fail(std::string("/rgl/") + field, fmt::format("entry {}: {}", entry, problem));
  });
  return std::make_shared<RglTable>(std::move(d), origin);
}

}  // namespace

bool looks_like_table_h5(std::string_view bytes) {
  return looks_like_hdf5(bytes) && bytes.find(format_name) != std::string_view::npos;
}

TableH5 parse_table_h5(std::string_view bytes, const std::string& name) {
  const Hdf5Reader file(bytes, name);
  TableH5 result;
  result.provenance = read_h5_header(file, format_name, result.keys);
  const std::string layout = file.attribute("layout");
  const std::string origin =
      file.has_attribute("table_origin") ? file.attribute("table_origin") : name;
  if (layout == "grid") {
    result.table = grid_table(file, origin);
  } else if (layout == "planes") {
    result.table = planes_table(file, origin);
  } else if (layout == "half angle") {
    result.table = half_angle_table(file, origin);
  } else if (layout == "specular, symmetric" || layout == "specular, asymmetric") {
    result.table = specular_table(file, origin, layout == "specular, symmetric");
  } else if (layout == "rgl" || layout == "rgl, jacobian") {
    result.table = rgl_table(file, origin, layout != "rgl", file.attribute("rgl_description"));
  } else {
    file.fail("/@layout", "there is no layout '" + layout + "'");
  }
  verify_h5_content(file, content_sha256(*result.table));
  return result;
}

TablePtr read_table_h5(std::string_view bytes, const std::string& name) {
  return parse_table_h5(bytes, name).table;
}

std::string content_sha256(const brdf::Table& table) {
  return sha256_of(native_arrays(table));
}

std::string table_h5_bytes(const brdf::Table& table, const TableWriting& writing,
                           const Provenance& provenance) {
  Arrays arrays = writing.wavelengths_um.empty() ? native_arrays(table) : Arrays{};
  std::vector<double> wavelengths = written_wavelengths(table, writing);
  const bool resampled = arrays.layout.empty();
  if (resampled) arrays = arrays_of(dense_grid(table, wavelengths, writing.progress));
  TableHeader header = table_header(table, writing, std::move(wavelengths), table.polarised());
  if (const auto* rgl = dynamic_cast<const RglTable*>(&table); rgl != nullptr && !resampled) {
    header.quantity = "BRDF times cos theta_r as an RGL tensor stores it; readers divide";
    header.azimuth = "of the half vector, 0 is towards the source";
  } else if (arrays.layout == "half angle") {
    header.quantity =
        "BRDF in 1/sr over 1/1500, 1.15/1500, 1.66/1500 for red, green, blue, not "
        "multiplied by cos theta; negative where unknown";
    header.azimuth = "of the beam towards the source about the half vector";
  } else if (arrays.layout.starts_with("specular")) {
    header.azimuth = "around the mirror direction, 0 towards the surface normal";
  }
  const Keys keys = keys_of(header);
  Hdf5Builder file("table.h5");
  write_h5_header(file, format_name, keys, provenance, sha256_of(arrays));
  file.attribute("/", "layout", arrays.layout);
  file.attribute("/", "table_origin", arrays.origin);
  if (const auto* rgl = dynamic_cast<const RglTable*>(&table); rgl != nullptr && !resampled)
    file.attribute("/", "rgl_description", rgl->data().description);
  std::string group;
  for (const Arrays::One& array : arrays.all) {
    const std::string parent = array.path.substr(0, array.path.rfind('/'));
    if (!parent.empty() && parent != group) file.group(group = parent);
    file.array(array.path, array.values, array.shape, array.unit);
  }
  return file.finish();
}

std::string write_table_h5(const brdf::Table& table, const TableWriting& writing) {
  Provenance provenance;
  provenance.program = writing.program;
  provenance.command = writing.command;
  return table_h5_bytes(table, writing, provenance);
}

}  // namespace umov::formats
