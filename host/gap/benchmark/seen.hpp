// A case as one candidate answered it, for the measures and the list of misses.
#pragma once

#include <string>
#include <vector>

#include "host/gap/benchmark/score.hpp"

namespace umov::gap::benchmark {

struct Seen {
  const Entry* entry;
  const TrueCase* truth;
  const Answer *first, *last;
  std::vector<Claim> claims, last_claims;

  const TrueEffect& effect() const { return truth->effects.front(); }
  bool is(const char* kind) const { return truth->kind == kind; }
};

using Cases = std::vector<Seen>;

/// Entries without an answer of the candidate are left out.
Cases seen_by(const std::vector<Entry>& entries, Candidate candidate);
std::vector<std::string> names_of(const TrueCase& truth);
/// A double both of whose effects are at least this large, alone or beside each other.
bool pair_of(const Seen& c, double rho, bool given_others);
/// The effect that a crowd's case enlarges; the first where none is marked.
const std::string& enlarged(const Seen& c);

}  // namespace umov::gap::benchmark
