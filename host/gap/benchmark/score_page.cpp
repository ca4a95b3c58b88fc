#include "host/gap/benchmark/score_page.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "host/gap/benchmark/breakdown.hpp"
#include "host/gap/benchmark/misses.hpp"
#include "host/gap/benchmark/proportion.hpp"

namespace umov::gap::benchmark {
namespace {

using Json = nlohmann::ordered_json;

struct Column {
  const char *id, *title;
  std::vector<Measure> measures;
};

constexpr std::size_t own = 0, oracle = 3, permutation = 4;

std::vector<Column> columns_of(const std::vector<Entry>& entries, std::uint64_t seed) {
  return {
      {"diagnosis", "diagnosis", measures(entries, Candidate::diagnosis, seed)},
      {"largest_residual", "largest residual",
       measures(entries, Candidate::largest_residual, seed)},
      {"forward_bic", "forward BIC", measures(entries, Candidate::forward_bic, seed)},
      {"oracle", "oracle", measures(entries, Candidate::oracle, seed)},
      {"permuted", "labels permuted",
       measures(permuted(entries, seed), Candidate::diagnosis, seed)},
  };
}

/// Has this column something to say on a measure?
bool says(std::size_t column, const Measure& m) {
  if (m.n == 0) return false;
  if (column == oracle) return m.oracle_has_it;
  // The gap of an answer does not look at labels.
  if (column == permutation) return !m.id.starts_with("closed") && m.id != "set_size";
  return true;
}

std::string figure(double value) {
  if (std::isnan(value)) return "–";
  return fmt::format("{:.3f}", value);
}

std::string with_interval(const Measure& m) {
  if (m.n == 0) return "–";
  const std::string counts = m.hits ? fmt::format(" ({}/{})", *m.hits, m.n) : "";
  return fmt::format("**{}** [{}, {}]{}", figure(m.value.value), figure(m.value.lo),
                     figure(m.value.hi), counts);
}

std::string target_text(const Measure& m) {
  const bool above = m.least > -1e300, below = m.most < 1e300;
  if (above && below) return fmt::format("{:.2f}–{:.2f}", m.least, m.most);
  if (above) return fmt::format("≥ {:.2f}", m.least);
  if (below) return fmt::format("≤ {:.2f}", m.most);
  return "";
}

std::string standing(const Measure& m) {
  if (m.n == 0) return "no cases";
  const double off = m.value.value < m.least ? m.least - m.value.value : m.value.value - m.most;
  const std::string said = m.met() ? "met" : fmt::format("missed by {}", figure(off));
  return m.surely() ? said + ", surely" : said;
}

std::string count_text(const Count& c) {
  if (c.n == 0) return "–";
  const Interval i = clopper_pearson(c.hits, c.n);
  return fmt::format("{}/{} [{:.2f}, {:.2f}]", c.hits, c.n, i.lo, i.hi);
}

std::string measure_tables(const std::vector<Column>& columns, bool brief) {
  std::string text =
      "| measure | n | diagnosis [95 %] | target | standing | largest residual | forward BIC | "
      "oracle | labels permuted |\n|---|---|---|---|---|---|---|---|---|\n";
  std::string further =
      "| measure | n | diagnosis [95 %] | largest residual | forward BIC | oracle | labels "
      "permuted |\n|---|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < columns[own].measures.size(); ++i) {
    const Measure& m = columns[own].measures[i];
    std::string others;
    for (std::size_t c = 1; c < columns.size(); ++c) {
      const Measure& theirs = columns[c].measures[i];
      others += " " + (says(c, theirs) ? figure(theirs.value.value) : std::string("–")) + " |";
    }
    if (m.headline) {
      text += fmt::format("| {} | {} | {} | {} | {} |{}\n", m.title, m.n, with_interval(m),
                          target_text(m), standing(m), others);
    } else {
      further += fmt::format("| {} | {} | {} |{}\n", m.title, m.n, with_interval(m), others);
    }
  }
  return brief ? text : text + "\n## Behind the targets\n\n" + further;
}

std::string groups_table(const char* title, const std::vector<GroupRow>& rows) {
  std::string text = fmt::format(
      "| {} | top-1 of single effects, ρ ≥ 10, up to the set | false alarms | known effects called "
      "unknown |\n|---|---|---|---|\n",
      title);
  for (const GroupRow& row : rows) {
    text += fmt::format("| {} | {} | {} | {} |\n", row.group, count_text(row.top1),
                        count_text(row.alarms), count_text(row.flags));
  }
  return text;
}

std::string effects_table(const std::vector<Entry>& entries) {
  std::string text =
      "| effect | top-1, any ρ, plain | up to the set | up to the set, ρ ≥ 10 | claims of it that "
      "are right | interval holds the truth |\n|---|---|---|---|---|---|\n";
  for (const EffectRow& row : by_effect(entries)) {
    text += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", row.effect, count_text(row.plain),
                        count_text(row.up_to_set), count_text(row.up_to_set_10),
                        count_text(row.right), count_text(row.interval));
  }
  return text;
}

