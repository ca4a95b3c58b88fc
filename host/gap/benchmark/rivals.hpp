// What a diagnosis is measured by: two simple ways to name an effect, and an oracle that knows it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/formats/scan_table.hpp"
#include "host/gap/scan/diagnose_scan.hpp"

namespace umov::gap::benchmark {

/// Answers of the others, each in the JSON of a diagnosis, as one JSON object:
///
/// - `largest_residual`: the one effect, series of the reflectance included, whose signature at the
///   base model's fit correlates best with its residual, where the gain in χ² is above the 99 %
///   point of the largest gain of a small effect in noise alone. No alternatives, no second effect.
/// - `forward_bic`: on the same linear view effects are taken in one after the other, the best each
///   time, as long as Schwarz' criterion falls, five at most. No alternatives.
/// - `oracle` (where `known` is given): the effects by these names fitted, and nothing else; those
///   are named whose principal parameter is away from its absence by 2.58 standard errors (99 %).
///   With `sample_model` among the names it takes in the richer reflectance that the search of the
///   diagnosis found, as far as evidence asks for it.
///
/// `diagnosis` gives noise, folds and the base model's fit, so that all gaps are measured alike.
std::string rival_answers(const std::vector<formats::ScanTable>& scans,
                          const scan::ScanDiagnoseOptions& options,
                          const scan::ScanDiagnosis& diagnosis,
                          const std::optional<std::vector<std::string>>& known);

}  // namespace umov::gap::benchmark
