#include "host/report/numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "host/formats/scan_table.hpp"

namespace umov::report {

namespace {

/// Decimal places that show `width` to two significant digits ("0.0012" has 4).
/// A width that rounds up to the next power of ten (0.00996 to 0.010) has one fewer.
int places_for(double width) {
  const int places = 1 - static_cast<int>(std::floor(std::log10(width)));
  const double two_digits = std::round(width * std::pow(10.0, places));
  return std::max(0, two_digits >= 100 ? places - 1 : places);
}

/// A proper minus sign instead of the hyphen, none before zeros; exponents keep theirs.
std::string minus(std::string text) {
  if (text.find_first_not_of("-0.") == std::string::npos && text.size() > 1 && text.front() == '-')
    text.erase(0, 1);
  if (!text.empty() && text.front() == '-') text.replace(0, 1, "−");
  return text;
}

/// "×10⁻⁷".
std::string power_of_ten(int exponent) {
  static constexpr std::array<const char*, 10> raised{"⁰", "¹", "²", "³", "⁴",
                                                      "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "×10⁻" : "×10";
  for (const char digit : std::to_string(std::abs(exponent)))
    text += raised[static_cast<std::size_t>(digit - '0')];
  return text;
}

bool plain_range(double magnitude) {
  return magnitude >= 1e-4 && magnitude < 1e6;
}

}  // namespace

std::string plain(double value, int digits) {
  if (std::isnan(value)) return "–";
  if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
  std::string text = fmt::format("{:.{}g}", value, digits);
  if (const auto e = text.find('e'); e != std::string::npos)
    text = text.substr(0, e) + power_of_ten(std::atoi(text.c_str() + e + 1));
  return minus(text);
}

std::string with_uncertainty(double value, double uncertainty) {
  if (!std::isfinite(value)) return plain(value);
  if (!std::isfinite(uncertainty) || uncertainty <= 0) return plain(value);
  const double magnitude = std::max(std::abs(value), uncertainty);
  if (plain_range(magnitude) && uncertainty > 1e-9) {
    const int places = places_for(uncertainty);
    return fmt::format("{} ± {:.{}f}", minus(fmt::format("{:.{}f}", value, places)), uncertainty,
                       places);
  }
  const int exponent = static_cast<int>(std::floor(std::log10(magnitude)));
  const double scale = std::pow(10.0, exponent);
  const int places = std::min(9, places_for(uncertainty / scale));
  return fmt::format("({} ± {:.{}f}){}", minus(fmt::format("{:.{}f}", value / scale, places)),
                     uncertainty / scale, places, power_of_ten(exponent));
}

std::string count(long long value) {
  std::string digits = std::to_string(std::abs(value));
  for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3)
    digits.insert(static_cast<std::size_t>(at), ",");
  return (value < 0 ? "−" : "") + digits;
}

std::string axis_name(double axis_deg) {
  if (formats::is_open(axis_deg)) return "U";
  if (std::abs(axis_deg) < 1e-6) return "P";
  if (std::abs(axis_deg - 90.0) < 1e-6) return "S";
  return plain(axis_deg) + "°";
}

}  // namespace umov::report
