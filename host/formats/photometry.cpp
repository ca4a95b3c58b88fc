#include "host/formats/photometry.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "host/formats/atomic_file.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/text_lines.hpp"
#include "host/optics/angles.hpp"

namespace umov::formats {
namespace {

using optics::pi;
using optics::radians;

/// ∫ (a + b (γ - γ0)) sin γ dγ over [from, to], radians.
double band(double a, double b, double start, double from, double to) {
  const auto primitive = [&](double g) {
    return -(a + b * (g - start)) * std::cos(g) + b * std::sin(g);
  };
  return primitive(to) - primitive(from);
}

}  // namespace

double Photometry::intensity(double at_c_deg, double at_gamma_deg) const {
  constexpr double edge = 1e-9;
  if (at_gamma_deg < gamma_deg.front() - edge || at_gamma_deg > gamma_deg.back() + edge) return 0.0;
  const auto above = std::upper_bound(gamma_deg.begin(), gamma_deg.end(), at_gamma_deg);
  const auto g1 = static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(above - gamma_deg.begin(), gamma_deg.size() > 1 ? 1 : 0,
                                 static_cast<std::ptrdiff_t>(gamma_deg.size()) - 1));
  const std::size_t g0 = g1 == 0 ? 0 : g1 - 1;
  const double span = gamma_deg[g1] - gamma_deg[g0];
  const double wg = span > 0.0 ? std::clamp((at_gamma_deg - gamma_deg[g0]) / span, 0.0, 1.0) : 0.0;
  const auto in_plane = [&](std::size_t c) {
    const double* row = candela.data() + c * gamma_deg.size();
    return row[g0] + wg * (row[g1] - row[g0]);
  };
  if (c_deg.size() == 1) return in_plane(0);
  double c = std::fmod(at_c_deg, 360.0);
  if (c < 0.0) c += 360.0;
  const auto next = std::upper_bound(c_deg.begin(), c_deg.end(), c);
  const auto c1 = static_cast<std::size_t>(next - c_deg.begin());
  const std::size_t high = c1 == c_deg.size() ? 0 : c1;
  const std::size_t low = c1 == 0 ? c_deg.size() - 1 : c1 - 1;
  const double start = c1 == 0 ? c_deg[low] - 360.0 : c_deg[low];
  const double end = c1 == c_deg.size() ? c_deg[high] + 360.0 : c_deg[high];
  const double wc = (c - start) / (end - start);
  return in_plane(low) + wc * (in_plane(high) - in_plane(low));
}

double Photometry::zonal_lm(double from_deg, double to_deg) const {
  const std::size_t planes = c_deg.size();
  const std::size_t angles = gamma_deg.size();
  double flux = 0.0;
  for (std::size_t c = 0; c < planes; ++c) {
    // Trapezoids in C: each plane stands for half the way to both neighbours.
    const double before = c == 0 ? c_deg.back() - 360.0 : c_deg[c - 1];
    const double after = c + 1 == planes ? c_deg.front() + 360.0 : c_deg[c + 1];
    const double width = planes == 1 ? 2.0 * pi : 0.5 * radians(after - before);
    const double* row = candela.data() + c * angles;
    for (std::size_t g = 0; g + 1 < angles; ++g) {
      const double from = std::max(from_deg, gamma_deg[g]);
      const double to = std::min(to_deg, gamma_deg[g + 1]);
      if (!(to > from)) continue;
      const double slope = (row[g + 1] - row[g]) / radians(gamma_deg[g + 1] - gamma_deg[g]);
      flux += width * band(row[g], slope, radians(gamma_deg[g]), radians(from), radians(to));
    }
  }
  return flux;
}

namespace {

bool looks_like_ies(std::string_view text) {
  return text.starts_with("IESNA") || text.find("TILT=") != std::string_view::npos;
}

/// EULUMDAT has no mark: its lines 2 to 6 are numbers of known ranges.
bool looks_like_eulumdat(std::string_view text) {
  LineReader lines(text);
  std::string_view line;
  lines.next(line);
  constexpr double most[] = {3.0, 4.0, 721.0, 360.0, 721.0};
  for (const double largest : most) {
    if (!lines.next(line)) return false;
    std::string number(trimmed(line));
    std::replace(number.begin(), number.end(), ',', '.');
    double value = 0.0;
    if (read_decimal(number, value) != nullptr || value < 0.0 || value > largest) return false;
  }
  return true;
}

}  // namespace

bool looks_like_photometry(std::string_view text) {
  return looks_like_ies(text) || looks_like_eulumdat(text);
}

Photometry parse_photometry(std::string_view text, const std::string& file) {
  return looks_like_ies(text) ? parse_ies(text, file) : parse_eulumdat(text, file);
}

Photometry read_photometry(const std::filesystem::path& path) {
  constexpr std::size_t most = std::size_t{16} << 20;
  return parse_photometry(read_whole_file(path, most), path.string());
}

}  // namespace umov::formats
