// Causes, the size of the gap, further scans and tables of a diagnosis.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "host/formats/provenance.hpp"
#include "host/gap/answer/words.hpp"
#include "host/report/diagnosis_parts.hpp"
#include "host/report/json_parts.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {

namespace {

/// Probability below which an effect that is not named is not worth a bar.
constexpr double worth_a_bar = 0.02;
constexpr std::size_t most_others = 5;

std::string label_of(const std::string& effect, const std::string& family) {
  const std::string name = gap::plain_name(effect);
  return family.empty() ? name : name + " (" + family + ")";
}

/// `value` with the digits that its interval supports.
std::string within(double value, double width) {
  if (!(width > 0) || value == 0) return plain(value, value == 0 ? 4 : 4);
  const int digits =
      static_cast<int>(std::floor(std::log10(std::abs(value))) - std::floor(std::log10(width))) + 2;
  return plain(value, std::clamp(digits, 1, 7));
}

std::string interval_text(const gap::Interval& i) {
  const double width = 0.5 * (i.hi - i.lo);
  if (!(width > 0)) return "–";
  return within(i.lo, width) + " to " + within(i.hi, width);
}

Json value_rows(const std::string& label, const std::vector<gap::NamedValue>& values,
                const gap::Effect* declared) {
  Json rows = Json::array();
  for (const gap::NamedValue& v : values) {
    std::string meaning;
    if (declared != nullptr)
      for (const gap::Parameter& p : declared->parameters)
        if (p.name == v.name) meaning = p.meaning;
    rows.push_back({label, v.name, within(v.interval.value, 0.5 * (v.interval.hi - v.interval.lo)),
                    interval_text(v.interval), v.unit == "1" ? "" : v.unit, meaning});
  }
  return rows;
}

void append(Json& rows, const Json& more) {
  for (const Json& row : more) rows.push_back(row);
}

Json bar(const char* name, const gap::GapInterval& i) {
  const auto part = [](const gap::Interval& v) {
    return Json{{"value", rounded(v.value, 4)},
                {"lo", rounded(v.lo, 4)},
                {"hi", rounded(v.hi, 4)},
                {"text", plain(v.value, 3)},
                {"interval", interval_text(v)}};
  };
  return {{"name", name}, {"g2", part(i.g2)}, {"percent", part(i.percent)}};
}

struct AxisWords {
  const char* name;
  const char* words;
};
constexpr AxisWords axis_words[] = {{"theta_i_deg", "θi"},
                                    {"theta_r_deg", "θr"},
                                    {"theta_h_deg", "θh, off the mirror"},
                                    {"theta_d_deg", "θd"},
                                    {"wavelength_nm", "λ"},
                                    {"log_signal", "log₁₀ (|X| / V)"},
                                    {"time", "time, of the scan"},
                                    {"direction", "direction of travel"}};

}  // namespace

Json causes_json(const gap::Diagnosis& d, const std::vector<gap::Effect>& effects,
                 const std::vector<gap::Alternative>& alternatives) {
  const auto probability = [&](const std::string& name) {
    for (const auto& [known, p] : d.probabilities)
      if (known == name) return p;
    return 0.0;
  };
  Json bars = Json::array();
  std::set<std::string> covered;
  for (const gap::Cause& cause : d.causes) {
    if (covered.contains(cause.effect)) continue;
    std::vector<std::string> members{cause.effect};
    for (const auto& set : d.ambiguity_sets)
      if (std::find(set.begin(), set.end(), cause.effect) != set.end()) members = set;
    covered.insert(members.begin(), members.end());
    double joint = 0, share = 0;
    std::vector<std::string> names;
    for (const std::string& member : members) {
      joint += probability(member);
      std::vector<std::string> families;
      for (const gap::Cause& c : d.causes) {
        if (c.effect != member) continue;
        share += c.share;
        if (!c.family.empty()) families.push_back(c.family);
      }
      names.push_back(label_of(member, fmt::format("{}", fmt::join(families, " + "))));
    }
    bars.push_back({{"label", members.size() > 1 ? fmt::format("one of {}", fmt::join(names, ", "))
                                                 : names[0]},
                    {"effects", members},
                    {"probability", rounded(std::min(1.0, joint), 4)},
                    {"share", rounded(share, 4)},
                    {"named", true}});
  }
  for (const auto& [name, p] : d.probabilities)
    if (!covered.contains(name) && p >= worth_a_bar && bars.size() < covered.size() + most_others)
      bars.push_back({{"label", gap::plain_name(name)},
                      {"effects", {name}},
                      {"probability", rounded(p, 4)},
                      {"named", false}});

  Json parameters = Json::array(), physics = Json::array();
  for (const gap::Cause& cause : d.causes) {
    const gap::Effect* declared = nullptr;
    for (const gap::Effect& e : effects)
      if (e.name == cause.effect && e.family == cause.family) declared = &e;
    const bool scatters = declared != nullptr && declared->scatter;
    append(parameters,
           value_rows(label_of(cause.effect, cause.family), cause.parameters, declared));
    if (declared != nullptr)
      physics.push_back({label_of(cause.effect, cause.family), declared->physics});
    if (scatters)
      physics.push_back({gap::plain_name(gap::unseen_noise),
                         "Light that changes from record to record but not within one, unseen by "
                         "the monitor: only a place that is measured again tells it from a pattern "
                         "that belongs to the place."});
    for (const gap::Alternative& other : alternatives) {
      if (other.instead_of != cause.effect) continue;
      const std::string label = label_of(other.effect.name, other.effect.family);
      append(parameters, value_rows("or " + label, other.parameters, &other.effect));
      physics.push_back({label, other.effect.physics});
    }
  }
  return {{"bars", std::move(bars)},
          {"parameters", std::move(parameters)},
          {"physics", std::move(physics)}};
}