std::string confusions_table(const std::vector<Entry>& entries) {
  std::string text = "| effect | taken for | cases | of these in its set |\n|---|---|---|---|\n";
  std::size_t rows = 0;
  for (const Confusion& c : confusions(entries)) {
    if (++rows > 40) break;
    text += fmt::format("| `{}` | {} | {} | {} |\n", c.effect,
                        c.named.empty() ? "nothing named" : "`" + c.named + "`", c.count, c.in_set);
  }
  return text;
}

std::string misses_table(const std::vector<Miss>& misses) {
  std::string text =
      "| case | class | missed | why | truth and ρ | material | plan | answer |\n"
      "|---|---|---|---|---|---|---|---|\n";
  for (const Miss& m : misses) {
    text += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} |\n", m.name, m.kind, m.measure,
                        m.why, m.truth.empty() ? "none" : m.truth, m.material, m.style, m.answer);
  }
  return text;
}

/// How often each reason, by measure.
std::string reasons_table(const std::vector<Miss>& misses) {
  std::vector<std::string> order;
  std::map<std::string, std::map<MissReason, int>> counts;
  for (const Miss& m : misses) {
    if (!counts.contains(m.measure)) order.push_back(m.measure);
    auto& of_measure = counts[m.measure];
    if (m.reason) ++of_measure[*m.reason];
  }
  std::string head = "| missed |", line = "|---|", text;
  for (const MissReason reason : all_miss_reasons) {
    head += fmt::format(" {} |", to_string(reason));
    line += "---|";
  }
  for (const std::string& measure : order) {
    text += fmt::format("| {} |", measure);
    for (const MissReason reason : all_miss_reasons)
      text += fmt::format(" {} |", counts[measure][reason]);
    text += "\n";
  }
  return head + "\n" + line + "\n" + text;
}

constexpr const char* reasons_in_words =
    "*Mimicry*: withheld rows speak no more for the truth, as the oracle fits it, than for what "
    "was named (Δχ² ≤ 4); of an unknown effect: a known one was named and nothing significant is "
    "left. *Faint*: they do, by no more than the best effect of the catalogue gains in noise alone "
    "(Δχ² ≤ 12). *Search*: they do by more, stated. *Unseen*: the oracle does not see at 99 % what "
    "is missing; of an unknown effect: nothing but a reflectance was named and nothing significant "
    "is left. *Behind*: all is named, but not in the first place, or only as one with the "
    "reflectance. *Rest*: all is named, and something is said to stay unexplained. *More*: all is "
    "named, and something besides. *Material*, *chance*: there is no effect, and a reflectance "
    "that is not one Gaussian lobe, or is. Withheld rows are those of the case's own scan. Of "
    "crowds, which the oracle fits coarsely, they are not asked.";

