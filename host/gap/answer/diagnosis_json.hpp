// A diagnosis as the JSON that other software reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/gap/engine/diagnosis.hpp"

namespace umov::gap {

/// What the answer rests on; written beside it.
struct AnswerSource {
  std::size_t records = 0, used = 0;
  std::string sha256;  ///< of the measurement's file; of several, of their hashes in order
  std::string version, command;
  std::uint64_t seed = 1;
  std::string model;  ///< of the base
  std::vector<std::string> notes;
};

/// The text of the file, with a new line at its end.
std::string diagnosis_to_json(const Diagnosis& diagnosis, const AnswerSource& source);

}  // namespace umov::gap
