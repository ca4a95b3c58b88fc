#include "host/formats/decimal.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

namespace umov::formats {
namespace {

/// A leading plus sign is usual in other programs' output; from_chars does not take it.
std::string_view without_plus(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+') text.remove_prefix(1);
  return text;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

const char* read_decimal(std::string_view text, double& value) {
  text = without_plus(text);
  if (text.empty()) return "the field is empty";
  double parsed = 0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, parsed);
  if (code == std::errc::result_out_of_range) return "out of the range of a double";
  if (code != std::errc{} || stop != end) return "not a number";
  if (!std::isfinite(parsed)) return "not a finite number";
  value = parsed;
  return nullptr;
}

const char* read_integer(std::string_view text, std::int64_t& value) {
  text = without_plus(text);
  if (text.empty()) return "the field is empty";
  std::int64_t parsed = 0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, parsed);
  if (code == std::errc::result_out_of_range) return "out of the range of a 64-bit integer";
  if (code != std::errc{} || stop != end) return "not an integer";
  value = parsed;
  return nullptr;
}

void append_general(std::string& out, double value, int digits) {
  std::array<char, 64> text;
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value,
                                    std::chars_format::general, digits);
  out.append(text.data(), result.ptr);
}

void append_fixed(std::string& out, double value, int decimals) {
  std::array<char, 512> text;  // 309 digits before the point at most
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value,
                                    std::chars_format::fixed, decimals);
  out.append(text.data(), result.ptr);
}

void append_shortest(std::string& out, double value) {
  std::array<char, 64> text;
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value);
  out.append(text.data(), result.ptr);
}

void append_integer(std::string& out, std::int64_t value) {
  std::array<char, 32> text;
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value);
  out.append(text.data(), result.ptr);
}

std::string decimal_text(double value) {
  std::string text;
  append_general(text, value, 6);
  double back = 0;
  if (read_decimal(text, back) == nullptr && back == value) return text;
  text.clear();
  append_shortest(text, value);
  return text;
}

}  // namespace umov::formats
