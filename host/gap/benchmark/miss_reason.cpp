#include "host/gap/benchmark/miss_reason.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace umov::gap::benchmark {
namespace {

/// Differences of χ² that two explanations of the same rows have by chance.
constexpr double alike = 4;
/// What the best of the catalogue's effects gains in noise alone, in one of a hundred scans.
constexpr double by_chance = 12;

/// Effects of the case that no claim holds.
std::vector<std::string> missing_from(const TrueCase& truth, const std::vector<Claim>& claims) {
  std::vector<std::string> missing;
  for (const TrueEffect& e : truth.effects)
    if (std::none_of(claims.begin(), claims.end(),
                     [&](const Claim& c) { return c.members.contains(e.name); }))
      missing.push_back(e.name);
  return missing;
}

}  // namespace

std::string_view to_string(MissReason reason) {
  constexpr std::array<std::string_view, 8> names = {"mimicry", "faint", "search",   "unseen",
                                                     "rest",    "more",  "material", "chance"};
  return names.at(static_cast<std::size_t>(reason));
}

std::optional<double> withheld_excess(const Entry& entry) {
  if (!entry.oracle || !entry.oracle->has_gap || !entry.first.has_gap) return std::nullopt;
  // Each record is two observations, X and Y.
  return 2 * entry.first.records_used * (entry.first.g2_after - entry.oracle->g2_after);
}

std::optional<MissReason> miss_reason(const Entry& entry, const std::vector<Claim>& claims) {
  const TrueCase& truth = entry.truth;
  if (truth.kind == "none")
    return truth.one_gaussian_lobe ? MissReason::chance : MissReason::material;
  if (truth.kind == "foreign") {
    const bool named =
        std::any_of(claims.begin(), claims.end(), [](const Claim& c) { return !c.is_model(); });
    return named ? MissReason::mimicry : MissReason::unseen;
  }
  if (!entry.oracle) return std::nullopt;
  const std::vector<std::string> missing = missing_from(truth, claims);
  if (missing.empty()) return wrongful(truth, claims) > 0 ? MissReason::more : MissReason::rest;
  if (std::none_of(missing.begin(), missing.end(),
                   [&](const std::string& name) { return entry.oracle->cause(name) != nullptr; }))
    return MissReason::unseen;
  const std::optional<double> excess = withheld_excess(entry);
  if (!excess) return std::nullopt;
  if (*excess <= alike) return MissReason::mimicry;
  return *excess <= by_chance ? MissReason::faint : MissReason::search;
}

}  // namespace umov::gap::benchmark
