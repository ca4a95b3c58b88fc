#include "host/gap/answer/diagnosis_json.hpp"

#include <charconv>

#include <nlohmann/json.hpp>

namespace umov::gap {
namespace {

using Json = nlohmann::ordered_json;

Json interval(const Interval& i) {
  return {{"value", i.value}, {"lo", i.lo}, {"hi", i.hi}};
}

Json named_values(const std::vector<NamedValue>& values) {
  Json out = Json::object();
  for (const NamedValue& v : values) {
    Json entry = interval(v.interval);
    entry["unit"] = v.unit;
    out[v.name] = std::move(entry);
  }
  return out;
}

Json cells(const Where& where) {
  Json out = Json::array();
  for (const Cell& c : where.cells) {
    Json entry = {{"axis", c.axis}, {"from", c.from},         {"to", c.to},
                  {"z", c.z},       {"p_global", c.p_global}, {"records", c.members.size()}};
    entry["also"] = Json::object();
    for (const auto& [key, value] : c.also) {
      double number = 0;
      const auto [end, code] = std::from_chars(value.data(), value.data() + value.size(), number);
      if (code == std::errc{} && end == value.data() + value.size()) {
        entry["also"][key] = number;
      } else {
        entry["also"][key] = value;
      }
    }
    out.push_back(std::move(entry));
  }
  return out;
}

Json outcome(const Outcome& o) {
  Json causes = Json::array();
  for (const auto& [effect, probability] : o.causes)
    causes.push_back({{"effect", effect}, {"probability", probability}});
  return {{"verdict", to_string(o.verdict)},
          {"causes", std::move(causes)},
          {"ambiguity_sets", o.ambiguity_sets}};
}

/// With the 95 % interval, where it is known.
Json size(const GapSize& gap, const GapInterval* bounds, bool percent = true) {
  Json out = {{"g2", gap.g2}};
  if (bounds != nullptr) {
    out["lo"] = bounds->g2.lo;
    out["hi"] = bounds->g2.hi;
  }
  if (!percent) return out;
  out["percent"] = gap.percent;
  if (bounds != nullptr) {
    out["percent_lo"] = bounds->percent.lo;
    out["percent_hi"] = bounds->percent.hi;
  }
  return out;
}

}  // namespace

std::string diagnosis_to_json(const Diagnosis& d, const AnswerSource& source) {
  Json out;
  out["verdict"] = to_string(d.verdict);
  const GapBounds* bounds = d.bounds ? &*d.bounds : nullptr;
  out["gap"] = {{"before", size(d.before, bounds ? &bounds->before : nullptr)},
                {"after", size(d.after, bounds ? &bounds->after : nullptr)},
                {"floor", size(d.floor, bounds ? &bounds->floor : nullptr, false)},
                {"closed_fraction", interval(d.closed_fraction)}};
  if (source.likeness) {
    const auto add = [&](const char* when, const ImageLikeness& l) {
      out["gap"][when]["ncc"] = l.ncc;
      out["gap"][when]["nrmse"] = l.nrmse;
    };
    add("before", source.likeness->first);
    add("after", source.likeness->second);
  }
  out["where"] = cells(d.where);
  out["causes"] = Json::array();
  for (const Cause& c : d.causes) {
    Json cause = {{"effect", c.effect}};
    if (!c.family.empty()) cause["family"] = c.family;
    cause["probability"] = c.probability;
    cause["share"] = c.share;
    cause["parameters"] = named_values(c.parameters);
    if (const auto within = within_tolerance(c, source.limits)) cause["within_tolerance"] = *within;
    out["causes"].push_back(std::move(cause));
  }
  out["ambiguity_sets"] = d.ambiguity_sets;
  out["unexplained"] = {
      {"g2", d.unexplained_g2}, {"p_global", d.unexplained_p}, {"where", cells(d.unexplained)}};
  if (d.verdict != Verdict::none_needed && varies(d))
    out["unexplained"]["varies"] = {
        {"effect", d.variation.what},
        {"with", d.variation.with},
        {"kind", to_string(d.variation.kind)},
        {"at", d.variation.at_name.empty() ? Json(d.variation.at) : Json(d.variation.at_name)},
        {"delta_chi2", d.variation.gain},
        {"p_global", d.variation.p_global}};
  out["next_scan"] = Json::array();
  for (const FurtherScan& s : d.next_scan) {
    out["next_scan"].push_back({{"menu", s.menu},
                                {"separates", s.separates},
                                {"expected_separation", s.expected_separation},
                                {"minutes", s.minutes}});
  }
  Json probabilities = Json::object();
  for (const auto& [name, p] : d.probabilities) probabilities[name] = p;
  out["probabilities"] = std::move(probabilities);
  out["base"] = {{"model", source.model}, {"parameters", named_values(d.base)}};
  out["data"] = {{"records", source.records}, {"used", source.used}, {"sha256", source.sha256}};
  if (!source.notes.empty()) out["data"]["notes"] = source.notes;
  out["program"] = {
      {"version", source.version}, {"seed", source.seed}, {"command", source.command}};
  out["program"]["quick"] = source.quick;
  if (!source.known.empty()) {
    for (const auto& [kind, path] : source.known) out["known"][kind] = path;
  }
  if (!source.follow_ups.empty() || !source.follow_up_ended.empty()) {
    out["follow_ups"] = Json::array();
    for (const FollowUpRound& r : source.follow_ups)
      out["follow_ups"].push_back({{"menu", r.menu},
                                   {"scan", r.scan},
                                   {"before", outcome(r.before)},
                                   {"after", outcome(r.after)}});
    if (!source.follow_up_ended.empty()) out["follow_up_ended"] = source.follow_up_ended;
  }
  return out.dump(1) + "\n";
}

}  // namespace umov::gap
