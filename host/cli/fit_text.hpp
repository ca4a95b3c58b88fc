// A fit on the terminal.
#pragma once

#include <string>
#include <vector>

#include "host/formats/fit_file.hpp"
#include "host/invert/row_selection.hpp"

namespace umov::cli {

/// Parameters, reflectance, identifiability and notes, as a table for people; `output` is where the
/// fit went.
void print_fit(const formats::FitResult& fit, const std::string& output);
/// How well fitted and withheld rows are foretold; nothing where there are none.
void print_prediction(const std::vector<invert::PredictionError>& errors);

}  // namespace umov::cli
