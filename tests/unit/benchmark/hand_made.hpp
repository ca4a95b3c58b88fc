// Truths and answers written by hand.
#pragma once

#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/gap/benchmark/score.hpp"

namespace umov::gap::benchmark {

/// A case of one Gaussian lobe in a one-way plan; effects by name and ρ, with parameter `size` 1.
inline TrueCase truth(const std::string& kind,
                      const std::vector<std::pair<std::string, double>>& effects) {
  TrueCase one;
  one.name = "case_0001";
  one.kind = kind;
  one.family = "gaussian_facets";
  one.style = "one-way";
  for (const auto& [name, rho] : effects) {
    one.effects.push_back({name, false, {{"size", 1.0}}, rho, rho});
    one.rho = rho > one.rho ? rho : one.rho;
  }
  return one;
}

/// Causes with their probabilities, equal shares in their order, and intervals of `size` about 1.
inline Answer answer(const std::string& verdict,
                     const std::vector<std::pair<std::string, double>>& causes = {},
                     const std::vector<std::set<std::string>>& sets = {}) {
  Answer a;
  a.verdict = verdict;
  double share = 1;
  for (const auto& [effect, probability] : causes) {
    a.causes.push_back({effect, probability, share, {{"size", {1.0, 0.9, 1.1}}}});
    share /= 2;
  }
  a.ambiguity_sets = sets;
  return a;
}

inline Entry entry(const TrueCase& truth, const Answer& first) {
  Entry e;
  e.truth = truth;
  e.first = e.last = first;
  return e;
}

inline Measure measure(const std::vector<Entry>& entries, const std::string& id,
                       Candidate candidate = Candidate::diagnosis) {
  for (const Measure& m : measures(entries, candidate))
    if (m.id == id) return m;
  throw std::runtime_error("there is no measure " + id);
}

}  // namespace umov::gap::benchmark