struct Times {
  std::size_t n = 0;
  double median = 0, p95 = 0, most = 0;
};

Times times(const std::vector<Entry>& entries, double Entry::*seconds) {
  std::vector<double> all;
  for (const Entry& e : entries)
    if (e.*seconds > 0) all.push_back(e.*seconds);
  Times t{all.size(), 0, 0, 0};
  if (all.empty()) return t;
  t.median = quantile(all, 0.5);
  t.p95 = quantile(all, 0.95);
  t.most = quantile(all, 1.0);
  return t;
}

std::string times_text(const std::vector<Entry>& entries) {
  std::string text;
  const auto say = [&](const char* what, const Times& t) {
    if (t.n > 0)
      text += fmt::format(
          "{}: median {:.1f} s, 95th percentile {:.1f} s, longest {:.1f} s of one "
          "core ({} cases).\n",
          what, t.median, t.p95, t.most, t.n);
  };
  say("A diagnosis", times(entries, &Entry::seconds));
  say("Prescribed scans and the diagnoses with them", times(entries, &Entry::further_seconds));
  return text;
}

std::string left_out_table(const std::vector<Entry>& entries) {
  std::string text =
      "| effect left out | cases | flagged | explained by others | by a richer reflectance | not "
      "seen | taken for |\n|---|---|---|---|---|---|---|\n";
  for (const LeftOutRow& row : left_out(entries)) {
    text += fmt::format("| `{}` | {} | {} | {} | {} | {} | {} |\n", row.effect, row.n, row.flagged,
                        row.mimicked, row.absorbed, row.unseen, fmt::join(row.mimics, ", "));
  }
  return text;
}

std::string head(const std::vector<Entry>& entries, const ScoreSource& source) {
  std::string text = fmt::format("{} of {} cases answered; truth sealed with sha256 {}.\n",
                                 entries.size(), source.cases, source.seal_sha256);
  if (!source.run.empty()) {
    const Json run = Json::parse(source.run);
    const Json& program = run.at("program");
    text += fmt::format(
        "Program: version {}, commit {}, sha256 {}; options {}.\n",
        program.at("version").get<std::string>(),
        program.at("commit").get<std::string>().empty() ? "not stated"
                                                        : program.at("commit").get<std::string>(),
        program.at("sha256").get<std::string>().substr(0, 16), run.at("options").dump());
  }
  const auto failed = [](const Entry& e) { return !e.rivals_failed.empty(); };
  const auto first = std::find_if(entries.begin(), entries.end(), failed);
  if (first != entries.end())
    text += fmt::format("Of {} cases floors and oracle failed, such as {}: {}.\n",
                        std::count_if(entries.begin(), entries.end(), failed), first->truth.name,
                        first->rivals_failed);
  return text;
}

Json measure_json(const Measure& m) {
  // NaN has no JSON: null.
  const auto number = [](double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); };
  Json json = {{"n", m.n},
               {"value", number(m.value.value)},
               {"lo", number(m.value.lo)},
               {"hi", number(m.value.hi)}};
  if (m.hits) json["hits"] = *m.hits;
  if (m.has_target()) {
    json["target"] = {{"least", number(m.least)}, {"most", number(m.most)}};
    json["met"] = m.n > 0 ? Json(m.met()) : Json(nullptr);
    json["surely"] = m.surely();
  }
  return json;
}

Json count_json(const Count& c) {
  return {{"hits", c.hits}, {"n", c.n}};
}

Json groups_json(const std::vector<GroupRow>& rows) {
  Json all = Json::object();
  for (const GroupRow& row : rows) {
    all[row.group] = {{"top1_set", count_json(row.top1)},
                      {"false_alarms", count_json(row.alarms)},
                      {"known_flagged", count_json(row.flags)}};
  }
  return all;
}

