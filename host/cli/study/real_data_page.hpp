// What came out of the trials on real data, as a page.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "host/cli/study/foretelling.hpp"
#include "host/cli/study/in_plane_trial.hpp"
#include "host/cli/study/study.hpp"

namespace umov::study {

/// Scores of one attempt.
struct Judged {
  Score in_plane, out_of_plane, with_remainder;
  Score clear;  ///< out of plane where the noise is below 10 %
  std::array<Score, region_names.size()> regions{};
  /// Root mean square error of m_ij/f11 out of plane, the 15 elements and the 8 linear ones; 0
  /// where no matrices were measured.
  double matrix_rms = 0, linear_rms = 0;
};

struct TrialResult {
  const Trial* trial = nullptr;
  std::vector<Attempt> attempts;
  std::vector<Judged> judged;  ///< one an attempt

  /// Index of the attempt of one of these kinds with the least median out of plane (of
  /// with_remainder where asked for); attempts.size() where there is none.
  std::size_t best(const std::vector<Attempt::Kind>& kinds, bool with_remainder = false) const;
  /// The model that the in-plane rows alone would choose, by its BIC; attempts.size() where none.
  std::size_t chosen() const;
};

/// Fills `judged`.
void judge(TrialResult& result);

Page real_data_page(const std::vector<TrialResult>& results,
                    const std::vector<std::string>& skipped, const Options& options);

}  // namespace umov::study
