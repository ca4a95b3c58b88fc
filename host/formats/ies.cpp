// IES LM-63 (1986, 1991, 1995, 2002): keyword lines, TILT=NONE, then numbers.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/photometry.hpp"
#include "host/formats/photometry_planes.hpp"
#include "host/formats/text_lines.hpp"

namespace umov::formats {
namespace {

constexpr double mm_per_foot = 304.8;
constexpr std::size_t most_angles = 5000;

/// Numbers between blanks or commas, over line ends.
class Numbers {
 public:
  Numbers(LineReader& lines, const std::string& file) : lines_(lines), file_(file) {}

  double next(const char* what) {
    while (true) {
      const auto start = rest_.find_first_not_of(" \t,");
      if (start != std::string_view::npos) {
        rest_.remove_prefix(start);
        break;
      }
      if (!lines_.next(rest_))
        throw Error(Place{file_, lines_.line_number(), what}, "the file ends here",
                    "it is cut off: fetch it again");
    }
    const auto end = std::min(rest_.find_first_of(" \t,"), rest_.size());
    double value = 0.0;
    if (const char* wrong = read_decimal(rest_.substr(0, end), value))
      throw Error(Place{file_, lines_.line_number(), what},
                  fmt::format("`{}` {}", rest_.substr(0, end), wrong), "give a number");
    rest_.remove_prefix(end);
    return value;
  }

  std::size_t count(const char* what) {
    const double value = next(what);
    if (!(value >= 1.0 && value <= static_cast<double>(most_angles)) || value != std::floor(value))
      refuse(what, fmt::format("is {:g}", value), "1 to 5000 angles can be read");
    return static_cast<std::size_t>(value);
  }

  [[noreturn]] void refuse(const char* what, const std::string& problem, const char* remedy) const {
    throw Error(Place{file_, lines_.line_number(), what}, problem, remedy);
  }

 private:
  LineReader& lines_;
  const std::string& file_;
  std::string_view rest_;
};

void keyword(std::string_view line, Photometry& into) {
  const auto value_of = [&](std::string_view name) -> std::string {
    return line.starts_with(name) ? std::string(trimmed(line.substr(name.size()))) : std::string();
  };
  if (const auto v = value_of("[TEST]"); !v.empty()) into.report = v;
  if (const auto v = value_of("[MANUFAC]"); !v.empty()) into.maker = v;
  if (const auto v = value_of("[LUMINAIRE]"); !v.empty()) into.name = v;
  if (const auto v = value_of("[LUMCAT]"); !v.empty()) into.number = v;
}

/// `exact`: angles, which must come back in their order.
void append_row(std::string& out, const double* values, std::size_t count, bool exact = false) {
  std::size_t column = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::string number;
    if (exact) {
      number = decimal_text(values[i]);
    } else {
      append_general(number, values[i], 7);
    }
    if (column > 0 && column + number.size() + 1 > 120) {
      out += "\r\n";
      column = 0;
    }
    if (column > 0) {
      out += ' ';
      ++column;
    }
    out += number;
    column += number.size();
  }
  out += "\r\n";
}

}  // namespace

Photometry parse_ies(std::string_view text, const std::string& file) {
  Photometry p;
  LineReader lines(text);
  std::string_view line;
  for (;;) {
    if (!lines.next(line))
      throw Error(Place{file, lines.line_number()}, "there is no TILT= line",
                  "an IES LM-63 file has one before its numbers");
    if (line.starts_with("TILT=")) break;
    keyword(line, p);
  }
  if (trimmed(line.substr(5)) != "NONE")
    throw Error(Place{file, lines.line_number()}, "a lamp that depends on the tilt is not read",
                "give a file with TILT=NONE");
  Numbers numbers(lines, file);
  const double lamps = numbers.next("lamps");
  const double lumens = numbers.next("lumens a lamp");
  const double multiplier = numbers.next("multiplier");
  const std::size_t angles = numbers.count("vertical angles");
  const std::size_t planes = numbers.count("horizontal angles");
  if (numbers.next("photometric type") != 1.0)
    numbers.refuse("photometric type", "is not 1 (type C)", "types A and B are not read");
  const double to_mm = numbers.next("unit") == 1.0 ? mm_per_foot : 1000.0;
  const double width = numbers.next("width");
  const double length = numbers.next("length");
  p.height_mm = to_mm * std::abs(numbers.next("height"));
  const double ballast = numbers.next("ballast factor");
  numbers.next("ballast-lamp factor");
  p.watts = numbers.next("watts");
  // A negative width means a circle of that diameter.
  p.width_mm = width < 0.0 ? 0.0 : to_mm * width;
  p.length_mm = to_mm * (width < 0.0 ? -width : std::abs(length));
  p.lamp_lm = lumens > 0.0 ? lamps * lumens : 0.0;
  check_quantities(p, file);
  for (std::size_t i = 0; i < angles; ++i) p.gamma_deg.push_back(numbers.next("vertical angle"));
  check_angles(p.gamma_deg, 0.0, 180.0, "gamma", file);
  std::vector<double> c_deg;
  for (std::size_t i = 0; i < planes; ++i) c_deg.push_back(numbers.next("horizontal angle"));
  std::vector<std::vector<double>> candela(planes);
  for (auto& row : candela) {
    for (std::size_t i = 0; i < angles; ++i) {
      const double value = multiplier * ballast * numbers.next("candela");
      if (!(value >= 0.0 && value <= largest_quantity))
        numbers.refuse("candela", fmt::format("is {:g}", value), "give intensities from 0");
      row.push_back(value);
    }
  }
  set_planes(p, c_deg, candela, file);
  return p;
}

std::string ies_text(const Photometry& p) {
  std::string out = "IESNA:LM-63-2002\r\n";
  out += "[TEST] " + printable(p.report) + "\r\n[MANUFAC] " + printable(p.maker) + "\r\n[LUMCAT] " +
         printable(p.number) + "\r\n[LUMINAIRE] " + printable(p.name) + "\r\nTILT=NONE\r\n";
  // -1 lumen says: absolute photometry.
  const bool closes = p.c_deg.size() > 1;
  const double lumens = p.lamp_lm > 0.0 ? p.lamp_lm : -1.0;
  const std::array<double, 13> head{1.0,
                                    lumens,
                                    1.0,
                                    static_cast<double>(p.gamma_deg.size()),
                                    static_cast<double>(p.c_deg.size() + (closes ? 1 : 0)),
                                    1.0,
                                    2.0,
                                    p.width_mm > 0.0 ? 1e-3 * p.width_mm : -1e-3 * p.length_mm,
                                    p.width_mm > 0.0 ? 1e-3 * p.length_mm : -1e-3 * p.length_mm,
                                    1e-3 * p.height_mm,
                                    1.0,
                                    1.0,
                                    p.watts};
  append_row(out, head.data(), 10);
  append_row(out, head.data() + 10, 3);
  append_row(out, p.gamma_deg.data(), p.gamma_deg.size(), true);
  std::vector<double> c_deg = p.c_deg;
  if (closes) c_deg.push_back(360.0);
  append_row(out, c_deg.data(), c_deg.size(), true);
  for (std::size_t c = 0; c < c_deg.size(); ++c) {
    append_row(out, p.candela.data() + (c % p.c_deg.size()) * p.gamma_deg.size(),
               p.gamma_deg.size());
  }
  return out;
}

}  // namespace umov::formats
