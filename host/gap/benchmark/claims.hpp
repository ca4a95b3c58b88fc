// What an answer claims: effects, each up to its ambiguity set.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "host/gap/engine/diagnosis.hpp"

namespace umov::gap::benchmark {

inline constexpr const char* model_cause = "sample_model";

struct AnsweredCause {
  std::string effect;
  double probability = 0, share = 0;
  std::map<std::string, Interval> parameters;
};

/// An answer in the JSON of `umov diagnose`, as far as it is scored. `verdict` "failed": there is
/// none.
struct Answer {
  std::string verdict;
  std::vector<AnsweredCause> causes;
  std::vector<std::set<std::string>> ambiguity_sets;
  std::map<std::string, double> probabilities;  ///< of the whole catalogue, where it is given
  bool has_gap = false;
  double g2_before = 0, g2_after = 0;
  double records_used = 0;  ///< 0 where it is not said

  /// Something significant is said to stay unexplained.
  bool flags_unknown() const { return verdict == "unexplained" || verdict == "explained_in_part"; }
  const AnsweredCause* cause(const std::string& effect) const;
};

/// `name` is said in errors. Throws umov::Error where the text is no answer.
Answer parse_answer(const std::string& text, const std::string& name);

/// One effect that is claimed to be there.
struct Claim {
  std::string lead;  ///< the cause as listed; the one with the largest share of its set
  std::set<std::string> members;  ///< what it may be instead, itself included
  double share = 0;               ///< of all causes listed in the set

  /// Only the reflectance model is said to be too poor.
  bool is_model() const { return lead == model_cause; }
};

/// Claims, instrument effects first, by share. Causes of one ambiguity set are claimed together:
/// as many of them as their probabilities add up to (rounded), never more than are listed. So a
/// cause is named where its probability, or the sum over its set, is .5 or more.
std::vector<Claim> claims_of(const Answer& answer);

/// How many of `effects` can be matched one to one with claims whose members hold them. `open`,
/// where given, receives the claims that were left without a partner.
std::size_t matched(const std::vector<std::string>& effects, const std::vector<Claim>& claims,
                    std::vector<Claim>* open = nullptr);

}  // namespace umov::gap::benchmark
