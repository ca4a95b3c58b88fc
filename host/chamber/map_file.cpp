#include "host/chamber/map_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/chamber/map_noise.hpp"
#include "host/chamber/result_file.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/formats/image_file.hpp"
#include "host/formats/number_csv.hpp"

namespace umov::chamber {
namespace {

constexpr std::string_view csv_columns[] = {"x_mm", "y_mm", "luminance_cd_m2", "luminance_se"};
/// Of a pixel: how far a row's place may be from its centre.
constexpr double place_slack = 0.25;

/// A map of the camera's window; standard errors are empty where the file has none.
struct Raw {
  Map map;
  std::string name;

  std::string pixel(std::size_t i) const {
    return fmt::format("pixel ({}, {})", i % map.width, i / map.width);
  }
  [[noreturn]] void fail(const std::string& where, const std::string& problem,
                         const std::string& remedy) const {
    throw Error(Place{name, 0, where}, problem, remedy);
  }
};

void require_window(const Raw& raw, const Camera& camera) {
  const Map& map = raw.map;
  if (map.width != camera.width || map.height != camera.height)
    raw.fail("",
             fmt::format("the map has {} × {} pixels, the scene's camera {} × {}", map.width,
                         map.height, camera.width, camera.height),
             "give the camera the pixels, size and view that the map was taken with");
  if (std::abs(map.pixel_mm / camera.pixel_mm - 1.0) > 1e-6)
    raw.fail("pixel_mm",
             fmt::format("is {:g}, the scene's camera has {:g}", map.pixel_mm, camera.pixel_mm),
             "give the camera the pixels, size and view that the map was taken with");
}

/// Channels come from the top, maps from below.
std::vector<double> from_below(const std::vector<double>& rows, std::size_t width) {
  std::vector<double> out;
  for (std::size_t end = rows.size(); end > 0; end -= width)
    out.insert(out.end(), rows.begin() + static_cast<std::ptrdiff_t>(end - width),
               rows.begin() + static_cast<std::ptrdiff_t>(end));
  return out;
}

Raw of_exr(const std::filesystem::path& path, const Camera& camera) {
  Raw raw{{}, path.string()};
  const formats::ExrHeader header = formats::read_exr_header(path);
  raw.map.pixel_mm = camera.pixel_mm;
  for (const auto& [key, text] : header.attributes) {
    if (key == "pixel_mm" && formats::read_decimal(text, raw.map.pixel_mm) != nullptr)
      raw.fail(key, "is no number: \"" + text + "\"", "write the size of a pixel in mm");
    if (key == "unit" && text != "cd/m2")
      raw.fail(key, "is \"" + text + "\"", "give luminances in cd/m2");
  }
  const auto channel = [&](const char* name) {
    return from_below(formats::read_exr(path, name, raw.map.width, raw.map.height), header.width);
  };
  raw.map.width = header.width;
  raw.map.height = header.height;
  require_window(raw, camera);
  raw.map.luminance_cd_m2 = channel("Y");
  if (std::count(header.channels.begin(), header.channels.end(), "se") > 0)
    raw.map.luminance_se = channel("se");
  return raw;
}

/// Number of the pixel that a row names, along one axis.
std::size_t place_of(double mm, const Camera& camera, std::size_t count, const char* column,
                     const Raw& raw, std::size_t line) {
  const double pixel = mm / camera.pixel_mm - 0.5;
  const double nearest = std::round(pixel);
  if (std::abs(pixel - nearest) > place_slack || nearest < 0.0 ||
      nearest >= static_cast<double>(count))
    throw Error(
        Place{raw.name, line, column},
        fmt::format("{:g} is no centre of a pixel of the scene's camera", mm),
        fmt::format("they are {:g}, {:g} … {:g} mm, from the lower left", 0.5 * camera.pixel_mm,
                    1.5 * camera.pixel_mm, (static_cast<double>(count) - 0.5) * camera.pixel_mm));
  return static_cast<std::size_t>(nearest);
}

Raw of_csv(const std::string& text, const std::string& name, const Camera& camera) {
  Raw raw{{}, name};
  Map& map = raw.map;
  map.width = camera.width;
  map.height = camera.height;
  map.pixel_mm = camera.pixel_mm;
  const bool errors = formats::csv_header_line(text).find(csv_columns[3]) != std::string_view::npos;
  constexpr double missing = std::numeric_limits<double>::quiet_NaN();
  map.luminance_cd_m2.assign(map.width * map.height, missing);
  if (errors) map.luminance_se.assign(map.width * map.height, missing);
  formats::read_number_csv(
      text, name, std::span(csv_columns).first(errors ? 4 : 3), 0,
      [&](std::span<const std::string_view>, std::span<const double> numbers, std::size_t line) {
        const std::size_t x = place_of(numbers[0], camera, map.width, "x_mm", raw, line);
        const std::size_t y = place_of(numbers[1], camera, map.height, "y_mm", raw, line);
        double& value = map.luminance_cd_m2[y * map.width + x];
        if (!std::isnan(value))
          throw Error(Place{name, line}, fmt::format("pixel ({}, {}) comes again", x, y),
                      "give every pixel once");
        value = numbers[2];
        if (errors) map.luminance_se[y * map.width + x] = numbers[3];
      });
  for (std::size_t i = 0; i < map.luminance_cd_m2.size(); ++i)
    if (std::isnan(map.luminance_cd_m2[i]))
      raw.fail(raw.pixel(i), "is missing",
               fmt::format("give all {} × {} pixels of the scene's camera", map.width, map.height));
  return raw;
}

Raw read_raw(const std::filesystem::path& path, const Camera& camera) {
  const std::string bytes = formats::read_whole_file(path);
  if (formats::looks_like_exr(bytes)) return of_exr(path, camera);
  if (formats::looks_like_hdf5(bytes)) {
    const Result result = read_sim_h5(path);
    if (!result.map)
      throw Error(Place{path.string()}, "holds no luminance map",
                  "simulate it from a scene with a [camera]");
    Raw raw{*result.map, path.string()};
    require_window(raw, camera);
    return raw;
  }
  if (formats::csv_header_line(bytes).starts_with("x_mm,"))
    return of_csv(bytes, path.string(), camera);
  throw Error(Place{path.string()}, "is no luminance map",
              "give a sim.h5, an OpenEXR file with a channel Y in cd/m2, or a CSV with the columns "
              "x_mm,y_mm,luminance_cd_m2");
}

void require_values(const Raw& raw) {
  const Map& map = raw.map;
  double brightest = 0.0;
  for (std::size_t i = 0; i < map.luminance_cd_m2.size(); ++i) {
    const double value = map.luminance_cd_m2[i];
    if (!std::isfinite(value)) raw.fail(raw.pixel(i), "is not a number", "measure it again");
    if (value < 0.0)
      raw.fail(raw.pixel(i), fmt::format("has {:g} cd/m²", value),
               "luminances are not negative: check what was subtracted");
    brightest = std::max(brightest, value);
  }
  if (!(brightest > 0.0)) raw.fail("", "the map is dark all over", "is the luminaire on?");
  for (std::size_t i = 0; i < map.luminance_se.size(); ++i)
    if (!std::isfinite(map.luminance_se[i]) || map.luminance_se[i] < 0.0)
      raw.fail(raw.pixel(i), fmt::format("has the standard error {:g}", map.luminance_se[i]),
               "give numbers of 0 or more, or leave them out: they are estimated then");
}

}  // namespace

MeasuredMap read_measured_map(const std::filesystem::path& path, const Camera& camera) {
  Raw raw = read_raw(path, camera);
  require_values(raw);
  MeasuredMap out;
  const auto is_positive = [](double se) { return se > 0.0; };
  if (std::none_of(raw.map.luminance_se.begin(), raw.map.luminance_se.end(), is_positive)) {
    try {
      raw.map.luminance_se = estimated_noise(raw.map);
    } catch (const Error& error) {
      raw.fail("", error.problem(), error.remedy());
    }
    std::vector<double> shares;
    for (std::size_t i = 0; i < raw.map.luminance_se.size(); ++i)
      if (raw.map.luminance_cd_m2[i] > 0.0)
        shares.push_back(raw.map.luminance_se[i] / raw.map.luminance_cd_m2[i]);
    const auto middle = shares.begin() + static_cast<std::ptrdiff_t>(shares.size() / 2);
    std::nth_element(shares.begin(), middle, shares.end());
    out.notes.push_back(fmt::format(
        "{} gives no standard errors: they were estimated from how neighbouring pixels scatter, "
        "{:.2g} % of the luminance in the median",
        raw.name, 100.0 * *middle));
  }
  out.map = std::move(raw.map);
  return out;
}

std::string map_csv_text(const Map& map) {
  std::string text = "# Luminance map; x to the right and y up from the lower left of the window\n";
  text += fmt::format("{}\n", fmt::join(csv_columns, ","));
  for (std::size_t y = 0; y < map.height; ++y) {
    for (std::size_t x = 0; x < map.width; ++x) {
      const std::size_t i = y * map.width + x;
      text += fmt::format("{:.9g},{:.9g},{},{}\n", map.pixel_mm * (static_cast<double>(x) + 0.5),
                          map.pixel_mm * (static_cast<double>(y) + 0.5), map.luminance_cd_m2[i],
                          map.luminance_se[i]);
    }
  }
  return text;
}

}  // namespace umov::chamber
