// Plans from TOML.
#include <algorithm>
#include <cmath>
#include <string>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/decimal.hpp"
#include "host/scan/plan.hpp"
#include "host/scan/plan_menu.hpp"
#include "host/scan/plan_toml.hpp"
#include "host/toml/parse.hpp"

namespace umov::scan {
namespace {

constexpr Limits incidence_limits{0, 90, "deg"};
constexpr Limits detector_limits{-90, 90, "deg"};
constexpr Limits azimuth_limits{-180, 180, "deg", true};
constexpr Limits axis_limits{-360, 360, "deg"};
constexpr Limits wavelength_limits{100, 20000, "nm"};
constexpr Limits dwell_limits{1, 60000, "ms"};
constexpr Limits density_limits{0, 5, ""};

/// A list of wavelengths where each may stand once only: records are told apart by it.
std::vector<double> without_doubles(PlanTable& table, std::string_view key,
                                    std::vector<double> values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (values[i] == values[j])
        table.fail(*table.toml().get(key), key, formats::decimal_text(values[i]) + " stands twice",
                   "name each value once");
  return values;
}

std::optional<std::vector<double>> distinct(PlanTable& table, std::string_view key,
                                            const Limits& limits) {
  std::optional<std::vector<double>> values = table.numbers(key, limits);
  // Ranges cannot repeat a value, and long lists would be compared for long.
  if (values && values->size() <= 1000) values = without_doubles(table, key, std::move(*values));
  return values;
}

void read_near(PlanTable& angles, DetectorAngles& result) {
  const toml::node* node = angles.find("near");
  if (node == nullptr) return;
  if (!node->is_table())
    angles.fail(*node, "near", "is not a table", "write near = { within_deg = 5, step = 0.5 }");
  PlanTable near(*node->as_table(), angles.file(), angles.full_name("near"));
  const std::optional<double> within = near.number("within_deg", {0, 90, "deg", true});
  const std::optional<double> step = near.number("step", {0, 90, "deg", true});
  near.refuse_unknown();
  if (!within || !step)
    angles.fail(*node, "near", "lacks `within_deg` or `step`",
                "write near = { within_deg = 5, step = 0.5 }");
  if (*within / *step > 50000)
    angles.fail(*node, "near", "gives more than 100000 angles", "take a larger step");
  result.near_within_deg = *within;
  result.near_step_deg = *step;
}

std::optional<DetectorAngles> read_detector_angles(PlanTable& table) {
  constexpr std::string_view key = "theta_r_deg";
  const toml::node* node = table.find(key);
  if (node == nullptr) return std::nullopt;
  DetectorAngles result;
  if (node->is_string()) {
    table.choice(key, {"mirror"});
    result.mirror = true;
  } else if (const toml::table* range = node->as_table()) {
    PlanTable angles(*range, table.file(), table.full_name(key));
    read_near(angles, result);
    const bool near_alone = result.near_within_deg > 0 && range->get("from") == nullptr &&
                            range->get("to") == nullptr && range->get("step") == nullptr;
    if (!near_alone) result.base_deg = angles.range(detector_limits);
    angles.refuse_unknown();
  } else {
    result.base_deg = *table.numbers(key, detector_limits);
  }
  return result;
}

double read_axis(const PlanTable& table, const toml::node& node) {
  if (const std::optional<std::string> name = node.value_exact<std::string>()) {
    if (*name == "P") return 0;
    if (*name == "S") return 90;
    if (*name == "open" || *name == "U") return formats::open_axis;
    table.fail(node, "states", "\"" + *name + "\" is no polarisation",
               "use \"P\", \"S\", \"open\" or degrees from p towards +s");
  }
  return table.checked_number(node, "states", axis_limits);
}

std::optional<std::vector<State>> read_states(PlanTable& table) {
  constexpr const char* remedy = "write states = [[\"P\", \"P\"], [\"P\", \"S\"], [45, \"open\"]]";
  const toml::node* node = table.find("states");
  if (node == nullptr) return std::nullopt;
  const toml::array* list = node->as_array();
  if (list == nullptr) table.fail(*node, "states", "is not a list", remedy);
  if (list->empty()) table.fail(*node, "states", "the list is empty", remedy);
  std::vector<State> states;
  for (const toml::node& item : *list) {
    const toml::array* pair = item.as_array();
    if (pair == nullptr || pair->size() != 2)
      table.fail(item, "states", "a state is a pair of polariser and analyser", remedy);
    states.push_back({read_axis(table, (*pair)[0]), read_axis(table, (*pair)[1])});
  }
  return states;
}

/// What a plan and a block have in common. Keys that are not there leave `grid` as it is.
void read_grid(PlanTable& table, Grid& grid) {
  if (auto values = distinct(table, "wavelengths_nm", wavelength_limits))
    grid.wavelengths_nm = std::move(*values);
  if (auto values = distinct(table, "theta_i_deg", incidence_limits))
    grid.theta_i_deg = std::move(*values);
  if (auto angles = read_detector_angles(table)) grid.theta_r = std::move(*angles);
  if (auto values = distinct(table, "phi_r_deg", azimuth_limits))
    grid.phi_r_deg = std::move(*values);
  if (auto states = read_states(table)) grid.states = std::move(*states);
  if (const auto order = table.choice("order", {"one-way", "reverse", "serpentine", "random"}))
    grid.order = *order == "reverse"      ? Order::reverse
                 : *order == "serpentine" ? Order::serpentine
                 : *order == "random"     ? Order::random
                                          : Order::one_way;
  if (const auto value = table.integer("dwell_ms", dwell_limits))
    grid.dwell_ms = static_cast<int>(*value);
}

void set(MenuBlock& block, const std::string& key, const std::string& value) {
  for (auto& [name, old] : block.settings)
    if (name == key) old = value;
}

/// `reference_dhr = { 532 = 0.99, 633 = 0.99 }`: the keys are wavelengths.
void read_reference_dhr(PlanTable& table, std::vector<std::pair<double, double>>& reference_dhr) {
  constexpr const char* remedy = "write reference_dhr = { 532 = 0.99, 633 = 0.99 }";
  const toml::node* node = table.find("reference_dhr");
  if (node == nullptr) return;
  if (!node->is_table()) table.fail(*node, "reference_dhr", "is not a table", remedy);
  for (const auto& [key, value] : *node->as_table()) {
    double wavelength_nm = 0;
    if (formats::read_decimal(key.str(), wavelength_nm) != nullptr ||
        wavelength_nm < wavelength_limits.lowest || wavelength_nm > wavelength_limits.highest)
      table.fail(value, "reference_dhr",
                 "the key \"" + std::string(key.str()) + "\" is no wavelength in nm", remedy);
    reference_dhr.emplace_back(wavelength_nm,
                               table.checked_number(value, "reference_dhr", {0, 1.2, "", true}));
  }
}

void read_tile(PlanTable& table, WhiteTile& tile) {
  if (const auto sample = table.text("sample")) tile.sample = *sample;
  read_reference_dhr(table, tile.reference_dhr);
  tile.reference_dhr_u = table.number("reference_dhr_u", {0, 1, ""});
  tile.reference_brdf = table.text("reference_brdf");
}

MenuBlock read_block(const toml::node& node, const Plan& plan, std::size_t number) {
  const std::string path = "block[" + std::to_string(number) + "]";
  if (!node.is_table())
    throw Error(Place{plan.name, line_of(node), path}, "is not a table", "write [[block]]");
  PlanTable table(*node.as_table(), plan.name, path);
  const auto menu = table.choice("menu", {menu_names.begin(), menu_names.end()});
  if (!menu)
    throw Error(Place{plan.name, line_of(node), path}, "the key `menu` is missing",
                "name an entry of the menu, such as menu = \"flip\"");
  MenuBlock block = menu_block(*menu, plan.grid);
  block.line = line_of(node);
  read_grid(table, block.grid);
  for (const double wavelength_nm : block.grid.wavelengths_nm) {
    const auto& all = plan.grid.wavelengths_nm;
    if (std::find(all.begin(), all.end(), wavelength_nm) == all.end())
      table.fail(*node.as_table()->get("wavelengths_nm"), "wavelengths_nm",
                 formats::decimal_text(wavelength_nm) + " is none of the plan's wavelengths",
                 "add it to the plan's own list");
  }
  if (const auto value = table.integer("repeats", {1, 1000, ""}))
    block.repeats = static_cast<int>(*value);
  if (*menu == "nd") {
    if (auto steps = table.numbers("optical_density", density_limits))
      block.density_steps = std::move(*steps);
    if (block.density_steps.size() == 1)
      block.settings = {{"optical_density", formats::decimal_text(block.density_steps[0])}};
  } else if (const auto density = table.number("optical_density", density_limits)) {
    block.grid.optical_density = *density;
  }
  if (*menu == "iris")
    if (const auto fraction = table.number("iris_fraction", {0, 1, "of the diameter", true}))
      set(block, "iris_fraction", formats::decimal_text(*fraction));
  if (*menu == "flip")
    if (const auto azimuth = table.number("sample_azimuth_deg", azimuth_limits))
      set(block, "sample_azimuth_deg", formats::decimal_text(*azimuth));
  if (*menu == "white_tile") {
    read_tile(table, block.tile);
    set(block, "sample", block.tile.sample);
  }
  table.refuse_unknown();
  return block;
}

void read_reference(PlanTable& table, Plan& plan) {
  read_reference_dhr(table, plan.reference_dhr);
  plan.reference_dhr_u = table.number("reference_dhr_u", {0, 1, ""});
  plan.reference_brdf = table.text("reference_brdf");
  plan.reference = table.text("reference");
}

void read_gain(PlanTable& table, Plan& plan) {
  const toml::node* node = table.find("gain");
  if (node == nullptr) return;
  if (node->is_string()) {
    table.choice("gain", {"auto"});
    plan.gain = gain_auto;
    return;
  }
  const auto value = *table.integer("gain", {1, 1000, ""});
  if (value != 1 && value != 10 && value != 100 && value != 1000)
    table.fail(*node, "gain", std::to_string(value) + " is no amplifier range",
               "use 1, 10, 100, 1000 or \"auto\"");
  plan.gain = static_cast<int>(value);
}

void require(const Plan& plan, bool there, const char* key, const char* example) {
  if (!there)
    throw Error(Place{plan.name, 0, key}, "the key is missing", std::string("add ") + example);
}

Plan read_plan(const toml::table& root, Plan plan) {
  PlanTable table(root, plan.name, "");
  if (const auto sample = table.text("sample")) plan.sample = *sample;
  if (const auto role = table.choice("role", {"sample", "white", "mirror", "dark"}))
    plan.role = *role;
  plan.grid.phi_r_deg = {0};
  plan.grid.states = {{0, 0},   {0, 90}, {0, formats::open_axis},
                      {90, 90}, {90, 0}, {90, formats::open_axis}};
  read_grid(table, plan.grid);
  if (const auto density = table.number("optical_density", density_limits))
    plan.grid.optical_density = *density;
  if (const auto value = table.number("solid_angle_sr", {0, 1, "sr", true}))
    plan.solid_angle_sr = *value;
  if (const auto value = table.number("reference_hz", {10, 20000, "Hz"}))
    plan.reference_hz = *value;
  if (const auto source = table.choice("reference_source", {"internal", "external"}))
    plan.external_reference = *source == "external";
  if (const auto* node = root.get("reference_hz"); node != nullptr && plan.external_reference) {
    throw Error(Place{plan.name, line_of(*node), "reference_hz"},
                "has no effect on an external reference, which comes as it comes",
                "leave it out, or choose reference_source = \"internal\"");
  }
  if (const auto value = table.integer("settle_ms", {0, 10000, "ms"}))
    plan.settle_ms = static_cast<int>(*value);
  if (const auto value = table.integer("seed", {0, 9e15, ""}))
    plan.seed = static_cast<std::uint64_t>(*value);
  read_gain(table, plan);
  read_reference(table, plan);
  const toml::node* blocks = table.find("block");
  table.refuse_unknown();

  require(plan, !plan.grid.wavelengths_nm.empty(), "wavelengths_nm",
          "wavelengths_nm = [532, 633, 814]");
  require(plan, !plan.grid.theta_i_deg.empty(), "theta_i_deg", "theta_i_deg = [30, 60]");
  require(plan, root.get("theta_r_deg") != nullptr, "theta_r_deg",
          "theta_r_deg = { from = -80, to = 80, step = 2 }");
  if (blocks != nullptr) {
    const toml::array* list = blocks->as_array();
    if (list == nullptr)
      throw Error(Place{plan.name, line_of(*blocks), "block"}, "is not a list of tables",
                  "write [[block]] with two pairs of brackets");
    for (const toml::node& node : *list)
      plan.blocks.push_back(read_block(node, plan, plan.blocks.size()));
  }
  row_count(plan);
  return plan;
}

}  // namespace

Plan parse_plan(std::string_view text, const std::string& name) {
  Plan plan;
  plan.name = name;
  plan.text = text;
  const toml::table root = parse_toml(text, name, "see the plans in examples/plans");
  return read_plan(root, std::move(plan));
}

Plan load_plan(const std::filesystem::path& path) {
  return parse_plan(formats::read_whole_file(path), path.string());
}

}  // namespace umov::scan
