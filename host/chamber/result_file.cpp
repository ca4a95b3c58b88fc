#include "host/chamber/result_file.hpp"

#include <fmt/format.h>

#include <array>
#include <set>
#include <span>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/content_hash.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/h5_header.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/formats/image_file.hpp"

namespace umov::chamber {
namespace {

constexpr const char* format_name = "umov sim h5";

struct Column {
  const char* path;
  const char* unit;
  std::vector<double>* values;
};

std::array<Column, 2> map_columns(Map& map) {
  return {{{"/map/luminance_cd_m2", "cd/m2", &map.luminance_cd_m2},
           {"/map/luminance_se", "cd/m2", &map.luminance_se}}};
}

/// [band, y, x], where the map has bands.
std::array<Column, 2> band_columns(Map& map) {
  return {{{"/map/radiance", "W/(m2 sr nm)", &map.radiance},
           {"/map/radiance_se", "W/(m2 sr nm)", &map.radiance_se}}};
}

constexpr const char* map_wavelengths = "/map/wavelength_um";
constexpr const char* lid_wavelengths = "/lid/wavelength_um";
constexpr const char* lid_spectrum = "/lid/spectrum_out";

std::array<Column, 2> lid_columns(Distribution& d) {
  return {
      {{"/lid/intensity_cd", "cd", &d.intensity_cd}, {"/lid/intensity_se", "cd", &d.intensity_se}}};
}

std::string content_sha256(Result& result) {
  formats::ContentHash hash;
  hash.text(format_name);
  hash.pairs("header", result.keys);
  if (result.map) {
    for (const Column& c : map_columns(*result.map))
      hash.column(c.path, std::span<const double>(*c.values));
    if (!result.map->wavelengths_um.empty()) {
      hash.column(map_wavelengths, std::span<const double>(result.map->wavelengths_um));
      for (const Column& c : band_columns(*result.map))
        hash.column(c.path, std::span<const double>(*c.values));
    }
  }
  if (result.distribution) {
    const Distribution& d = *result.distribution;
    for (const Column& c : lid_columns(*result.distribution))
      hash.column(c.path, std::span<const double>(*c.values));
    if (!d.wavelengths_um.empty()) {
      hash.column(lid_wavelengths, std::span<const double>(d.wavelengths_um));
      hash.column(lid_spectrum, std::span<const double>(d.fate.spectrum_out));
    }
  }
  return hash.hex_digest();
}

const std::string& value_of(const Result& result, const std::string& key, const std::string& file) {
  for (const auto& [name, value] : result.keys) {
    if (name == key) return value;
  }
  throw Error(Place{file, 0, key}, "is missing", "write the file again");
}

double number_of(const Result& result, const std::string& key, const std::string& file) {
  double value = 0.0;
  if (const char* wrong = formats::read_decimal(value_of(result, key, file), value))
    throw Error(Place{file, 0, key}, wrong, "write the file again");
  return value;
}

using Numbers = std::vector<std::pair<std::string, double>>;

Numbers numbers_of(const Map& map) {
  return {{"pixel_mm", map.pixel_mm}, {"rays_per_pixel", static_cast<double>(map.rays_per_pixel)}};
}

Numbers numbers_of(const Distribution& d) {
  return {{"source_lm", d.source_lm},
          {"out_lm", d.out_lm},
          {"out_se", d.out_se},
          {"first_hit_fraction", d.first_hit_fraction},
          {"absorbed_fraction", d.absorbed_fraction},
          {"lid_rays", static_cast<double>(d.rays_launched)}};
}

/// Keys of the file, which readers of it rely on.
void set_keys(Result& result, const Numbers& numbers) {
  for (const auto& [name, value] : numbers) {
    std::erase_if(result.keys, [&name = name](const auto& pair) { return pair.first == name; });
    result.keys.emplace_back(name, formats::decimal_text(value));
  }
}

/// The same on the group they belong to, as numbers.
void set_attributes(formats::Hdf5Builder& file, const std::string& group, const Numbers& numbers) {
  for (const auto& [name, value] : numbers)
    file.attribute(group, name, std::span<const double>(&value, 1));
}

}  // namespace

void write_sim_h5(const std::filesystem::path& path, const Result& given,
                  const formats::Provenance& provenance) {
  Result result = given;
  std::set<std::string> numeric{"seed"};
  const auto note = [&](const Numbers& numbers) {
    set_keys(result, numbers);
    for (const auto& [name, value] : numbers) numeric.insert(name);
  };
  if (result.map) note(numbers_of(*result.map));
  if (result.distribution) note(numbers_of(*result.distribution));
  formats::check_storable(result.keys, path.string());
  formats::Hdf5Builder file(path.string());
  formats::write_h5_header(file, format_name, result.keys, provenance, content_sha256(result),
                           numeric);
  if (result.map) {
    file.group("/map");
    set_attributes(file, "/map", numbers_of(*result.map));
    for (const Column& c : map_columns(*result.map))
      file.matrix(c.path, *c.values, result.map->height, result.map->width, c.unit);
    if (!result.map->wavelengths_um.empty()) {
      Map& map = *result.map;
      file.column(map_wavelengths, std::span<const double>(map.wavelengths_um), "um");
      const std::array<std::size_t, 3> shape{map.wavelengths_um.size(), map.height, map.width};
      for (const Column& c : band_columns(map)) file.array(c.path, *c.values, shape, c.unit);
    }
    file.attribute("/map", "meaning",
                   "row 0 is the lowest, column 0 the leftmost; standard errors are of the "
                   "simulation's noise alone");
  }
  if (result.distribution) {
    Distribution& d = *result.distribution;
    file.group("/lid");
    set_attributes(file, "/lid", numbers_of(d));
    file.column("/lid/c_deg", std::span<const double>(d.c_deg), "deg");
    file.column("/lid/gamma_deg", std::span<const double>(d.gamma_deg), "deg");
    for (const Column& c : lid_columns(d))
      file.matrix(c.path, *c.values, d.c_deg.size(), d.gamma_deg.size(), c.unit);
    if (!d.wavelengths_um.empty()) {
      file.column(lid_wavelengths, std::span<const double>(d.wavelengths_um), "um");
      file.column(lid_spectrum, std::span<const double>(d.fate.spectrum_out), "W/nm");
    }
  }
  formats::replace_file(path, file.finish());
}

Result read_sim_h5(const std::filesystem::path& path) {
  const std::string name = path.string();
  const formats::Hdf5Reader file(formats::read_whole_file(path), name);
  Result result;
  formats::read_h5_header(file, format_name, result.keys);
  if (file.has("/map/luminance_cd_m2")) {
    Map map;
    for (const Column& c : map_columns(map)) *c.values = file.matrix(c.path, map.height, map.width);
    if (file.has(map_wavelengths)) {
      map.wavelengths_um = file.doubles(map_wavelengths);
      std::array<std::size_t, 3> shape{};
      for (const Column& c : band_columns(map)) {
        *c.values = file.array(c.path, shape);
        if (shape != std::array{map.wavelengths_um.size(), map.height, map.width})
          file.fail(c.path, "does not fit its wavelengths and the map");
      }
    }
    map.pixel_mm = number_of(result, "pixel_mm", name);
    map.rays_per_pixel = static_cast<std::uint64_t>(number_of(result, "rays_per_pixel", name));
    result.map = std::move(map);
  }
  if (file.has("/lid/intensity_cd")) {
    Distribution d;
    d.c_deg = file.doubles("/lid/c_deg");
    d.gamma_deg = file.doubles("/lid/gamma_deg");
    std::size_t planes = 0;
    std::size_t angles = 0;
    for (const Column& c : lid_columns(d)) {
      *c.values = file.matrix(c.path, planes, angles);
      if (planes != d.c_deg.size() || angles != d.gamma_deg.size())
        file.fail(c.path, "does not fit its angles");
    }
    if (file.has(lid_wavelengths)) {
      d.wavelengths_um = file.doubles(lid_wavelengths);
      d.fate.spectrum_out = file.doubles(lid_spectrum);
      if (d.fate.spectrum_out.size() != d.wavelengths_um.size())
        file.fail(lid_spectrum, "does not fit its wavelengths");
    }
    d.source_lm = number_of(result, "source_lm", name);
    d.out_lm = number_of(result, "out_lm", name);
    d.out_se = number_of(result, "out_se", name);
    d.first_hit_fraction = number_of(result, "first_hit_fraction", name);
    d.absorbed_fraction = number_of(result, "absorbed_fraction", name);
    d.rays_launched = static_cast<std::uint64_t>(number_of(result, "lid_rays", name));
    result.distribution = std::move(d);
  }
  formats::verify_h5_content(file, content_sha256(result));
  return result;
}

void write_map_exr(const std::filesystem::path& path, const Map& map) {
  std::vector<double> luminance;
  std::vector<double> error;
  for (std::size_t y = map.height; y-- > 0;) {
    for (std::size_t x = 0; x < map.width; ++x) {
      luminance.push_back(map.at(x, y));
      error.push_back(map.luminance_se[y * map.width + x]);
    }
  }
  const std::array<formats::ImagePlane, 2> planes{{{"Y", luminance}, {"se", error}}};
  formats::write_exr(path, map.width, map.height, planes,
                     {{"unit", "cd/m2"}, {"pixel_mm", fmt::format("{:g}", map.pixel_mm)}});
}

}  // namespace umov::chamber
