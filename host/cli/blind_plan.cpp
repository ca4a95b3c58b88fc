#include "host/cli/blind_plan.hpp"

#include <charconv>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "host/errors/error.hpp"

namespace umov::cli {
namespace {

plant::Setup setup_of(const std::vector<std::pair<std::string, std::string>>& settings) {
  plant::Setup setup;
  for (const auto& [key, text] : settings) {
    double value = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    if (key == "sample_azimuth_deg") setup.sample_azimuth_deg = value;
    if (key == "iris_fraction") setup.iris_fraction = value;
    if (key == "sample_removed") setup.sample_removed = value != 0.0;
    if (key == "filter") setup.long_pass = text == "long_pass";
  }
  return setup;
}

int laser_of(const scan::Plan& plan, double wavelength_nm) {
  for (std::size_t i = 0; i < plant::laser_count; ++i) {
    if (plant::laser_names[i] == wavelength_nm) return static_cast<int>(i);
  }
  throw Error(Place{plan.name},
              "the case's instrument has no laser of " + std::to_string(wavelength_nm) + " nm",
              "use wavelengths_nm out of 532, 633, 814");
}

int holder_of(const scan::Plan& plan, double density) {
  const int holder = static_cast<int>(std::lround(density));
  if (std::abs(density - holder) > 1e-9 || holder < 0 || holder > 5) {
    throw Error(Place{plan.name},
                "the case's filter wheel has no optical density " + std::to_string(density),
                "use 0, 1, 2, 3, 4 or 5");
  }
  return holder;
}

/// Sense in which the arm comes to row i: along its line, and at a line's start as the line goes
/// on.
int approach(const std::vector<scan::PlanRow>& rows, std::size_t i) {
  const auto same_line = [&](std::size_t a, std::size_t b) {
    return rows[a].theta_i_deg == rows[b].theta_i_deg && rows[a].phi_r_deg == rows[b].phi_r_deg &&
           rows[a].wavelength_index == rows[b].wavelength_index && rows[a].block == rows[b].block;
  };
  double move = i > 0 ? rows[i].theta_r_deg - rows[i - 1].theta_r_deg : 1.0;
  const bool starts = i == 0 || !same_line(i, i - 1) ||
                      rows[i].polarizer_deg != rows[i - 1].polarizer_deg ||
                      rows[i].analyzer_deg != rows[i - 1].analyzer_deg;
  if (starts && i + 1 < rows.size() && same_line(i, i + 1)) {
    move = rows[i + 1].theta_r_deg - rows[i].theta_r_deg;
  }
  return move < 0.0 ? -1 : 1;
}

}  // namespace

std::vector<blind::RowBlock> bench_blocks(const scan::Plan& plan) {
  const scan::Program program = scan::expand(plan);
  std::vector<blind::RowBlock> blocks;
  for (const formats::Block& block : program.blocks) {
    blind::RowBlock one;
    one.name = block.name;
    one.settings = block.settings;
    one.setup = setup_of(block.settings);
    one.white_tile = plan.role == "white";
    for (auto i = static_cast<std::size_t>(block.first); i <= static_cast<std::size_t>(block.last);
         ++i) {
      const scan::PlanRow& row = program.rows[i];
      one.rows.push_back({row.theta_i_deg,
                          row.theta_r_deg,
                          row.phi_r_deg,
                          laser_of(plan, row.wavelength_nm),
                          {row.polarizer_deg, row.analyzer_deg},
                          row.shutter_open,
                          holder_of(plan, row.optical_density),
                          approach(program.rows, i)});
    }
    blocks.push_back(std::move(one));
  }
  return blocks;
}

}  // namespace umov::cli
