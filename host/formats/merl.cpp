#include "host/formats/merl.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "MERL files are little-endian");

constexpr std::size_t header_bytes = 3 * sizeof(std::int32_t);
/// Directions nearer to the horizon than this are sampled here: table values at grazing incidence
/// are not worth more.
constexpr double lowest_cosine = 0.01;
constexpr double largest_brdf_per_sr = 1e9;  ///< no surface comes near

std::array<std::int32_t, 3> sizes_of(const HalfAngleCells& cells) {
  return {static_cast<std::int32_t>(cells.theta_h), static_cast<std::int32_t>(cells.theta_d),
          static_cast<std::int32_t>(cells.phi_d)};
}

/// The θd at which one of the two beams touches the horizon.
double horizon_theta_d(double theta_h, double phi_d) {
  return std::atan2(std::cos(theta_h), std::sin(theta_h) * std::abs(std::cos(phi_d)));
}

/// Where a cell is sampled: its middle, moved towards θd = 0 as far as the horizon demands. False
/// where the whole cell lies below the horizon.
bool sampling_point(const HalfAngleCells& cells, std::size_t h, std::size_t d, std::size_t p,
                    HalfAngles& at) {
  at = cells.middle(h, d, p);
  const auto edge = [](std::size_t i, std::size_t n) {
    return static_cast<double>(i) / static_cast<double>(n);
  };
  const double root = edge(h, cells.theta_h);
  const double half_width = 0.5 * optics::pi / static_cast<double>(cells.phi_d);
  const double towards_side =
      std::clamp(0.5 * optics::pi, at.phi_d - half_width, at.phi_d + half_width);
  const double lowest = 0.5 * optics::pi * edge(d, cells.theta_d);
  if (lowest >= horizon_theta_d(0.5 * optics::pi * root * root, towards_side)) return false;
  const auto above = [&](double theta_d) {
    const auto g = geometry_of({at.theta_h, theta_d, at.phi_d});
    return std::min(std::cos(g.theta_i), std::cos(g.theta_r)) >= lowest_cosine;
  };
  if (above(at.theta_d)) return true;
  double inside = 0.0, outside = at.theta_d;
  if (!above(inside)) {
    at.theta_d = 0.0;  // the half vector itself grazes; both beams are taken along it
    return true;
  }
  for (int step = 0; step < 40; ++step) {
    const double middle = 0.5 * (inside + outside);
    (above(middle) ? inside : outside) = middle;
  }
  at.theta_d = inside;
  return true;
}

/// Blue, green, red.
std::array<double, 3> channel_wavelengths(const TableWriting& writing) {
  const std::vector<double>& wanted = writing.wavelengths_um;
  if (wanted.empty()) return HalfAngleTable::channel_um;
  if (wanted.size() == 1) return {wanted[0], wanted[0], wanted[0]};
  if (wanted.size() == 3) return {wanted[0], wanted[1], wanted[2]};
  throw Error(
      fmt::format("a merl file has three channels, {} wavelengths are asked for", wanted.size()),
      "give --wavelength-nm once, or three times for blue, green and red");
}

}  // namespace

bool looks_like_merl(std::string_view bytes) {
  if (bytes.size() == header_bytes + 3 * merl_cells.count() * sizeof(double)) return true;
  std::array<std::int32_t, 3> found{};
  if (bytes.size() < header_bytes) return false;
  std::memcpy(found.data(), bytes.data(), header_bytes);
  return found == sizes_of(merl_cells);
}

