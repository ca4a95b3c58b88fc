#include "host/gap/benchmark/score.hpp"

#include <algorithm>
#include <random>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/gap/benchmark/seen.hpp"

namespace umov::gap::benchmark {

std::vector<std::string> names_of(const TrueCase& truth) {
  std::vector<std::string> names;
  for (const TrueEffect& e : truth.effects) names.push_back(e.name);
  return names;
}

Cases seen_by(const std::vector<Entry>& entries, Candidate candidate) {
  Cases cases;
  for (const Entry& entry : entries) {
    const Answer *first = &entry.first, *last = &entry.last;
    const auto take = [&](const std::optional<Answer>& answer) {
      first = last = answer ? &*answer : nullptr;
    };
    if (candidate == Candidate::largest_residual) take(entry.largest_residual);
    if (candidate == Candidate::forward_bic) take(entry.forward_bic);
    if (candidate == Candidate::oracle) take(entry.oracle);
    if (first)
      cases.push_back({&entry, &entry.truth, first, last, claims_of(*first), claims_of(*last)});
  }
  return cases;
}

bool pair_of(const Seen& c, double rho, bool given_others) {
  return c.is("double") &&
         std::all_of(c.truth->effects.begin(), c.truth->effects.end(), [&](const TrueEffect& e) {
           return (given_others ? e.rho_given_others : e.rho) >= rho;
         });
}

const std::string& enlarged(const Seen& c) {
  for (const TrueEffect& e : c.truth->effects)
    if (e.enlarged) return e.name;
  return c.truth->effects.front().name;
}

std::size_t wrongful(const TrueCase& truth, const std::vector<Claim>& claims) {
  std::vector<Claim> open;
  matched(names_of(truth), claims, &open);
  return static_cast<std::size_t>(std::count_if(open.begin(), open.end(), [&](const Claim& c) {
    return truth.one_gaussian_lobe || !c.members.contains(model_cause);
  }));
}

bool alarmed(const TrueCase& truth, const Answer& answer) {
  if (answer.flags_unknown()) return true;
  const std::vector<Claim> claims = claims_of(answer);
  return std::any_of(claims.begin(), claims.end(), [&](const Claim& c) {
    return truth.one_gaussian_lobe || !c.members.contains(model_cause);
  });
}

bool leads(const std::vector<Claim>& claims, const std::string& effect) {
  return !claims.empty() && claims.front().members.contains(effect);
}

bool exact(const TrueCase& truth, const std::vector<Claim>& claims) {
  return matched(names_of(truth), claims) == truth.effects.size() && wrongful(truth, claims) == 0;
}

bool few_known(const TrueCase& truth) {
  return truth.kind == "single" || truth.kind == "double" || truth.kind == "triple" ||
         truth.kind == "confounded";
}

bool in_plane(const TrueCase& truth) {
  return truth.style != "full";
}

std::string claims_text(const Answer& answer) {
  std::vector<std::string> words;
  for (const Claim& claim : claims_of(answer)) {
    std::string word = fmt::format("{} {:.2f}", claim.lead, answer.cause(claim.lead)->probability);
    for (const std::string& member : claim.members)
      if (member != claim.lead) word += " or " + member;
    words.push_back(std::move(word));
  }
  return answer.verdict + (words.empty() ? "" : ": ") + fmt::format("{}", fmt::join(words, ", "));
}

std::vector<Entry> permuted(std::vector<Entry> entries, std::uint64_t seed) {
  // A cycle through all cases in a random order: no case keeps its truth.
  std::vector<std::size_t> order(entries.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::mt19937_64 random(seed);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  std::vector<TrueCase> truths;
  for (const Entry& e : entries) truths.push_back(e.truth);
  for (std::size_t i = 0; i < order.size(); ++i)
    entries[order[i]].truth = truths[order[(i + 1) % order.size()]];
  return entries;
}

}  // namespace umov::gap::benchmark
