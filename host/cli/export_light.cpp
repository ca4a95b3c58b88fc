#include "host/cli/export_light.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "host/chamber/map_file.hpp"
#include "host/chamber/map_picture.hpp"
#include "host/chamber/result_file.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/h5_kind.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/formats/photometry.hpp"

namespace umov::cli {
namespace {

using chamber::Map;
using formats::Photometry;

const LightFormat& format_named(const std::string& name) {
  for (const LightFormat& format : light_formats())
    if (format.name == name) return format;
  std::vector<std::string_view> names;
  for (const LightFormat& format : light_formats()) names.push_back(format.name);
  throw Error(name.empty() ? "a distribution or map is written in the format that you name"
                           : "--format " + name + " is for BRDFs and scans",
              fmt::format("give --format with one of {}", fmt::join(names, ", ")));
}

/// Largest difference of intensities on the source's own directions, over its largest.
double difference(const Photometry& source, const Photometry& back) {
  double worst = 0.0, peak = 0.0;
  for (std::size_t c = 0; c < source.c_deg.size(); ++c) {
    for (std::size_t g = 0; g < source.gamma_deg.size(); ++g) {
      const double cd = source.candela[c * source.gamma_deg.size() + g];
      const double found = back.intensity(source.c_deg[c], source.gamma_deg[g]);
      peak = std::max(peak, cd);
      worst = std::max(worst, std::abs(found - cd));
    }
  }
  return peak > 0.0 ? worst / peak : worst;
}

std::string words(const Photometry& p) {
  return fmt::format("{} planes of {} angles, {:.5g} lm{}", p.c_deg.size(), p.gamma_deg.size(),
                     p.zonal_lm(),
                     p.lamp_lm > 0.0 ? fmt::format(" of {:.5g} lm of the lamps", p.lamp_lm)
                                     : std::string(", absolute"));
}

Photometry distribution_in(const std::string& input, const std::string& bytes,
                           const std::string& program) {
  if (!formats::looks_like_hdf5(bytes)) return formats::parse_photometry(bytes, input);
  const chamber::Result result = chamber::read_sim_h5(input);
  if (!result.distribution)
    throw Error(Place{input}, "holds no intensity distribution",
                "simulate it from a scene with a [goniophotometer], or export its map");
  Photometry p = result.distribution->photometry();
  p.maker = program;
  p.name = input;
  p.report = "simulated";
  return p;
}

LightExported export_distribution(const Photometry& p, const std::string& output, bool ies) {
  formats::replace_file(output, ies ? formats::ies_text(p) : formats::eulumdat_text(p));
  const Photometry back = formats::read_photometry(output);
  LightExported out{words(back), {}};
  if (!ies && !(p.lamp_lm > 0.0))
    out.notes.push_back(
        "the source is absolute photometry; EULUMDAT relates to lamps, here to one of 1000 lm");
  if (p.length_mm == 0.0)
    out.notes.push_back("the source does not tell the size of the luminous opening: written as 0");
  out.notes.push_back(fmt::format(
      "read back, intensities are off by {:.1g} % of the peak at most, "
      "the flux by {:.1g} %",
      100.0 * difference(p, back), 100.0 * std::abs(back.zonal_lm() / p.zonal_lm() - 1.0)));
  return out;
}

Map map_in(const std::string& input, const std::string& bytes) {
  if (formats::looks_like_hdf5(bytes)) {
    const chamber::Result result = chamber::read_sim_h5(input);
    if (result.map) return *result.map;
  }
  throw Error(Place{input}, "holds no luminance map",
              "simulate it from a scene with a [camera], or export its distribution as ies or ldt");
}

LightExported export_map(const Map& map, const std::string& output, std::string_view format) {
  if (format == "png") {
    formats::replace_file(output, chamber::map_png(map));
    return {fmt::format("{} × {} pixels", map.width, map.height), {"a picture, no numbers"}};
  }
  if (format == "exr") {
    chamber::write_map_exr(output, map);
  } else {
    formats::replace_file(output, chamber::map_csv_text(map));
  }
  chamber::Camera camera;
  camera.width = map.width;
  camera.height = map.height;
  camera.pixel_mm = map.pixel_mm;
  const Map back = chamber::read_measured_map(output, camera).map;
  double worst = 0.0;
  for (std::size_t i = 0; i < map.luminance_cd_m2.size(); ++i)
    worst = std::max(worst, std::abs(back.luminance_cd_m2[i] - map.luminance_cd_m2[i]));
  const double largest = *std::max_element(map.luminance_cd_m2.begin(), map.luminance_cd_m2.end());
  return {fmt::format("{} × {} pixels of {:g} mm", map.width, map.height, map.pixel_mm),
          {fmt::format("read back, luminances are off by {:.1g} % of the largest at most",
                       100.0 * worst / largest)}};
}

}  // namespace

const std::vector<LightFormat>& light_formats() {
  static const std::vector<LightFormat> formats{
      {"ies", "IES LM-63-2002 intensity distribution", false},
      {"ldt", "EULUMDAT intensity distribution", false},
      {"exr", "luminance map as OpenEXR, channels Y (cd/m2) and se", true},
      {"map-csv", "luminance map as CSV, one line a pixel", true},
      {"png", "luminance map as a picture with a scale", true}};
  return formats;
}

bool is_light(std::string_view bytes, const std::string& name) {
  if (formats::looks_like_hdf5(bytes)) return formats::h5_kind(bytes, name) == formats::H5Kind::sim;
  return formats::looks_like_photometry(bytes);
}

LightExported export_light(const std::string& input, const std::string& bytes,
                           const std::string& output, const std::string& format,
                           const std::string& program) {
  const LightFormat& wanted = format_named(format);
  if (wanted.map) return export_map(map_in(input, bytes), output, wanted.name);
  return export_distribution(distribution_in(input, bytes, program), output, wanted.name == "ies");
}

}  // namespace umov::cli
