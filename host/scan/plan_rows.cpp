// From a plan to the rows the controller measures.
#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "host/errors/error.hpp"
#include "host/formats/crc32c.hpp"
#include "host/formats/decimal.hpp"
#include "host/scan/plan.hpp"

namespace umov::scan {
namespace {

/// The controller's angles are whole microdegrees.
double microdegree(double deg) {
  return std::round(deg * 1e6) / 1e6 + 0.0;
}

/// SplitMix64: the same shuffle on every machine and with every standard library.
class Shuffler {
 public:
  explicit Shuffler(std::uint64_t seed) : state_(seed) {}
  template <class T>
  void shuffle(std::span<T> items) {
    for (std::size_t left = items.size(); left > 1; --left)
      std::swap(items[left - 1], items[static_cast<std::size_t>(next() % left)]);
  }

 private:
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

MenuBlock main_block(const Plan& plan) {
  MenuBlock block;
  block.menu = "main";
  block.grid = plan.grid;
  return block;
}

std::vector<double> densities(const MenuBlock& block) {
  if (!block.density_steps.empty()) return block.density_steps;
  return {block.grid.optical_density};
}

/// Rows of a block, or any number above `max_plan_rows` as soon as that is passed.
std::size_t count_rows(const MenuBlock& block) {
  const Grid& grid = block.grid;
  const double others = static_cast<double>(grid.wavelengths_nm.size()) *
                        static_cast<double>(grid.states.size()) *
                        static_cast<double>(densities(block).size()) * block.repeats;
  double points = 0;
  for (const double theta_i_deg : grid.theta_i_deg)
    for (const double phi_r_deg : grid.phi_r_deg) {
      points += static_cast<double>(grid.theta_r.line(theta_i_deg, phi_r_deg).size());
      if (points * others > static_cast<double>(max_plan_rows)) return max_plan_rows + 1;
    }
  return static_cast<std::size_t>(points * others);
}

class Expansion {
 public:
  Expansion(const Plan& plan, Program& program) : plan_(plan), program_(program) {}

  void add(const MenuBlock& block) {
    const auto first = static_cast<std::int64_t>(program_.rows.size());
    lines_ = 0;
    for (int repeat = 0; repeat < block.repeats; ++repeat)
      for (const double density : densities(block)) add_grid(block, density);
    const auto last = static_cast<std::int64_t>(program_.rows.size()) - 1;
    program_.blocks.push_back({block.menu, first, last, block.settings});
  }

 private:
  void add_grid(const MenuBlock& block, double density) {
    const Grid& grid = block.grid;
    PlanRow row;
    row.shutter_open = block.shutter_open;
    row.optical_density = density;
    row.gain = plan_.gain;
    row.dwell_ms = grid.dwell_ms;
    row.block = static_cast<int>(program_.blocks.size());
    for (const double wavelength_nm : grid.wavelengths_nm) {
      const auto& all = plan_.grid.wavelengths_nm;
      row.wavelength_nm = wavelength_nm;
      row.wavelength_index =
          static_cast<int>(std::find(all.begin(), all.end(), wavelength_nm) - all.begin());
      for (const double theta_i_deg : grid.theta_i_deg)
        for (const double phi_r_deg : grid.phi_r_deg) {
          row.theta_i_deg = theta_i_deg;
          row.phi_r_deg = phi_r_deg;
          add_lines(grid, row);
        }
    }
  }

  /// All states at one wavelength, incidence and azimuth.
  void add_lines(const Grid& grid, PlanRow row) {
    std::vector<double> line = grid.theta_r.line(row.theta_i_deg, row.phi_r_deg);
    const std::size_t start = program_.rows.size();
    for (const State& state : grid.states) {
      row.polarizer_deg = state.polarizer_deg;
      row.analyzer_deg = state.analyzer_deg;
      const bool down =
          grid.order == Order::reverse || (grid.order == Order::serpentine && lines_ % 2 == 1);
      ++lines_;
      for (std::size_t i = 0; i < line.size(); ++i) {
        row.theta_r_deg = down ? line[line.size() - 1 - i] : line[i];
        program_.rows.push_back(row);
      }
    }
    if (grid.order == Order::random)
      shuffler_.shuffle(std::span<PlanRow>(program_.rows).subspan(start));
  }

