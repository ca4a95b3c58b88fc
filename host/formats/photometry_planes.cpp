#include "host/formats/photometry_planes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"

namespace umov::formats {

void check_angles(const std::vector<double>& deg, double low, double high, const char* what,
                  const std::string& file) {
  if (deg.empty()) throw Error(Place{file, 0, what}, "there is none", "list one at least");
  for (std::size_t i = 0; i < deg.size(); ++i) {
    if (deg[i] >= low && deg[i] <= high && (i == 0 || deg[i] > deg[i - 1])) continue;
    throw Error(Place{file, 0, what}, fmt::format("{:g}° does not rise or is out of range", deg[i]),
                fmt::format("angles rise from {:g}° to {:g}° at most", low, high));
  }
}

std::string printable(const std::string& text, std::size_t most) {
  std::string line;
  for (const char c : text.substr(0, most)) line += c >= ' ' && c <= '~' ? c : '?';
  return std::string(trimmed(line));
}

void check_quantities(const Photometry& p, const std::string& file) {
  const auto check = [&](const char* what, double value, double least) {
    if (value >= least && value <= largest_quantity) return;
    throw Error(Place{file, 0, what}, fmt::format("is {:g}", value),
                "check the number and its unit");
  };
  check("lumens", p.lamp_lm, 0.0);
  check("watts", p.watts, -largest_quantity);
  check("length", p.length_mm, 0.0);
  check("width", p.width_mm, 0.0);
  check("height", p.height_mm, 0.0);
}

void set_planes(Photometry& into, const std::vector<double>& c_deg,
                const std::vector<std::vector<double>>& candela, const std::string& file) {
  check_angles(c_deg, 0.0, 360.0, "C", file);
  const double first = c_deg.front();
  const double last = c_deg.back();
  const auto near = [](double a, double b) { return std::abs(a - b) < 1e-6; };
  if (c_deg.size() > 1 && !near(first, 0.0) && !(near(first, 90.0) && near(last, 270.0)))
    throw Error(Place{file, 0, "C"}, fmt::format("planes from {:g}° to {:g}°", first, last),
                "planes start at 0°, or run from 90° to 270°");
  std::map<double, const std::vector<double>*> all;
  const auto put = [&](double c, const std::vector<double>& row) {
    c = std::fmod(c + 720.0, 360.0);
    // Mirrored angles carry rounding; the first that comes stays.
    const auto after = all.lower_bound(c - 1e-6);
    if (after != all.end() && after->first < c + 1e-6) return;
    if (c > 360.0 - 1e-6) return;
    all.emplace(c, &row);
  };
  for (std::size_t i = 0; i < c_deg.size(); ++i) put(c_deg[i], candela[i]);
  if (c_deg.size() > 1) {
    for (std::size_t i = 0; i < c_deg.size(); ++i) {
      if (near(first, 90.0)) {
        put(180.0 - c_deg[i], candela[i]);  // about the plane C90–C270
      } else if (near(last, 180.0) || near(last, 90.0)) {
        put(-c_deg[i], candela[i]);  // about C0–C180
      }
      if (near(first, 0.0) && near(last, 90.0)) {
        put(180.0 - c_deg[i], candela[i]);
        put(180.0 + c_deg[i], candela[i]);
      }
    }
  }
  into.c_deg.clear();
  into.candela.clear();
  for (const auto& [c, row] : all) {
    into.c_deg.push_back(c);
    into.candela.insert(into.candela.end(), row->begin(), row->end());
  }
}

}  // namespace umov::formats
