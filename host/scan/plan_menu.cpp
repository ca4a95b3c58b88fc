#include "host/scan/plan_menu.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace umov::scan {
namespace {

constexpr double densest_filter = 5;

std::vector<double> representative_incidences(const std::vector<double>& all) {
  if (all.size() <= 2) return all;
  return {all[1], all.back()};
}

std::vector<State> parallel_states(const std::vector<State>& all) {
  std::vector<State> parallel;
  std::copy_if(all.begin(), all.end(), std::back_inserter(parallel),
               [](const State& s) { return s.polarizer_deg == s.analyzer_deg; });
  if (parallel.empty() && !all.empty()) parallel.push_back(all.front());
  return parallel;
}

/// Every n-th detector angle of the grid.
DetectorAngles thinned(DetectorAngles angles, std::size_t n) {
  std::vector<double> kept;
  for (std::size_t i = 0; i < angles.base_deg.size(); i += n) kept.push_back(angles.base_deg[i]);
  angles.base_deg = std::move(kept);
  return angles;
}

/// The same without the finer part, which costs more rows than a slow quantity is worth.
DetectorAngles coarse(const DetectorAngles& angles, std::size_t n) {
  DetectorAngles result = thinned(angles, n);
  if (result.base_deg.empty()) return angles;  // the plan has nothing but the mirror direction
  result.near_within_deg = 0;
  result.mirror = false;
  return result;
}

/// About `count` angles of the grid.
DetectorAngles few(const DetectorAngles& angles, std::size_t count) {
  return coarse(angles, std::max<std::size_t>(1, (angles.base_deg.size() + count - 1) / count));
}

/// Angles of the grid nearest to -20 and +20 deg: diffuse light on both sides, clear of most lobes.
DetectorAngles reference_points(const DetectorAngles& angles) {
  if (angles.base_deg.empty()) return angles;
  DetectorAngles result;
  for (const double wanted : {-20.0, 20.0}) {
    const double nearest = *std::min_element(
        angles.base_deg.begin(), angles.base_deg.end(),
        [wanted](double a, double b) { return std::abs(a - wanted) < std::abs(b - wanted); });
    if (result.base_deg.empty() || result.base_deg.back() != nearest)
      result.base_deg.push_back(nearest);
  }
  return result;
}

void out_of_plane(Grid& grid) {
  grid.phi_r_deg = {30, 90, 150};
  grid.theta_r = DetectorAngles{};
  for (int theta_r_deg = 5; theta_r_deg <= 80; theta_r_deg += 5)
    grid.theta_r.base_deg.push_back(theta_r_deg);
}

}  // namespace

MenuBlock menu_block(std::string_view menu, const Grid& plan_grid) {
  MenuBlock block;
  block.menu = menu;
  block.grid = plan_grid;
  Grid& grid = block.grid;
  grid.phi_r_deg = {0};
  grid.theta_i_deg = representative_incidences(plan_grid.theta_i_deg);
  grid.states = parallel_states(plan_grid.states);

  if (menu == "reverse") {
    grid.order = Order::reverse;
  } else if (menu == "serpentine") {
    grid.order = Order::serpentine;
  } else if (menu == "flip") {
    grid.theta_r = thinned(plan_grid.theta_r, 2);
    block.settings = {{"sample_azimuth_deg", "180"}};
  } else if (menu == "pm45") {
    grid.theta_r = thinned(plan_grid.theta_r, 2);
    grid.states = {{45, 45}, {45, -45}, {0, 45}, {0, -45}, {90, 45}};
  } else if (menu == "shutter") {
    grid.theta_i_deg = {grid.theta_i_deg.front()};
    grid.theta_r = few(plan_grid.theta_r, 20);
    grid.states.resize(1);
    block.shutter_open = false;
  } else if (menu == "nd") {
    grid.theta_i_deg = {grid.theta_i_deg.back()};
    grid.theta_r = few(plan_grid.theta_r, 11);
    grid.theta_r.mirror = true;  // the strongest signal tells most about linearity
    grid.states = {grid.states.back()};
    for (const double added : {0.0, 1.0, 2.0})
      if (plan_grid.optical_density + added <= densest_filter)
        block.density_steps.push_back(plan_grid.optical_density + added);
  } else if (menu == "iris") {
    block.settings = {{"iris_fraction", "0.5"}};
  } else if (menu == "oop") {
    out_of_plane(grid);
  } else if (menu == "white_tile") {
    grid.theta_i_deg = plan_grid.theta_i_deg;
    grid.theta_r = few(plan_grid.theta_r, 20);
    block.settings = {{"sample", block.tile.sample}};
  } else if (menu == "repeat") {
    grid.theta_i_deg = {grid.theta_i_deg.front()};
    grid.theta_r = reference_points(plan_grid.theta_r);
    grid.states.resize(1);
    block.repeats = 8;
  } else if (menu == "long_pass") {
    grid.theta_r = coarse(plan_grid.theta_r, 2);
    block.settings = {{"filter", "long_pass"}};
  } else if (menu == "no_sample") {
    grid.theta_r = coarse(plan_grid.theta_r, 2);
    block.settings = {{"sample_removed", "1"}};
  }
  return block;
}

}  // namespace umov::scan
