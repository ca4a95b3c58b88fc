#include "host/gap/benchmark/claims.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <nlohmann/json.hpp>

#include "host/errors/error.hpp"

namespace umov::gap::benchmark {
namespace {

using Json = nlohmann::json;

double number(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? found->get<double>() : 0.0;
}

AnsweredCause cause_from(const Json& json) {
  AnsweredCause cause;
  cause.effect = json.at("effect").get<std::string>();
  cause.probability = json.at("probability").get<double>();
  cause.share = number(json, "share");
  if (const auto all = json.find("parameters"); all != json.end()) {
    for (const auto& [name, value] : all->items()) {
      cause.parameters[name] = {value.at("value").get<double>(), value.at("lo").get<double>(),
                                value.at("hi").get<double>()};
    }
  }
  return cause;
}

}  // namespace

const AnsweredCause* Answer::cause(const std::string& effect) const {
  for (const AnsweredCause& c : causes)
    if (c.effect == effect) return &c;
  return nullptr;
}

Answer parse_answer(const std::string& text, const std::string& name) {
  try {
    const Json json = Json::parse(text);
    Answer answer;
    answer.verdict = json.at("verdict").get<std::string>();
    for (const Json& cause : json.at("causes")) answer.causes.push_back(cause_from(cause));
    if (const auto sets = json.find("ambiguity_sets"); sets != json.end())
      answer.ambiguity_sets = sets->get<std::vector<std::set<std::string>>>();
    if (const auto all = json.find("probabilities"); all != json.end())
      answer.probabilities = all->get<std::map<std::string, double>>();
    if (const auto gap = json.find("gap"); gap != json.end()) {
      answer.has_gap = true;
      answer.g2_before = gap->at("before").at("g2").get<double>();
      answer.g2_after = gap->at("after").at("g2").get<double>();
    }
    if (const auto data = json.find("data"); data != json.end())
      answer.records_used = number(*data, "used");
    return answer;
  } catch (const Json::exception& error) {
    throw Error({name}, std::string("is no answer of a diagnosis: ") + error.what(),
                "an answer is the JSON that `umov diagnose --json` writes");
  }
}

std::vector<Claim> claims_of(const Answer& answer) {
  std::vector<Claim> claims;
  std::set<std::string> done;
  for (const AnsweredCause& cause : answer.causes) {
    if (!done.insert(cause.effect).second) continue;
    std::set<std::string> members{cause.effect};
    // Sets that overlap are one.
    for (bool grew = true; grew;) {
      grew = false;
      for (const auto& set : answer.ambiguity_sets) {
        const bool touches =
            std::any_of(set.begin(), set.end(), [&](const auto& s) { return members.contains(s); });
        if (!touches) continue;
        const std::size_t before = members.size();
        members.insert(set.begin(), set.end());
        grew = grew || members.size() > before;
      }
    }
    std::vector<const AnsweredCause*> listed;
    for (const AnsweredCause& c : answer.causes)
      if (members.contains(c.effect)) listed.push_back(&c);
    double expected = 0, share = 0;
    for (const std::string& member : members) {
      const AnsweredCause* c = answer.cause(member);
      const auto known = answer.probabilities.find(member);
      if (c) {
        expected += c->probability;
      } else if (known != answer.probabilities.end()) {
        expected += known->second;
      }
    }
    for (const AnsweredCause* c : listed) {
      share += c->share;
      done.insert(c->effect);
    }
    // A set is led by an instrument effect where one is listed.
    std::stable_sort(listed.begin(), listed.end(), [](const auto* a, const auto* b) {
      const bool model_a = a->effect == model_cause, model_b = b->effect == model_cause;
      return model_a != model_b ? model_b : a->share > b->share;
    });
    const auto count =
        std::min(listed.size(), static_cast<std::size_t>(std::floor(expected + 0.5)));
    for (std::size_t i = 0; i < count; ++i) claims.push_back({listed[i]->effect, members, share});
  }
  std::stable_sort(claims.begin(), claims.end(), [](const Claim& a, const Claim& b) {
    return a.is_model() != b.is_model() ? b.is_model() : a.share > b.share;
  });
  return claims;
}

std::size_t matched(const std::vector<std::string>& effects, const std::vector<Claim>& claims,
                    std::vector<Claim>* open) {
  std::vector<int> partner(claims.size(), -1);
  std::vector<bool> seen;
  const std::function<bool(int)> place = [&](int e) {
    // Its own name first, so that what is exact stays exact.
    for (const bool exact : {true, false}) {
      for (std::size_t c = 0; c < claims.size(); ++c) {
        const std::string& name = effects[static_cast<std::size_t>(e)];
        const bool fits = exact ? claims[c].lead == name : claims[c].members.contains(name);
        if (!fits || seen[c]) continue;
        seen[c] = true;
        if (partner[c] < 0 || place(partner[c])) {
          partner[c] = e;
          return true;
        }
      }
    }
    return false;
  };
  std::size_t count = 0;
  for (std::size_t e = 0; e < effects.size(); ++e) {
    seen.assign(claims.size(), false);
    if (place(static_cast<int>(e))) ++count;
  }
  if (open) {
    open->clear();
    for (std::size_t c = 0; c < claims.size(); ++c)
      if (partner[c] < 0) open->push_back(claims[c]);
  }
  return count;
}

}  // namespace umov::gap::benchmark
