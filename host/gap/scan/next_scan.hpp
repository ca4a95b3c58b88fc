// Which further scan would tell the remaining explanations apart, and how well.
#pragma once

#include <string>
#include <vector>

#include "host/gap/engine/diagnosis.hpp"
#include "host/gap/scan/scan_model.hpp"

namespace umov::gap::scan {

/// The scans of the menu that separate at least one pair of explanations by three sigma, the best
/// per minute first; empty where nothing on the menu does, or nothing is left to separate.
///
/// A scan's merit is the distance that remains between what the best explanation and a rival
/// foretell for it once the rival's parameters may follow both measurements (Atkinson and Fedorov's
/// T-criterion, with the predictive covariance of Box and Hill), in standard deviations.
std::vector<FurtherScan> further_scans(const ScanModel& model, const Diagnosis& diagnosis);

/// The records that a further scan of the menu takes behind those of `model`, in the ranges that
/// the signal of `truth` asks for. Throws umov::Error for an identifier that is not weighed here.
std::vector<Record> further_records(const ScanModel& model, const std::string& menu,
                                    const Explanation& truth);

/// A plan that takes this scan of the sample: text for `umov scan`.
std::string plan_of(const FurtherScan& scan, const ScanModel& model, const std::string& sample);

}  // namespace umov::gap::scan
