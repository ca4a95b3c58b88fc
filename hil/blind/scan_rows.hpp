// What a case's scans ask for: the plan's grid, its blocks, and rows in the order they are taken.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hil/plant/collection.hpp"

namespace umov::blind {

/// Polariser and analyser in degrees from p towards s, NaN = open.
struct State {
  double polarizer_deg = 0.0, analyzer_deg = 0.0;
};

struct Row {
  double theta_i_deg = 0.0, theta_r_deg = 0.0, phi_r_deg = 0.0;
  int laser = 0;  ///< index into plant::laser_names
  State state;
  bool shutter_open = true;
  int density = 0;   ///< holder of the filter wheel
  int approach = 1;  ///< sense in which the detector arm arrives, ±1
};

/// Rows taken with one arrangement of the instrument.
struct RowBlock {
  std::string name;                                           ///< "main" or a menu identifier
  std::vector<std::pair<std::string, std::string>> settings;  ///< as in the `# block:` line
  plant::Setup setup;
  bool white_tile = false;
  std::vector<Row> rows;
};

enum class Style { one_way, serpentine, pm45, full };
inline constexpr std::array<std::string_view, 4> style_names = {"one-way", "serpentine", "pm45",
                                                                "full"};

/// The grid of a case's own scan. Every line is one state at one wavelength and incidence.
struct CasePlan {
  Style style = Style::one_way;
  std::vector<double> theta_i_deg;
  double theta_r_from_deg = -80.0, theta_r_to_deg = 80.0, theta_r_step_deg = 2.0;
  std::vector<State> states;
};

/// Blocks of the case's own scan: "main", then what the style adds.
std::vector<RowBlock> own_blocks(const CasePlan& plan);

/// The further scans that may be asked for.
inline constexpr std::array<std::string_view, 12> menu_names = {
    "reverse", "serpentine", "flip",       "pm45",   "shutter",   "nd",
    "iris",    "oop",        "white_tile", "repeat", "long_pass", "no_sample"};

/// One of `menu_names` for this plan. Throws umov::Error for another name.
RowBlock menu_block(const CasePlan& plan, std::string_view menu);

}  // namespace umov::blind
