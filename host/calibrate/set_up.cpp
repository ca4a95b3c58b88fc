#include "host/calibrate/set_up.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include <fmt/format.h>

#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

constexpr std::array<std::string_view, 7> plain_blocks = {"main",    "repeat", "oop", "serpentine",
                                                          "reverse", "nd",     "pm45"};

/// A setting that leaves the light path as it was calibrated.
bool is_neutral(const std::string& key, const std::string& value) {
  if (key == "optical_density") return true;
  const double number = std::strtod(value.c_str(), nullptr);
  if (key == "sample_azimuth_deg") return std::remainder(number, 360.0) == 0.0;
  if (key == "iris_fraction") return number == 1.0;
  if (key == "sample_removed") return number == 0.0;
  return key != "filter" && key != "retarder_deg";
}

RowUse use_of(const formats::Block& block) {
  if (block.name == "shutter") return RowUse::closed;
  for (const auto& [key, value] : block.settings)
    if (!is_neutral(key, value)) return RowUse::changed;
  const bool plain =
      std::find(plain_blocks.begin(), plain_blocks.end(), block.name) != plain_blocks.end();
  return plain ? RowUse::plain : RowUse::changed;
}

}  // namespace

ScanRows sort_rows(const formats::ScanTable& scan) {
  ScanRows result;
  result.row.assign(scan.size(), RowUse::plain);
  result.block.assign(scan.size(), -1);
  for (std::size_t b = 0; b < scan.blocks.size(); ++b) {
    const formats::Block& block = scan.blocks[b];
    const RowUse use = use_of(block);
    std::size_t rows = 0;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (scan.index[i] < block.first || scan.index[i] > block.last) continue;
      result.row[i] = use;
      result.block[i] = static_cast<int>(b);
      ++rows;
    }
    if (rows == 0) continue;
    if (use == RowUse::changed)
      result.notes.push_back(
          fmt::format("block `{}` (records {}-{}) has a changed set-up and is left out", block.name,
                      block.first, block.last));
    if (block.name == "nd")
      result.notes.push_back(
          fmt::format("block `nd` (records {}-{}) is kept: the monitor sees the filter",
                      block.first, block.last));
  }
  // The column speaks for single rows outside of a block of that name.
  for (std::size_t i = 0; i < scan.size(); ++i)
    if (scan.shutter_open[i] == 0) result.row[i] = RowUse::closed;
  for (std::size_t i = 0; i < scan.size(); ++i)
    if (result.row[i] == RowUse::closed && scan.shutter_open[i] != 0)
      result.row[i] = RowUse::changed;  // a `shutter` block whose shutter was open is neither
  return result;
}

double from_retro_deg(double theta_i_deg, double theta_r_deg, double phi_r_deg) {
  const double i = optics::radians(theta_i_deg), r = optics::radians(theta_r_deg);
  const double cosine =
      std::cos(i) * std::cos(r) - std::sin(i) * std::sin(r) * std::cos(optics::radians(phi_r_deg));
  return optics::degrees(std::acos(std::clamp(cosine, -1.0, 1.0)));
}

}  // namespace umov::calibrate
