// Strict decimal numbers: the whole field or nothing, never NaN or infinity, no locale.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace umov::formats {

/// Text without blanks (space, tab) at both ends.
std::string_view trimmed(std::string_view text);

/// Reads a finite number ("1", "+1", "-2.5e-3"). Returns nullptr, or what is wrong with the text.
const char* read_decimal(std::string_view text, double& value);
/// Reads an integer ("12", "+1", "-3"; not "1.0"). Returns nullptr, or what is wrong.
const char* read_integer(std::string_view text, std::int64_t& value);

/// Appends as printf's %.<digits>g would.
void append_general(std::string& out, double value, int digits);
/// Appends as printf's %.<decimals>f would.
void append_fixed(std::string& out, double value, int decimals);
/// Appends the shortest text that reads back to the same number.
void append_shortest(std::string& out, double value);
void append_integer(std::string& out, std::int64_t value);
/// %g where that reads back to the same number, otherwise the shortest text that does.
std::string decimal_text(double value);

}  // namespace umov::formats
