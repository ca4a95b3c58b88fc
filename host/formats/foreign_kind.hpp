// Telling by its header line what a CSV file is.
#pragma once

#include <string_view>

namespace umov::formats {

enum class ForeignKind { scan_csv, nist_ptfe, jsss, unknown };

ForeignKind foreign_kind(std::string_view text);

}  // namespace umov::formats