Json times_json(const Times& t) {
  return {{"n", t.n}, {"median_s", t.median}, {"p95_s", t.p95}, {"most_s", t.most}};
}

Json left_out_json(const std::vector<Entry>& entries) {
  Json all = Json::object();
  for (const LeftOutRow& row : left_out(entries)) {
    all[row.effect] = {{"n", row.n},
                       {"flagged", row.flagged},
                       {"mimicked", row.mimicked},
                       {"absorbed", row.absorbed},
                       {"unseen", row.unseen},
                       {"mimics", row.mimics}};
  }
  return all;
}

}  // namespace

std::string score_markdown(const std::vector<Entry>& entries, const ScoreSource& source,
                           bool brief) {
  std::string text = head(entries, source) + "\n";
  if (source.leave_out) return text + left_out_table(entries);
  text += measure_tables(columns_of(entries, source.seed), brief) + "\n" + times_text(entries);
  if (brief) return text;
  text += "\n## By effect\n\n" + effects_table(entries);
  text += "\n## By plan\n\n" + groups_table("plan", by_style(entries));
  text += "\n## By material\n\n" + groups_table("material", by_material(entries));
  text +=
      "\n## What is taken for what\n\nSingle effects of ρ ≥ 7 that were not named plainly.\n\n" +
      confusions_table(entries);
  const std::vector<Miss> missed = misses(entries);
  text += fmt::format("\n## Misses\n\n{}\n\n{}\n{}", reasons_in_words, reasons_table(missed),
                      misses_table(missed));
  return text;
}

std::string score_json(const std::vector<Entry>& entries, const ScoreSource& source) {
  Json json = {{"cases", source.cases},
               {"answered", entries.size()},
               {"seal_sha256", source.seal_sha256},
               {"seed", source.seed}};
  if (!source.run.empty()) json["run"] = Json::parse(source.run);
  if (source.leave_out) {
    json["left_out"] = left_out_json(entries);
    return json.dump(1) + "\n";
  }
  const std::vector<Column> columns = columns_of(entries, source.seed);
  json["measures"] = Json::object();
  for (std::size_t i = 0; i < columns[own].measures.size(); ++i) {
    const Measure& m = columns[own].measures[i];
    Json entry = {{"title", m.title}, {"headline", m.headline}};
    for (std::size_t c = 0; c < columns.size(); ++c)
      if (c == own || says(c, columns[c].measures[i]))
        entry[columns[c].id] = measure_json(columns[c].measures[i]);
    json["measures"][m.id] = std::move(entry);
  }
  json["by_effect"] = Json::object();
  for (const EffectRow& row : by_effect(entries)) {
    json["by_effect"][row.effect] = {{"plain", count_json(row.plain)},
                                     {"up_to_set", count_json(row.up_to_set)},
                                     {"up_to_set_10", count_json(row.up_to_set_10)},
                                     {"claims_right", count_json(row.right)},
                                     {"interval", count_json(row.interval)}};
  }
  json["by_plan"] = groups_json(by_style(entries));
  json["by_material"] = groups_json(by_material(entries));
  json["confusions"] = Json::array();
  for (const Confusion& c : confusions(entries)) {
    json["confusions"].push_back(
        {{"effect", c.effect}, {"named", c.named}, {"cases", c.count}, {"in_set", c.in_set}});
  }
  json["misses"] = Json::array();
  for (const Miss& m : misses(entries)) {
    json["misses"].push_back({{"case", m.name},
                              {"class", m.kind},
                              {"measure", m.measure},
                              {"truth", m.truth},
                              {"material", m.material},
                              {"plan", m.style},
                              {"why", m.why},
                              {"answer", m.answer}});
  }
  json["time"] = {{"diagnosis", times_json(times(entries, &Entry::seconds))},
                  {"followed", times_json(times(entries, &Entry::further_seconds))}};
  return json.dump(1) + "\n";
}

}  // namespace umov::gap::benchmark