std::shared_ptr<const HalfAngleTable> parse_merl(std::string_view bytes, const std::string& name,
                                                 const HalfAngleCells& cells) {
  constexpr const char* remedy =
      "a MERL file holds three 32-bit sizes 90, 90, 180 and 3 x 90 x 90 x 180 doubles";
  const std::array<std::int32_t, 3> expected = sizes_of(cells);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    std::int32_t found = 0;
    if (bytes.size() < (i + 1) * sizeof found)
      throw Error(Place{name}, fmt::format("ends at byte {}, within its sizes", bytes.size()),
                  remedy);
    std::memcpy(&found, bytes.data() + i * sizeof found, sizeof found);
    if (found != expected[i])
      throw Error(Place{name},
                  fmt::format("byte {}: size {} is {}, not {}", i * sizeof found, i + 1, found,
                              expected[i]),
                  remedy);
  }
  const std::size_t count = 3 * cells.count();
  const std::size_t whole = header_bytes + count * sizeof(double);
  if (bytes.size() != whole)
    throw Error(Place{name},
                fmt::format("{} at byte {}, {} bytes are expected",
                            bytes.size() < whole ? "is cut off" : "goes on", bytes.size(), whole),
                remedy);
  std::vector<double> stored(count);
  std::memcpy(stored.data(), bytes.data() + header_bytes, count * sizeof(double));
  for (std::size_t i = 0; i < count; ++i)
    if (!std::isfinite(stored[i]))
      throw Error(Place{name},
                  fmt::format("byte {}: value {} is not a finite number",
                              header_bytes + i * sizeof(double), i),
                  "cells without a value hold a negative number");
  constexpr std::array<const char*, 3> names = {"red", "green", "blue"};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const auto begin = stored.begin() + static_cast<std::ptrdiff_t>(channel * cells.count());
    const auto most = std::max_element(begin, begin + static_cast<std::ptrdiff_t>(cells.count()));
    if (*most < 0)
      throw Error(Place{name}, fmt::format("no value is known of channel {}", names[channel]),
                  "the file holds no BRDF");
    if (*most * HalfAngleTable::channel_scale[channel] > largest_brdf_per_sr)
      throw Error(Place{name},
                  fmt::format("byte {}: {:g} is no BRDF",
                              header_bytes +
                                  static_cast<std::size_t>(most - stored.begin()) * sizeof(double),
                              *most),
                  "values are in 1/sr over the factor of their channel; is the file damaged?");
  }
  return std::make_shared<HalfAngleTable>(cells, std::move(stored), name);
}

TablePtr read_merl(std::string_view bytes, const std::string& name) {
  return parse_merl(bytes, name, merl_cells);
}

std::string merl_bytes(const brdf::Table& table, const TableWriting& writing,
                       const HalfAngleCells& cells) {
  const std::size_t count = cells.count();
  std::vector<double> sampled;
  std::span<const double> stored;
  const auto* native = dynamic_cast<const HalfAngleTable*>(&table);
  if (native != nullptr && writing.wavelengths_um.empty() &&
      sizes_of(native->cells()) == sizes_of(cells)) {
    stored = native->stored();
  } else {
    const std::array<double, 3> wavelengths = channel_wavelengths(writing);
    // One evaluation serves all channels where they cannot differ.
    const auto* model = dynamic_cast<const ModelTable*>(&table);
    const bool grey = wavelengths[0] == wavelengths[2] || (table.wavelengths_um().size() == 1 &&
                                                           (model == nullptr || !model->shared()));
    sampled.assign(3 * count, -1.0);
    for (std::size_t h = 0; h < cells.theta_h; ++h) {
      for (std::size_t d = 0; d < cells.theta_d; ++d)
        for (std::size_t p = 0; p < cells.phi_d; ++p) {
          HalfAngles angles{};
          if (!sampling_point(cells, h, d, p, angles)) continue;
          const auto geometry = geometry_of(angles);
          const std::size_t cell = (h * cells.theta_d + d) * cells.phi_d + p;
          double value = 0.0;
          for (std::size_t channel = 0; channel < 3; ++channel) {
            if (channel == 0 || !grey)
              value = optics::element(table.at(wavelengths[2 - channel], geometry), 0, 0);
            sampled[channel * count + cell] =
                std::max(value, 0.0) / HalfAngleTable::channel_scale[channel];
          }
        }
      if (writing.progress)
        writing.progress(static_cast<double>(h + 1), static_cast<double>(cells.theta_h));
    }
    stored = sampled;
  }
  const std::array<std::int32_t, 3> sizes = sizes_of(cells);
  std::string bytes(header_bytes + stored.size_bytes(), '\0');
  std::memcpy(bytes.data(), sizes.data(), header_bytes);
  std::memcpy(bytes.data() + header_bytes, stored.data(), stored.size_bytes());
  return bytes;
}

std::string write_merl(const brdf::Table& table, const TableWriting& writing) {
  return merl_bytes(table, writing, merl_cells);
}

}  // namespace umov::formats
