// Where a command may write: never over its input or over raw data.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace umov::cli {

/// For products that can't be made again from another file (imports, exports): throws umov::Error
/// where `output` is the same file as `input`, or exists and `force` is not set.
void require_new_output(const std::string& input, const std::string& output, bool force);

/// For products that are made again at will (calibrations, BRDFs, fits, reports): an older one may
/// be replaced. Throws umov::Error where `output` is one of the inputs, a raw scan or its journal.
void require_product_output(const std::vector<std::string>& inputs, const std::string& output);

}  // namespace umov::cli
