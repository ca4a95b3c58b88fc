// A diagnosis as the JSON that other software reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/gap/answer/tolerance.hpp"
#include "host/gap/engine/diagnosis.hpp"

namespace umov::gap {

/// What a diagnosis said, in short.
struct Outcome {
  Verdict verdict = Verdict::none_needed;
  std::vector<std::pair<std::string, double>> causes;  ///< with probability
  std::vector<std::vector<std::string>> ambiguity_sets;
};

/// A prescribed scan that was taken, and what it changed.
struct FollowUpRound {
  std::string menu, scan;  ///< `scan`: the file
  Outcome before, after;
};

/// How alike a measured image and a simulated one are.
struct ImageLikeness {
  double ncc = 0;    ///< normalised cross-correlation
  double nrmse = 0;  ///< rms difference over the largest value
};

/// What the answer rests on; written beside it.
struct AnswerSource {
  std::size_t records = 0, used = 0;
  std::string sha256;  ///< of the measurement's file; of several, of their hashes in order
  std::string version, command;
  std::uint64_t seed = 1;
  std::string model;  ///< of the base
  std::vector<std::string> notes;
  bool quick = false;             ///< fewer draws, a smaller search, thinned records
  std::vector<SizeLimit> limits;  ///< declared tolerances
  /// Kind ("calibration") and path of what was known beforehand.
  std::vector<std::pair<std::string, std::string>> known;
  std::vector<FollowUpRound> follow_ups;
  std::string follow_up_ended;  ///< why a prescribed scan was not taken
  /// Of an image with the simulation, without and with the causes.
  std::optional<std::pair<ImageLikeness, ImageLikeness>> likeness = {};
};

/// The text of the file, with a new line at its end.
std::string diagnosis_to_json(const Diagnosis& diagnosis, const AnswerSource& source);

}  // namespace umov::gap
