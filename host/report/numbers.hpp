// Numbers as people in a laboratory write them: no more digits than the uncertainty supports.
#pragma once

#include <string>

namespace umov::report {

/// "0.4893 ± 0.0012": the uncertainty to two significant digits, the value to the same place.
/// Scientific form "(1.234 ± 0.056)×10⁻⁷" beyond 1e-4 … 1e6; without a usable uncertainty
/// (not finite, or not positive) the value alone to four significant digits.
std::string with_uncertainty(double value, double uncertainty);

/// Four significant digits, trailing zeros dropped, powers as "6.6×10⁵", "–" for NaN, "∞" and "−∞".
std::string plain(double value, int digits = 4);

/// "2,764": whole numbers with thousands separators.
std::string count(long long value);

/// Axis of a polariser or analyser as a letter or angle: "P", "S", "U" (open), "45°".
std::string axis_name(double axis_deg);

}  // namespace umov::report
