// A scan plan (TOML) and the rows it expands to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/formats/scan_table.hpp"

namespace umov::scan {

/// A plan that asks for more is refused.
inline constexpr std::size_t max_plan_rows = 5'000'000;
/// Amplifier range: choose automatically.
inline constexpr int gain_auto = 0;

/// one_way: every line of detector angles upwards. reverse: downwards. serpentine: every second
/// line downwards. random: detector angles and states shuffled together at each wavelength,
/// incidence and azimuth (seeded), so that drift in time separates from both at the cost of longer
/// moves.
enum class Order { one_way, reverse, serpentine, random };

/// Polariser and analyser axes in degrees from p towards +s, NaN = open ("open" or "U").
struct State {
  double polarizer_deg = 0;
  double analyzer_deg = 0;
};

/// Detector angles: a grid, and for each in-plane line a finer one about the mirror direction
/// theta_r = theta_i.
struct DetectorAngles {
  std::vector<double> base_deg;  ///< may be empty where `near` or `mirror` gives the angles
  double near_within_deg = 0;    ///< half width of the finer part, 0 = none
  double near_step_deg = 0;
  bool mirror = false;  ///< the mirror direction itself belongs to the line

  /// Ascending angles of one line, degrees. Out of plane (phi_r not 0) those of the grid from 0 up.
  std::vector<double> line(double theta_i_deg, double phi_r_deg) const;
};

/// The grid that rows are made from: the plan's own, or a block's.
struct Grid {
  std::vector<double> wavelengths_nm;
  std::vector<double> theta_i_deg;  ///< 0 to 90
  DetectorAngles theta_r;           ///< -90 to 90; negative ones only where phi_r = 0
  std::vector<double> phi_r_deg;    ///< (-180, 180]
  std::vector<State> states;
  Order order = Order::one_way;
  int dwell_ms = 50;
  double optical_density = 0;  ///< neutral density in the beam, 0 to 5
};

/// The white tile of a block `white_tile`, with what is known of it.
struct WhiteTile {
  std::string sample = "white-99";
  std::vector<std::pair<double, double>> reference_dhr;  ///< as in Plan
  std::optional<double> reference_dhr_u;
  std::optional<std::string> reference_brdf;
};

/// An entry `[[block]]`: rows of the menu of further scans, taken with something changed.
struct MenuBlock {
  std::string menu;          ///< identifier such as "flip"
  Grid grid;                 ///< the menu's default thinning of the plan, or what the entry says
  int repeats = 1;           ///< the whole block, one after the other
  bool shutter_open = true;  ///< closed in `shutter`
  std::vector<double> density_steps;  ///< `nd` only: total optical densities, one after the other
  std::vector<std::pair<std::string, std::string>> settings;  ///< of the `# block:` line
  WhiteTile tile;                                             ///< `white_tile` only
  std::size_t line = 0;                                       ///< in the plan file
};

struct Plan {
  std::string name;  ///< file or stream it came from
  std::string text;  ///< the TOML itself, kept as provenance
  std::string sample = "sample";
  std::string role = "sample";  ///< sample, white, mirror or dark
  Grid grid;
  bool main = true;  ///< the plan's own grid is measured; false: its blocks alone
  std::vector<MenuBlock> blocks;
  int gain = gain_auto;             ///< 1, 10, 100, 1000 or gain_auto
  double solid_angle_sr = 1e-4;     ///< detector aperture seen from the sample
  double reference_hz = 1000;       ///< modulation; of no effect with an external reference
  bool external_reference = false;  ///< detection against the reference input
  int settle_ms = 20;               ///< wait after moves before integrating
  std::uint64_t seed = 1;           ///< of the random order
  /// White standard: DHR by wavelength (nm), its one-sigma uncertainty (absolute), a BRDF file.
  std::vector<std::pair<double, double>> reference_dhr;
  std::optional<double> reference_dhr_u;
  std::optional<std::string> reference_brdf;
  std::optional<std::string> reference;  ///< white-tile scan this sample refers to
};

/// One lock-in record to take, as commanded.
struct PlanRow {
  double theta_i_deg = 0, theta_r_deg = 0, phi_r_deg = 0;
  double wavelength_nm = 0;
  int wavelength_index = 0;                    ///< in plan.grid.wavelengths_nm
  double polarizer_deg = 0, analyzer_deg = 0;  ///< NaN = open
  bool shutter_open = true;
  double optical_density = 0;
  int gain = gain_auto;
  int dwell_ms = 50;
  int block = 0;  ///< in Program::blocks
};

/// Rows in the order they are measured; row i has record index i. `blocks[0]` is "main" unless the
/// plan leaves its own grid out.
struct Program {
  std::vector<PlanRow> rows;
  std::vector<formats::Block> blocks;
};

/// Throws umov::Error with file and line for text that is not TOML, unknown keys (with the nearest
/// known one), wrong types, empty lists, values outside the limits and plans of too many rows.
Plan load_plan(const std::filesystem::path& path);
Plan parse_plan(std::string_view text, const std::string& name);

/// Number of rows without making them. Throws as `expand` does.
std::size_t row_count(const Plan& plan);
/// Order, slowest first: block, wavelength, incidence, azimuth, state, detector angle.
Program expand(const Plan& plan);
std::vector<PlanRow> rows(const Plan& plan);

/// Keys a scan of this plan carries: sample, role, solid_angle_sr, reference_dhr_<nm> …
std::vector<std::pair<std::string, std::string>> header_keys(const Plan& plan);
/// Hash of the plan's meaning (rows and keys), never 0: a resumed scan must have the same.
std::uint32_t program_id(const Plan& plan);

}  // namespace umov::scan
