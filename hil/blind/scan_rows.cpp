#include "hil/blind/scan_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/errors/error.hpp"

namespace umov::blind {
namespace {

enum class Order { up, down, alternating };

struct Grid {
  std::vector<double> theta_i_deg, theta_r_deg, phi_r_deg{0.0};
  std::vector<State> states;
  Order order = Order::up;
  std::vector<int> densities{0};
  int repeats = 1;
  bool shutter_open = true;
  bool with_mirror_direction = false;
};

std::vector<double> detector_angles(const CasePlan& plan, int stride = 1) {
  std::vector<double> angles;
  const auto count = static_cast<int>(
      std::floor((plan.theta_r_to_deg - plan.theta_r_from_deg) / plan.theta_r_step_deg + 1e-9));
  for (int i = 0; i <= count; i += stride) {
    angles.push_back(plan.theta_r_from_deg + plan.theta_r_step_deg * i);
  }
  return angles;
}

/// About this many of the plan's detector angles.
std::vector<double> few_angles(const CasePlan& plan, std::size_t count) {
  const std::size_t all = detector_angles(plan).size();
  return detector_angles(plan, static_cast<int>(std::max<std::size_t>(1, all / count)));
}

/// A grazing and a steeper incidence stand for the rest.
std::vector<double> two_incidences(const CasePlan& plan) {
  if (plan.theta_i_deg.size() <= 2) return plan.theta_i_deg;
  return {plan.theta_i_deg[1], plan.theta_i_deg.back()};
}

std::vector<State> parallel_states(const CasePlan& plan) {
  std::vector<State> states;
  for (const State& s : plan.states) {
    if (s.polarizer_deg == s.analyzer_deg) states.push_back(s);
  }
  if (states.empty()) states.push_back(plan.states.front());
  return states;
}

std::vector<Row> rows_of(const Grid& grid) {
  std::vector<Row> rows;
  std::size_t line = 0;
  for (int repeat = 0; repeat < grid.repeats; ++repeat) {
    for (const int density : grid.densities) {
      for (int laser = 0; laser < plant::laser_count; ++laser) {
        for (const double theta_i : grid.theta_i_deg) {
          for (const double phi : grid.phi_r_deg) {
            std::vector<double> angles = grid.theta_r_deg;
            if (grid.with_mirror_direction) angles.push_back(theta_i);
            std::sort(angles.begin(), angles.end());
            angles.erase(std::unique(angles.begin(), angles.end()), angles.end());
            for (const State& state : grid.states) {
              const bool down =
                  grid.order == Order::down || (grid.order == Order::alternating && line % 2 == 1);
              ++line;
              for (std::size_t i = 0; i < angles.size(); ++i) {
                const double theta_r = down ? angles[angles.size() - 1 - i] : angles[i];
                if (phi != 0.0 && theta_r < 0.0) continue;
                rows.push_back({theta_i, theta_r, phi, laser, state, grid.shutter_open, density,
                                down ? -1 : 1});
              }
            }
          }
        }
      }
    }
  }
  return rows;
}

Grid plan_grid(const CasePlan& plan) {
  Grid grid;
  grid.theta_i_deg = plan.theta_i_deg;
  grid.theta_r_deg = detector_angles(plan);
  grid.states = plan.states;
  return grid;
}

std::vector<State> pm45_states() {
  return {{45, 45}, {45, -45}, {0, 45}, {0, -45}, {90, 45}};
}

}  // namespace

std::vector<RowBlock> own_blocks(const CasePlan& plan) {
  Grid grid = plan_grid(plan);
  if (plan.style == Style::serpentine || plan.style == Style::full) grid.order = Order::alternating;
  std::vector<RowBlock> blocks(1);
  blocks[0].name = "main";
  blocks[0].rows = rows_of(grid);
  if (plan.style == Style::pm45) blocks.push_back(menu_block(plan, "pm45"));
  if (plan.style == Style::full) {
    for (const char* menu : {"pm45", "flip", "shutter", "oop", "nd", "repeat", "long_pass"})
      blocks.push_back(menu_block(plan, menu));
  }
  return blocks;
}

RowBlock menu_block(const CasePlan& plan, std::string_view menu) {
  RowBlock block;
  block.name = menu;
  Grid grid = plan_grid(plan);
  grid.theta_i_deg = two_incidences(plan);
  grid.states = parallel_states(plan);
  if (menu == "reverse") {
    grid.order = Order::down;
  } else if (menu == "serpentine") {
    grid.order = Order::alternating;
  } else if (menu == "flip") {
    grid.theta_r_deg = detector_angles(plan, 2);
    block.settings = {{"sample_azimuth_deg", "180"}};
    block.setup.sample_azimuth_deg = 180.0;
  } else if (menu == "pm45") {
    grid.theta_r_deg = detector_angles(plan, 2);
    grid.states = pm45_states();
  } else if (menu == "shutter") {
    grid.theta_i_deg.resize(1);
    grid.theta_r_deg = few_angles(plan, 20);
    grid.states.resize(1);
    grid.shutter_open = false;
  } else if (menu == "nd") {
    grid.theta_i_deg = {grid.theta_i_deg.back()};
    grid.theta_r_deg = few_angles(plan, 11);
    grid.states = {grid.states.back()};
    grid.densities = {0, 1, 2};
    grid.with_mirror_direction = true;
  } else if (menu == "iris") {
    block.settings = {{"iris_fraction", "0.5"}};
    block.setup.iris_fraction = 0.5;
  } else if (menu == "oop") {
    grid.phi_r_deg = {30, 90, 150};
    grid.theta_r_deg.clear();
    for (int theta = 5; theta <= 80; theta += 5) grid.theta_r_deg.push_back(theta);
  } else if (menu == "white_tile") {
    grid.theta_i_deg = plan.theta_i_deg;
    grid.theta_r_deg = few_angles(plan, 20);
    block.white_tile = true;
  } else if (menu == "repeat") {
    grid.theta_i_deg.resize(1);
    grid.theta_r_deg = {-20, 20};
    grid.states.resize(1);
    grid.repeats = 8;
  } else if (menu == "long_pass") {
    grid.theta_r_deg = detector_angles(plan, 4);
    block.settings = {{"filter", "long_pass"}};
    block.setup.long_pass = true;
  } else if (menu == "no_sample") {
    grid.theta_r_deg = detector_angles(plan, 2);
    block.settings = {{"sample_removed", "1"}};
    block.setup.sample_removed = true;
  } else {
    std::string names;
    for (const auto name : menu_names) names += (names.empty() ? "" : ", ") + std::string(name);
    throw Error("no further scan is called \"" + std::string(menu) + "\"", "the menu has " + names);
  }
  block.rows = rows_of(grid);
  return block;
}

}  // namespace umov::blind
