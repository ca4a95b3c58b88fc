// A score as Markdown and as JSON.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/gap/benchmark/score.hpp"

namespace umov::gap::benchmark {

/// What the score rests on, said at its head.
struct ScoreSource {
  std::string seal_sha256;  ///< of the truth
  std::size_t cases = 0;    ///< in the truth; those without an answer are left out
  std::string run;          ///< the record of `umov blind run` as JSON; empty where there is none
  bool leave_out = false;   ///< each case was diagnosed without its own effect
  std::uint64_t seed = 1;   ///< of resampling and permutation
};

/// `brief`: without the lists behind the table of targets.
std::string score_markdown(const std::vector<Entry>& entries, const ScoreSource& source,
                           bool brief = false);
std::string score_json(const std::vector<Entry>& entries, const ScoreSource& source);

}  // namespace umov::gap::benchmark
