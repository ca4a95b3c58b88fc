// EULUMDAT (.ldt; A. Stockmar, 1990): one value a line, intensities in cd per 1000 lm of the lamps.
#include <fmt/format.h>

#include <cmath>
#include <string>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/photometry.hpp"
#include "host/formats/photometry_planes.hpp"
#include "host/formats/text_lines.hpp"

namespace umov::formats {
namespace {

constexpr std::size_t most_angles = 721;

class Lines {
 public:
  Lines(std::string_view text, const std::string& file) : lines_(text), file_(file) {}

  std::string_view text(const char* what) {
    std::string_view line;
    if (!lines_.next(line)) refuse(what, "the file ends here", "it is cut off: fetch it again");
    return line;
  }
  double number(const char* what) {
    const std::string_view line = trimmed(text(what));
    double value = 0.0;
    // Some writers use a decimal comma.
    std::string dotted(line);
    for (char& c : dotted) c = c == ',' ? '.' : c;
    if (dotted.empty()) return 0.0;
    if (const char* wrong = read_decimal(dotted, value))
      refuse(what, fmt::format("`{}` {}", line, wrong), "give a number");
    return value;
  }
  std::size_t count(const char* what, std::size_t most) {
    const double value = number(what);
    if (!(value >= 0.0 && value <= static_cast<double>(most)) || value != std::floor(value))
      refuse(what, fmt::format("is {:g}", value), "give a whole number within the format's range");
    return static_cast<std::size_t>(value);
  }
  void skip(int lines, const char* what) {
    for (int i = 0; i < lines; ++i) text(what);
  }
  [[noreturn]] void refuse(const char* what, const std::string& problem, const char* remedy) const {
    throw Error(Place{file_, lines_.line_number(), what}, problem, remedy);
  }

