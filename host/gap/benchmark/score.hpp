// The score of a diagnosis on cases whose effects were withheld.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/gap/benchmark/claims.hpp"
#include "host/gap/benchmark/truth.hpp"

namespace umov::gap::benchmark {

/// A case with what was answered.
struct Entry {
  TrueCase truth;
  Answer first;  ///< on the case's own scan
  Answer last;   ///< after the prescribed scans; `first` where none was taken
  std::optional<Answer> largest_residual, forward_bic, oracle;
  std::string rivals_failed;  ///< why none of these could answer; empty otherwise
  double seconds = 0;         ///< of one core; 0 where it is not known
  double further_seconds = 0;
};

/// Whose answers are looked at.
enum class Candidate { diagnosis, largest_residual, forward_bic, oracle };

/// One figure.
struct Measure {
  std::string id;                   ///< as in JSON
  std::string title;                ///< what it is, in words
  std::size_t n = 0;                ///< cases, effects or claims it rests on
  std::optional<std::size_t> hits;  ///< of a proportion
  Interval value;                   ///< 95 %; NaN where n is 0
  double least = -std::numeric_limits<double>::infinity();  ///< target
  double most = std::numeric_limits<double>::infinity();
  bool headline = false;  ///< in the table of targets
  /// False for what an oracle that is told the effects has no say in.
  bool oracle_has_it = true;

  bool has_target() const { return least > -1e300 || most < 1e300; }
  bool met() const { return value.value >= least && value.value <= most; }
  /// The whole interval lies on the same side of the target; never for resampled figures of fewer
  /// than ten.
  bool surely() const;
};

/// Every measure, in the same order whatever the entries hold. Entries without an answer of this
/// candidate are left out. Results depend on `seed` within the error of resampling.
std::vector<Measure> measures(const std::vector<Entry>& entries, Candidate candidate,
                              std::uint64_t seed = 1);

/// The same entries, each with another case's truth: what the measures say of answers that know
/// nothing of their case.
std::vector<Entry> permuted(std::vector<Entry> entries, std::uint64_t seed);

// What the measures and the breakdowns are made of.

/// Claims that neither match the truth nor name only a reflectance that is indeed richer than the
/// diagnoser's base.
std::size_t wrongful(const TrueCase& truth, const std::vector<Claim>& claims);
/// Something is said to be the matter that a right model of reflectance does not settle.
bool alarmed(const TrueCase& truth, const Answer& answer);
/// The first claim holds this effect.
bool leads(const std::vector<Claim>& claims, const std::string& effect);
/// Every effect claimed, nothing else claimed.
bool exact(const TrueCase& truth, const std::vector<Claim>& claims);
/// Only catalogue effects, few of them: single, double, triple, confounded.
bool few_known(const TrueCase& truth);
/// The plan's scan stays in the plane of incidence with one arrangement of the sample.
bool in_plane(const TrueCase& truth);
/// "dust .93 or stray_forward", for lists.
std::string claims_text(const Answer& answer);

}  // namespace umov::gap::benchmark