  const Plan& plan_;
  Program& program_;
  Shuffler shuffler_{plan_.seed};
  std::size_t lines_ = 0;
};

}  // namespace

std::vector<double> DetectorAngles::line(double theta_i_deg, double phi_r_deg) const {
  std::vector<double> angles;
  if (phi_r_deg != 0) {
    for (const double angle : base_deg)
      if (angle >= 0) angles.push_back(angle);
  } else {
    angles = base_deg;
    const auto within_travel = [](double angle) { return angle >= -90 && angle <= 90; };
    if (mirror) angles.push_back(theta_i_deg);
    if (near_within_deg > 0) {
      const int steps = static_cast<int>(std::floor(near_within_deg / near_step_deg + 1e-9));
      for (int i = -steps; i <= steps; ++i)
        if (const double angle = microdegree(theta_i_deg + i * near_step_deg); within_travel(angle))
          angles.push_back(angle);
    }
  }
  std::sort(angles.begin(), angles.end());
  angles.erase(std::unique(angles.begin(), angles.end()), angles.end());
  return angles;
}

std::size_t row_count(const Plan& plan) {
  std::size_t total = plan.main ? count_rows(main_block(plan)) : 0;
  if (plan.main && total == 0)
    throw Error(Place{plan.name}, "the plan has no rows",
                "out of plane (phi_r_deg not 0) it needs theta_r_deg from 0 up");
  for (const MenuBlock& block : plan.blocks) {
    const std::size_t rows = count_rows(block);
    if (rows == 0)
      throw Error(Place{plan.name, block.line}, "block `" + block.menu + "` has no rows",
                  "out of plane (phi_r_deg not 0) it needs theta_r_deg from 0 up");
    total += rows;
    if (total > max_plan_rows) break;
  }
  if (total > max_plan_rows)
    throw Error(Place{plan.name},
                "the plan asks for more than " + std::to_string(max_plan_rows) + " rows",
                "take larger steps, fewer angles, or several plans");
  return total;
}

Program expand(const Plan& plan) {
  Program program;
  program.rows.reserve(row_count(plan));
  Expansion expansion(plan, program);
  if (plan.main) expansion.add(main_block(plan));
  for (const MenuBlock& block : plan.blocks) expansion.add(block);
  return program;
}

std::vector<PlanRow> rows(const Plan& plan) {
  return expand(plan).rows;
}

std::vector<std::pair<std::string, std::string>> header_keys(const Plan& plan) {
  using formats::decimal_text;
  std::vector<std::pair<std::string, std::string>> keys = {
      {"format", "umov scan csv"},
      {"sample", plan.sample},
      {"role", plan.role},
      {"solid_angle_sr", decimal_text(plan.solid_angle_sr)}};
  for (const auto& [wavelength_nm, dhr] : plan.reference_dhr)
    keys.emplace_back("reference_dhr_" + decimal_text(wavelength_nm), decimal_text(dhr));
  if (plan.reference_dhr_u)
    keys.emplace_back("reference_dhr_u", decimal_text(*plan.reference_dhr_u));
  if (plan.reference_brdf) keys.emplace_back("reference_brdf", *plan.reference_brdf);
  if (plan.reference) keys.emplace_back("reference", *plan.reference);
  return keys;
}

std::uint32_t program_id(const Plan& plan) {
  std::string meaning;
  const auto add = [&meaning](double value) {
    formats::append_shortest(meaning, value);
    meaning += ' ';
  };
  for (const auto& [key, value] : header_keys(plan)) meaning += key + '=' + value + '\n';
  add(plan.reference_hz);
  if (plan.external_reference) meaning += "external reference ";
  add(plan.settle_ms);
  const Program program = expand(plan);
  for (const formats::Block& block : program.blocks) {
    meaning += block.name + ' ';
    for (const auto& [key, value] : block.settings) meaning += key + '=' + value + ' ';
  }
  for (const PlanRow& row : program.rows)
    for (const double value : {row.theta_i_deg, row.theta_r_deg, row.phi_r_deg, row.wavelength_nm,
                               row.polarizer_deg, row.analyzer_deg, row.shutter_open ? 1.0 : 0.0,
                               row.optical_density, static_cast<double>(row.gain),
                               static_cast<double>(row.dwell_ms), static_cast<double>(row.block)}) {
      add(value);
      // Folded from time to time: the text of millions of rows need not be held.
      if (meaning.size() > 1 << 20)
        meaning = std::to_string(formats::crc32c(std::as_bytes(std::span(meaning)))) + ' ';
    }
  const std::uint32_t id = formats::crc32c(std::as_bytes(std::span(meaning)));
  return id == 0 ? 1 : id;
}

}  // namespace umov::scan
