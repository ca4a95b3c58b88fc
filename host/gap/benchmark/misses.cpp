#include "host/gap/benchmark/misses.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/gap/benchmark/seen.hpp"

namespace umov::gap::benchmark {
namespace {

/// Differences of χ² that two explanations of the same rows have by chance.
constexpr double alike = 4;
/// What the best of the catalogue's effects gains in noise alone, in one of a hundred scans.
constexpr double by_chance = 12;

/// None of what no claim holds is seen by the oracle.
bool missing_is_unseen(const Entry& entry, const std::vector<Claim>& claims) {
  bool any = false;
  for (const TrueEffect& e : entry.truth.effects) {
    if (std::any_of(claims.begin(), claims.end(),
                    [&](const Claim& c) { return c.members.contains(e.name); }))
      continue;
    if (entry.oracle->cause(e.name) != nullptr) return false;
    any = true;
  }
  return any;
}

std::string why(std::optional<MissReason> reason, const Entry& entry) {
  if (!reason) return "";
  if (*reason != MissReason::search) return std::string(to_string(*reason));
  return fmt::format("{} {:.0f}", to_string(*reason), *withheld_excess(entry));
}

}  // namespace

std::string_view to_string(MissReason reason) {
  switch (reason) {
    case MissReason::mimicry:
      return "mimicry";
    case MissReason::faint:
      return "faint";
    case MissReason::search:
      return "search";
    case MissReason::unseen:
      return "unseen";
    case MissReason::behind:
      return "behind";
    case MissReason::rest:
      return "rest";
    case MissReason::more:
      return "more";
    case MissReason::material:
      return "material";
    case MissReason::chance:
      return "chance";
  }
  return "";
}

std::optional<double> withheld_excess(const Entry& entry) {
  if (!entry.oracle || !entry.oracle->has_gap || !entry.first.has_gap ||
      !(entry.first.records_used > 0) || entry.truth.kind == "crowded")
    return std::nullopt;
  // Each record is two observations, X and Y.
  return 2 * entry.first.records_used * (entry.first.g2_after - entry.oracle->g2_after);
}

std::optional<MissReason> miss_reason(const Entry& entry, const Answer& missed) {
  const TrueCase& truth = entry.truth;
  const std::vector<Claim> claims = claims_of(missed);
  if (truth.kind == "none")
    return truth.one_gaussian_lobe ? MissReason::chance : MissReason::material;
  if (truth.kind == "foreign") {
    const bool named =
        std::any_of(claims.begin(), claims.end(), [](const Claim& c) { return !c.is_model(); });
    return named ? MissReason::mimicry : MissReason::unseen;
  }
  if (matched(names_of(truth), claims) == truth.effects.size()) {
    if (wrongful(truth, claims) > 0) return MissReason::more;
    return missed.flags_unknown() ? MissReason::rest : MissReason::behind;
  }
  const std::optional<double> excess = withheld_excess(entry);
  if (!excess) return std::nullopt;
  if (missing_is_unseen(entry, claims)) return MissReason::unseen;
  if (*excess <= alike) return MissReason::mimicry;
  return *excess <= by_chance ? MissReason::faint : MissReason::search;
}

std::vector<Miss> misses(const std::vector<Entry>& entries) {
  std::vector<Miss> list;
  for (const Seen& c : seen_by(entries, Candidate::diagnosis)) {
    const TrueCase& t = *c.truth;
    std::vector<std::string> effects;
    for (std::size_t i = 0; i < t.effects.size() && i < 3; ++i)
      effects.push_back(fmt::format("{} {:.1f}", t.effects[i].name, t.effects[i].rho));
    if (t.effects.size() > 3) effects.push_back(fmt::format("and {} more", t.effects.size() - 3));
    const auto add = [&](const char* measure, const Answer& answer) {
      const std::optional<MissReason> reason = miss_reason(*c.entry, answer);
      list.push_back({t.name, t.kind, measure, fmt::format("{}", fmt::join(effects, ", ")),
                      t.family, t.style, claims_text(answer), reason, why(reason, *c.entry)});
    };
    if (c.is("none") && alarmed(t, *c.first)) add("false_alarms", *c.first);
    if (c.is("single") && c.effect().rho >= 10 && in_plane(t) && !leads(c.claims, c.effect().name))
      add("top1_set", *c.first);
    if (c.is("single") && c.effect().rho >= 10 && !leads(c.last_claims, c.effect().name))
      add("top1_followed", *c.last);
    if (few_known(t) && t.rho >= 7 && !alarmed(t, *c.first)) add("detection", *c.first);
    if (few_known(t) && c.first->flags_unknown()) add("known_flagged", *c.first);
    if (pair_of(c, 10, false) && !exact(t, c.last_claims)) add("exact_pair", *c.last);
    if (c.is("triple") && !exact(t, c.last_claims)) add("triples_f1", *c.last);
    if (c.is("foreign") && t.rho >= 8 && t.look_alikes.empty() && !c.first->flags_unknown())
      add("unknown_flagged", *c.first);
    if (c.is("confounded") && !leads(c.claims, c.effect().name)) add("confounded_set", *c.first);
    if (c.is("crowded") && !t.effects.empty() && !leads(c.claims, enlarged(c)))
      add("crowded", *c.first);
  }
  return list;
}

}  // namespace umov::gap::benchmark
