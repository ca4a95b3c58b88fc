// A diagnosis in words, on the terminal.
#pragma once

#include <string>
#include <vector>

#include "host/gap/engine/diagnosis.hpp"

namespace umov::cli {

/// One sentence of verdict.
std::string verdict_sentence(const gap::Diagnosis& diagnosis);

void print_diagnosis(const gap::Diagnosis& diagnosis, const std::vector<std::string>& notes);

}  // namespace umov::cli