 private:
  LineReader lines_;
  const std::string& file_;
};

}  // namespace

Photometry parse_eulumdat(std::string_view text, const std::string& file) {
  Photometry p;
  Lines lines(text, file);
  p.maker = std::string(trimmed(lines.text("company")));
  lines.number("type");
  const std::size_t symmetry = lines.count("symmetry", 4);
  const std::size_t planes = lines.count("C planes", most_angles);
  lines.number("distance between C planes");
  const std::size_t angles = lines.count("gamma angles", most_angles);
  lines.number("distance between gamma angles");
  if (planes == 0 || angles < 2)
    lines.refuse("C planes", fmt::format("{} planes of {} angles", planes, angles),
                 "a distribution has one plane of two angles at least");
  p.report = std::string(trimmed(lines.text("report")));
  p.name = std::string(trimmed(lines.text("name")));
  p.number = std::string(trimmed(lines.text("number")));
  lines.skip(2, "file, date");
  lines.skip(3, "size of the luminaire");
  p.length_mm = lines.number("luminous length");
  p.width_mm = lines.number("luminous width");
  p.height_mm = lines.number("luminous height");
  lines.skip(3, "luminous heights");
  lines.skip(2, "fractions");
  const double factor = lines.number("conversion factor");
  lines.skip(1, "tilt");
  const std::size_t sets = lines.count("lamp sets", 20);
  for (std::size_t i = 0; i < sets; ++i) {
    lines.skip(2, "lamp");
    const double lumens = lines.number("lamp flux");
    lines.skip(2, "colour");
    const double watts = lines.number("watts");
    if (i > 0) continue;  // further sets are alternatives
    p.lamp_lm = lumens;
    p.watts = watts;
  }
  if (!(p.lamp_lm > 0.0))
    lines.refuse("lamp flux", fmt::format("is {:g} lm", p.lamp_lm), "it must be above 0");
  check_quantities(p, file);
  lines.skip(10, "direct ratios");
  std::vector<double> all_c;
  for (std::size_t i = 0; i < planes; ++i) all_c.push_back(lines.number("C"));
  for (std::size_t i = 0; i < angles; ++i) p.gamma_deg.push_back(lines.number("gamma"));
  check_angles(p.gamma_deg, 0.0, 180.0, "gamma", file);
  // Which planes are stored: all; one; C0 to C180; C90 to C270; C0 to C90.
  std::size_t first = 0;
  std::size_t stored = planes;
  if (symmetry == 1) stored = 1;
  if (symmetry == 2 || symmetry == 3) stored = planes / 2 + 1;
  if (symmetry == 3) first = planes / 4;
  if (symmetry == 4) stored = planes / 4 + 1;
  if (first + stored > planes && !(symmetry == 0))
    lines.refuse("symmetry", fmt::format("{} does not fit {} planes", symmetry, planes),
                 "their number must be a multiple of 4");
  std::vector<double> c_deg;
  std::vector<std::vector<double>> candela(stored);
  for (std::size_t i = 0; i < stored; ++i) {
    c_deg.push_back(stored == 1 ? 0.0 : all_c[first + i]);
    for (std::size_t g = 0; g < angles; ++g) {
      const double value = lines.number("intensity");
      const double cd = value * (factor > 0.0 ? factor : 1.0) * p.lamp_lm / 1000.0;
      if (!(cd >= 0.0 && cd <= largest_quantity))
        lines.refuse("intensity", fmt::format("is {:g} cd", cd), "give intensities from 0");
      candela[i].push_back(cd);
    }
  }
  set_planes(p, c_deg, candela, file);
  return p;
}

std::string eulumdat_text(const Photometry& p) {
  if (p.gamma_deg.size() < 2 || p.c_deg.size() > most_angles || p.gamma_deg.size() > most_angles)
    throw Error(fmt::format("{} planes of {} angles do not fit EULUMDAT", p.c_deg.size(),
                            p.gamma_deg.size()),
                fmt::format("it has up to {} planes of 2 to {} angles; IES LM-63 has no such limit",
                            most_angles, most_angles));
  const bool turning = p.c_deg.size() == 1;
  const double lamp_lm = p.lamp_lm > 0.0 ? p.lamp_lm : 1000.0;
  const auto spacing = [](const std::vector<double>& deg) {
    if (deg.size() < 2) return 0.0;
    for (std::size_t i = 2; i < deg.size(); ++i) {
      if (std::abs(deg[i] - deg[i - 1] - (deg[1] - deg[0])) > 1e-6) return 0.0;
    }
    return deg[1] - deg[0];
  };
  std::string out;
  const auto text = [&](const std::string& line) { out += line + "\r\n"; };
  const auto number = [&](double value) {
    append_general(out, value, 7);
    out += "\r\n";
  };
  const double flux = p.zonal_lm();
  text(printable(p.maker, 78));
  number(turning ? 1 : 3);
  number(turning ? 1 : 0);
  number(static_cast<double>(p.c_deg.size()));
  number(spacing(p.c_deg));
  number(static_cast<double>(p.gamma_deg.size()));
  number(spacing(p.gamma_deg));
  text(printable(p.report, 78));
  text(printable(p.name, 78));
  text(printable(p.number, 78));
  text("");
  text("");
  for (const double mm : {p.length_mm, p.width_mm, p.height_mm}) number(mm);  // of the luminaire
  number(p.length_mm);
  number(p.width_mm);
  for (int i = 0; i < 4; ++i) number(p.height_mm);
  number(flux > 0.0 ? 100.0 * p.zonal_lm(0.0, 90.0) / flux : 0.0);
  number(100.0 * flux / lamp_lm);
  number(1.0);
  number(0.0);
  number(1);
  number(1);
  text("");
  number(lamp_lm);
  text("");
  text("");
  number(p.watts);
  for (int i = 0; i < 10; ++i) number(0.0);
  for (const auto* angles : {&p.c_deg, &p.gamma_deg}) {
    for (const double deg : *angles) text(decimal_text(deg));
  }
  for (const double cd : p.candela) number(1000.0 * cd / lamp_lm);
  return out;
}

}  // namespace umov::formats
