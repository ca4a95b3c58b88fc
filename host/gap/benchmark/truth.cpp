#include "host/gap/benchmark/truth.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "host/errors/error.hpp"

namespace umov::gap::benchmark {
namespace {

using Json = nlohmann::ordered_json;

TrueEffect effect_from(const Json& json) {
  TrueEffect effect;
  effect.name = json.at("effect").get<std::string>();
  effect.enlarged = json.value("enlarged", false);
  for (const auto& [name, value] : json.at("parameters").items())
    effect.parameters.emplace_back(name, value.get<double>());
  effect.rho = json.at("rho").get<double>();
  effect.rho_given_others = json.value("rho_given_others", effect.rho);
  return effect;
}

TrueCase case_from(const Json& json) {
  TrueCase one;
  one.name = json.at("case").get<std::string>();
  one.kind = json.at("class").get<std::string>();
  for (const Json& effect : json.at("effects")) one.effects.push_back(effect_from(effect));
  one.rho = json.at("rho").get<double>();
  for (const Json& alike : json.at("look_alikes"))
    one.look_alikes.push_back(alike.at("effect").get<std::string>());
  one.family = json.at("material").at("family").get<std::string>();
  one.one_gaussian_lobe = json.at("material").at("one_gaussian_lobe").get<bool>();
  one.style = json.at("plan").at("style").get<std::string>();
  return one;
}

}  // namespace

bool TrueCase::has(const std::string& effect) const {
  return std::any_of(effects.begin(), effects.end(),
                     [&](const TrueEffect& e) { return e.name == effect; });
}

std::vector<TrueCase> parse_truth(const std::string& text, const std::string& name) {
  try {
    std::vector<TrueCase> cases;
    const Json json = Json::parse(text);
    for (const Json& one : json.at("cases")) cases.push_back(case_from(one));
    return cases;
  } catch (const Json::exception& error) {
    throw Error({name}, std::string("is no truth of withheld-effect cases: ") + error.what(),
                "name the folder that --truth of `umov blind make` wrote");
  }
}

}  // namespace umov::gap::benchmark
