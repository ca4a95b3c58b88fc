#include "hil/blind/truth_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <limits>
#include <sstream>

#include <nlohmann/json.hpp>

#include "hil/plant/parameter_list.hpp"
#include "hil/plant/parameter_setting.hpp"
#include "host/errors/error.hpp"

namespace umov::blind {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* format_name = "umov blind truth 1";

Json axis_json(double axis_deg) {
  return std::isnan(axis_deg) ? Json("open") : Json(axis_deg);
}

double axis_from(const Json& json) {
  return json.is_string() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

Json effect_json(const Effect& effect) {
  Json parameters = Json::object();
  for (const auto& [name, value] : effect.parameters) parameters[name] = value;
  return {{"effect", effect.name},       {"in_catalogue", effect.in_catalogue},
          {"enlarged", effect.enlarged}, {"parameters", parameters},
          {"rho", effect.rho},           {"rho_given_others", effect.rho_given_others}};
}

Effect effect_from(const Json& json) {
  Effect effect;
  effect.name = json.at("effect").get<std::string>();
  effect.in_catalogue = json.at("in_catalogue").get<bool>();
  effect.enlarged = json.at("enlarged").get<bool>();
  for (const auto& [name, value] : json.at("parameters").items()) {
    effect.parameters.emplace_back(name, value.get<double>());
  }
  effect.rho = json.at("rho").get<double>();
  effect.rho_given_others = json.at("rho_given_others").get<double>();
  return effect;
}

Json material_json(const Material& material) {
  Json texts = Json::object();
  for (const auto& [key, value] : material.texts) texts[key] = value;
  Json numbers = Json::object();
  for (const auto& [key, values] : material.numbers) numbers[key] = values;
  return {{"family", material.family}, {"one_gaussian_lobe", material.one_gaussian_lobe},
          {"kind", material.kind},     {"texts", texts},
          {"numbers", numbers},        {"toml", material.toml()}};
}

Material material_from(const Json& json) {
  Material material;
  material.family = json.at("family").get<std::string>();
  material.one_gaussian_lobe = json.at("one_gaussian_lobe").get<bool>();
  material.kind = json.at("kind").get<std::string>();
  for (const auto& [key, value] : json.at("texts").items()) {
    material.texts.emplace_back(key, value.get<std::string>());
  }
  for (const auto& [key, values] : json.at("numbers").items()) {
    material.numbers.emplace_back(key, values.get<std::vector<double>>());
  }
  return material;
}

Json plan_json(const CasePlan& plan) {
  Json states = Json::array();
  for (const State& s : plan.states) {
    states.push_back({axis_json(s.polarizer_deg), axis_json(s.analyzer_deg)});
  }
  Json blocks = Json::array();
  for (const RowBlock& block : own_blocks(plan)) blocks.push_back(block.name);
  return {{"style", style_names[static_cast<std::size_t>(plan.style)]},
          {"wavelengths_nm", plant::laser_names},
          {"theta_i_deg", plan.theta_i_deg},
          {"theta_r_from_deg", plan.theta_r_from_deg},
          {"theta_r_to_deg", plan.theta_r_to_deg},
          {"theta_r_step_deg", plan.theta_r_step_deg},
          {"states", states},
          {"blocks", blocks}};
}

CasePlan plan_from(const Json& json) {
  CasePlan plan;
  const auto style = json.at("style").get<std::string>();
  const auto found = std::find(style_names.begin(), style_names.end(), style);
  if (found == style_names.end()) throw Error("unknown style of plan \"" + style + "\"", "");
  plan.style = static_cast<Style>(found - style_names.begin());
  plan.theta_i_deg = json.at("theta_i_deg").get<std::vector<double>>();
  plan.theta_r_from_deg = json.at("theta_r_from_deg").get<double>();
  plan.theta_r_to_deg = json.at("theta_r_to_deg").get<double>();
  plan.theta_r_step_deg = json.at("theta_r_step_deg").get<double>();
  for (const Json& state : json.at("states")) {
    plan.states.push_back({axis_from(state.at(0)), axis_from(state.at(1))});
  }
  return plan;
}

Json plant_json(plant::PlantConfig config) {
  plant::PlantConfig ideal = plant::ideal_config();
  const auto here = plant::parameters(config);
  const auto there = plant::parameters(ideal);
  Json changed = Json::object();
  for (std::size_t i = 0; i < here.size(); ++i) {
    if (*here[i].value != *there[i].value) changed[here[i].name] = *here[i].value;
  }
  return changed;
}

Json case_json(const CaseTruth& truth) {
  Json effects = Json::array();
  for (const Effect& effect : truth.effects) effects.push_back(effect_json(effect));
  Json alike = Json::array();
  for (const LookAlike& one : truth.look_alikes) {
    alike.push_back({{"effect", one.effect}, {"rho_left", one.rho_left}});
  }
  return {{"case", truth.name},
          {"class", name_of(truth.kind)},
          {"effects", effects},
          {"rho", truth.rho},
          {"look_alikes", alike},
          {"material", material_json(truth.material)},
          {"rho_beyond_one_gaussian_lobe", truth.rho_beyond_one_gaussian_lobe},
          {"plan", plan_json(truth.plan)},
          {"records", truth.records},
          {"noise", {{"relative", truth.relative_noise}, {"additive_v", truth.additive_noise_v}}},
          {"plant", plant_json(truth.config)},
          {"stated_gain_v", truth.stated_gain_v},
          {"duration_s", truth.duration_s},
          {"seed", truth.seed}};
}

CaseTruth case_from(const Json& json, const Place& place) {
  CaseTruth truth;
  truth.name = json.at("case").get<std::string>();
  truth.kind = class_named(json.at("class").get<std::string>());
  for (const Json& effect : json.at("effects")) truth.effects.push_back(effect_from(effect));
  truth.rho = json.at("rho").get<double>();
  for (const Json& one : json.at("look_alikes")) {
    truth.look_alikes.push_back(
        {one.at("effect").get<std::string>(), one.at("rho_left").get<double>()});
  }
  truth.material = material_from(json.at("material"));
  truth.rho_beyond_one_gaussian_lobe = json.at("rho_beyond_one_gaussian_lobe").get<double>();
  truth.plan = plan_from(json.at("plan"));
  truth.records = json.at("records").get<std::size_t>();
  truth.relative_noise = json.at("noise").at("relative").get<double>();
  truth.additive_noise_v = json.at("noise").at("additive_v").get<double>();
  truth.config = plant::ideal_config();
  for (const auto& [name, value] : json.at("plant").items()) {
    plant::set_parameter(truth.config, name, value.get<double>(), place);
  }
  truth.stated_gain_v = json.at("stated_gain_v").get<std::array<double, plant::laser_count>>();
  truth.duration_s = json.at("duration_s").get<double>();
  truth.seed = json.at("seed").get<std::uint64_t>();
  return truth;
}

}  // namespace

const CaseTruth& TruthFile::find(const std::string& name) const {
  for (const CaseTruth& truth : cases) {
    if (truth.name == name) return truth;
  }
  throw Error("the truth has no case \"" + name + "\"",
              cases.empty() ? "it has none at all"
                            : "it has " + cases.front().name + " to " + cases.back().name);
}

std::string truth_text(const TruthFile& truth) {
  Json all = Json::array();
  for (const CaseTruth& one : truth.cases) all.push_back(case_json(one));
  return Json{{"format", format_name}, {"seed", truth.seed}, {"cases", all}}.dump(1) + "\n";
}

TruthFile parse_truth(const std::string& text, const std::string& name) {
  try {
    const Json json = Json::parse(text);
    if (json.at("format") != format_name) {
      throw Error({name}, "is no truth of this version", "make the cases anew");
    }
    TruthFile truth;
    truth.seed = json.at("seed").get<std::uint64_t>();
    for (const Json& one : json.at("cases")) truth.cases.push_back(case_from(one, {name}));
    return truth;
  } catch (const Json::exception& error) {
    throw Error({name}, std::string("is no truth of withheld-effect cases: ") + error.what(),
                "name the folder that --truth of `umov blind make` wrote");
  }
}

TruthFile read_truth(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error({path.string()}, "cannot be read", "check the path and its permissions");
  std::ostringstream text;
  text << file.rdbuf();
  return parse_truth(text.str(), path.string());
}

}  // namespace umov::blind
