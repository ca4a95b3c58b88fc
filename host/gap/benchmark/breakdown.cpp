#include "host/gap/benchmark/breakdown.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

namespace umov::gap::benchmark {
namespace {

bool alone(const TrueCase& truth) {
  return (truth.kind == "single" || truth.kind == "confounded") && !truth.effects.empty();
}

std::vector<GroupRow> grouped(const std::vector<Entry>& entries,
                              const std::function<std::string(const TrueCase&)>& group_of) {
  std::map<std::string, GroupRow> rows;
  for (const Entry& entry : entries) {
    const TrueCase& truth = entry.truth;
    GroupRow& row = rows[group_of(truth)];
    row.group = group_of(truth);
    if (truth.kind == "single" && truth.effects.front().rho >= 10)
      row.top1.add(leads(claims_of(entry.first), truth.effects.front().name));
    if (truth.kind == "none") row.alarms.add(alarmed(truth, entry.first));
    if (few_known(truth)) row.flags.add(entry.first.flags_unknown());
  }
  std::vector<GroupRow> result;
  for (auto& [name, row] : rows) result.push_back(std::move(row));
  return result;
}

}  // namespace

std::vector<EffectRow> by_effect(const std::vector<Entry>& entries) {
  std::map<std::string, EffectRow> rows;
  for (const Entry& entry : entries) {
    const TrueCase& truth = entry.truth;
    const std::vector<Claim> claims = claims_of(entry.first);
    if (alone(truth)) {
      const TrueEffect& effect = truth.effects.front();
      EffectRow& row = rows[effect.name];
      row.plain.add(!claims.empty() && claims.front().lead == effect.name);
      row.up_to_set.add(leads(claims, effect.name));
      if (effect.rho >= 10) row.up_to_set_10.add(leads(claims, effect.name));
    }
    if (truth.kind == "crowded") continue;
    for (const Claim& claim : claims) {
      EffectRow& row = rows[claim.lead];
      row.right.add(std::any_of(claim.members.begin(), claim.members.end(), [&](const auto& name) {
        return truth.has(name) || (name == model_cause && !truth.one_gaussian_lobe);
      }));
      for (const TrueEffect& effect : truth.effects) {
        if (effect.name != claim.lead || effect.parameters.empty()) continue;
        const auto& known = entry.first.cause(claim.lead)->parameters;
        const auto& [name, value] = effect.parameters.front();
        const auto found = known.find(name);
        if (found != known.end())
          row.interval.add(found->second.lo <= value && value <= found->second.hi);
      }
    }
  }
  std::vector<EffectRow> result;
  for (auto& [name, row] : rows) {
    row.effect = name;
    result.push_back(std::move(row));
  }
  return result;
}

std::vector<GroupRow> by_style(const std::vector<Entry>& entries) {
  return grouped(entries, [](const TrueCase& t) { return t.style; });
}

std::vector<GroupRow> by_material(const std::vector<Entry>& entries) {
  return grouped(entries, [](const TrueCase& t) { return t.family; });
}

std::vector<Confusion> confusions(const std::vector<Entry>& entries) {
  std::map<std::pair<std::string, std::string>, Confusion> pairs;
  for (const Entry& entry : entries) {
    const TrueCase& truth = entry.truth;
    if (!alone(truth) || truth.effects.front().rho < 7) continue;
    const std::string& effect = truth.effects.front().name;
    const std::vector<Claim> claims = claims_of(entry.first);
    const std::string named = claims.empty() ? "" : claims.front().lead;
    if (named == effect) continue;
    Confusion& pair = pairs[{effect, named}];
    pair.effect = effect;
    pair.named = named;
    ++pair.count;
    if (leads(claims, effect)) ++pair.in_set;
  }
  std::vector<Confusion> result;
  for (auto& [key, pair] : pairs) result.push_back(std::move(pair));
  std::stable_sort(result.begin(), result.end(),
                   [](const Confusion& a, const Confusion& b) { return a.count > b.count; });
  return result;
}

std::vector<LeftOutRow> left_out(const std::vector<Entry>& entries) {
  std::map<std::string, LeftOutRow> rows;
  for (const Entry& entry : entries) {
    if (entry.truth.effects.size() != 1) continue;
    LeftOutRow& row = rows[entry.truth.effects.front().name];
    row.effect = entry.truth.effects.front().name;
    ++row.n;
    const std::vector<Claim> claims = claims_of(entry.first);
    if (entry.first.flags_unknown()) {
      ++row.flagged;
    } else if (entry.first.verdict != "explained") {
      ++row.unseen;
    } else if (wrongful(entry.truth, claims) == 0) {
      ++row.absorbed;
    } else {
      ++row.mimicked;
      for (const Claim& claim : claims) {
        auto& mimics = row.mimics;
        if (std::find(mimics.begin(), mimics.end(), claim.lead) == mimics.end())
          mimics.push_back(claim.lead);
      }
    }
  }
  std::vector<LeftOutRow> result;
  for (auto& [name, row] : rows) result.push_back(std::move(row));
  return result;
}

}  // namespace umov::gap::benchmark
