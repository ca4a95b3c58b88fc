// Single rules of the scan contract, shared by readers (which know the line) and `validate`.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/scan_columns.hpp"

namespace umov::formats {

inline constexpr const char* out_of_plane_remedy =
    "out of plane theta_r_deg is 0 to 90 and phi_r_deg turns: write the retro side with phi_r_deg "
    "+ 180";

/// What a column may hold, in words.
std::string column_range_text(const ScanColumn& column);
bool within_column(const ScanColumn& column, double value);
/// Keys with a number as value.
bool is_numeric_key(std::string_view key);
/// Keys the contract names: they may stand once only.
bool is_contract_key(std::string_view key);
/// What is wrong with a header key's value; empty where nothing is.
std::string key_problem(const std::string& key, const std::string& value);
/// What is wrong with a block's name or range; empty where nothing is.
std::string block_problem(const Block& block, const std::vector<std::int64_t>& index);

}  // namespace umov::formats
