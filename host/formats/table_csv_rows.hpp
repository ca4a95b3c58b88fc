// What the two CSV tables share: rows of numbers with their line, and text of a row.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace umov::formats {

/// Refuses a number of row `line` outside [low, high]. Throws umov::Error.
void require_range(const std::string& file, std::size_t line, std::string_view column, double value,
                   double low, double high);

/// Wavelengths in a file stand in nm, tables hold µm. Neither way adds digits.
double micrometres(double wavelength_nm);
double nanometres(double wavelength_um);

/// Sorted values without repetitions.
std::vector<double> distinct(std::vector<double> values);
/// Position of a value that is in `axis`.
std::size_t position(std::span<const double> axis, double value);

/// Numbers as decimal_text(), with commas and a line end.
void append_row(std::string& out, std::span<const double> numbers);

}  // namespace umov::formats
