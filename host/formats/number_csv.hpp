// Plain CSV with a fixed header line: some text columns, then numbers. Strict, with places.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace umov::formats {

/// Calls `row(texts, numbers, line)` for every line after the header. The header must name exactly
/// `columns`; the first `text_columns` of them hold text, the others finite numbers. The last line
/// needs its line end. Throws umov::Error with file, line and column.
void read_number_csv(
    std::string_view text, const std::string& name, std::span<const std::string_view> columns,
    std::size_t text_columns,
    const std::function<void(std::span<const std::string_view> texts,
                             std::span<const double> numbers, std::size_t line)>& row);

/// Header line of a CSV without reading the rest; empty where there is none.
std::string_view csv_header_line(std::string_view text);

/// All of a stream. Throws umov::Error where it fails.
std::string read_stream(std::istream& in, const std::string& name);

}  // namespace umov::formats