Json closed_fact(const gap::Diagnosis& d) {
  const auto percent = [](double share) { return plain(100 * std::clamp(share, 0.0, 1.0), 3); };
  const auto& closed = d.closed_fraction;
  return {{"name", "closed"},
          {"value", percent(closed.value) + " %"},
          {"note", fmt::format("{} to {} % (95 %)", percent(closed.lo), percent(closed.hi))}};
}

Json next_json(const gap::Diagnosis& d) {
  Json out = Json::array();
  for (const gap::FurtherScan& s : d.next_scan) {
    out.push_back({{"menu", s.menu},
                   {"words", gap::menu_in_words(s.menu)},
                   {"separates", gap::separations_in_words(s)},
                   {"separation", plain(s.expected_separation, 3)},
                   {"minutes", plain(std::max(1.0, std::round(s.minutes)), 3)}});
  }
  return out;
}

namespace {

/// {bars:[{name, g2, percent, …}], closed}
Json gap_json(const gap::Diagnosis& d) {
  const gap::GapBounds& bounds = *d.bounds;
  return {{"bars",
           {bar("before", bounds.before), bar("after", bounds.after), bar("floor", bounds.floor)}},
          {"closed",
           {{"text", plain(100 * d.closed_fraction.value, 3) + " %"},
            {"interval", fmt::format("{} to {} %", plain(100 * d.closed_fraction.lo, 3),
                                     plain(100 * d.closed_fraction.hi, 3))}}}};
}

/// Rows of a table of cells.
Json cells_json(const gap::Where& where) {
  Json rows = Json::array();
  for (const gap::Cell& c : where.cells) {
    std::string axis = c.axis;
    for (const AxisWords& known : axis_words)
      if (c.axis == known.name) axis = known.words;
    const std::string unit = c.unit == "1" || c.unit.empty() ? ""
                             : c.unit == "deg"               ? "°"
                                                             : " " + c.unit;
    std::string place = plain(c.from, 4) + unit;
    if (c.to != c.from) place += " to " + plain(c.to, 4) + unit;
    std::string polarizer, analyzer, rest;
    for (const auto& [key, value] : c.also) {
      const bool number = value.find_first_not_of("-.0123456789") == std::string::npos;
      const std::string state = value == "open" ? "U" : number ? value + "°" : value;
      if (key == "polarizer") polarizer = state;
      if (key == "analyzer") analyzer = state;
      if (key == "component" && value == "y") rest += ", quadrature";
      if (key == "wavelength_nm") rest += ", " + value + " nm";
    }
    const std::string channel = (polarizer.empty() ? "all" : polarizer + " → " + analyzer) + rest;
    rows.push_back({axis, place, channel, fmt::format("{}", c.members.size()),
                    (c.z > 0 ? "+" : "") + plain(c.z, 3), plain(c.p_global, 2)});
  }
  return rows;
}

/// Rows [name, value, interval, unit].
Json base_json(const gap::Diagnosis& d) {
  Json rows = Json::array();
  for (const gap::NamedValue& v : d.base)
    rows.push_back({v.name, within(v.interval.value, 0.5 * (v.interval.hi - v.interval.lo)),
                    interval_text(v.interval), v.unit == "1" ? "" : v.unit});
  return rows;
}

}  // namespace

Json data_of_any(const gap::Diagnosis& d, const gap::AnswerSource& source,
                 const std::string& created) {
  return {{"program", "umov " + source.version},
          {"command", source.command},
          {"created", created.empty() ? formats::utc_now() : created},
          {"verdict", gap::to_string(d.verdict)},
          {"sentence", gap::verdict_sentence(d)},
          {"model", source.model},
          {"notes", source.notes},
          {"gap", gap_json(d)},
          {"where", {{"cells", cells_json(d.where)}, {"p_global", plain(d.where.p_global, 2)}}},
          {"left",
           {{"cells", cells_json(d.unexplained)},
            {"p_global", plain(d.unexplained.p_global, 2)},
            {"g2", plain(d.unexplained_g2, 2)}}},
          {"base", base_json(d)}};
}

}  // namespace umov::report
