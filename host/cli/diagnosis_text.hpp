// A diagnosis in words, on the terminal.
#pragma once

#include "host/gap/answer/diagnosis_json.hpp"

namespace umov::cli {

void print_diagnosis(const gap::Diagnosis& diagnosis, const gap::AnswerSource& source);

}  // namespace umov::cli
