#include "host/toml/spectrum.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "host/errors/error.hpp"

namespace umov {
namespace {

/// A hundred thousand lines.
constexpr std::size_t most_bytes = std::size_t{8} << 20;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else if (c != ' ' && c != '\t' && c != '\r') {
      cells.back() += c;
    }
  }
  return cells;
}

}  // namespace

double Spectrum::at(double wavelength, const std::string& name) const {
  // Rounding of a list of wavelengths is no reason to refuse its ends.
  constexpr double slack = 1e-9;
  if (wavelength_um.empty() || wavelength < wavelength_um.front() - slack ||
      wavelength > wavelength_um.back() + slack) {
    throw Error(fmt::format("{} is not known at {} um", name, wavelength),
                wavelength_um.empty() ? "give it values"
                                      : fmt::format("stay between {} and {} um",
                                                    wavelength_um.front(), wavelength_um.back()));
  }
  const auto above = std::upper_bound(wavelength_um.begin(), wavelength_um.end(), wavelength);
  if (above == wavelength_um.begin()) return value.front();
  if (above == wavelength_um.end()) return value.back();
  const auto i = static_cast<std::size_t>(above - wavelength_um.begin());
  const double part =
      (wavelength - wavelength_um[i - 1]) / (wavelength_um[i] - wavelength_um[i - 1]);
  return value[i - 1] + part * (value[i] - value[i - 1]);
}

Spectrum read_spectrum(const std::filesystem::path& path, const std::string& column) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(Place{path.string()}, "cannot be read", "check its name");
  // One byte beyond the limit, so that a device without an end is refused as well.
  std::string text(most_bytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad())
    throw Error(Place{path.string()}, "cannot be read to its end", "check the disk");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > most_bytes) {
    throw Error(Place{path.string()},
                fmt::format("is larger than {} MiB, too large for a spectrum", most_bytes >> 20),
                "name a CSV file with one line a wavelength");
  }
  return parse_spectrum(text, path.string(), column);
}

Spectrum parse_spectrum(const std::string& text, const std::string& name,
                        const std::string& column) {
  std::istringstream stream(text);
  std::vector<std::string> header;
  std::size_t x = 0;
  std::size_t y = 0;
  double unit = 1.0;
  Spectrum spectrum;
  std::string line;
  for (std::size_t number = 1; std::getline(stream, line); ++number) {
    const Place place{name, number};
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() == 1 && cells[0].empty()) continue;
    if (line.front() == '#') continue;
    if (header.empty()) {
      header = cells;
      const auto find = [&](const std::string& wanted) {
        return static_cast<std::size_t>(std::find(header.begin(), header.end(), wanted) -
                                        header.begin());
      };
      x = find("wavelength_um");
      if (x == header.size()) {
        x = find("wavelength_nm");
        unit = 1e-3;
      }
      y = find(column);
      if (x == header.size() || y == header.size()) {
        throw Error(place,
                    fmt::format("has no column `{}` beside wavelength_um or wavelength_nm", column),
                    fmt::format("its columns are: {}", fmt::join(header, ", ")));
      }
      continue;
    }
    const auto parsed = [&](std::size_t i) {
      double v = 0.0;
      const char* end = i < cells.size() ? cells[i].data() + cells[i].size() : nullptr;
      if (end == nullptr || std::from_chars(cells[i].data(), end, v).ptr != end ||
          cells[i].empty() || !std::isfinite(v)) {
        throw Error(place, fmt::format("has no number in column `{}`", header[i]), "write one");
      }
      return v;
    };
    const double wavelength = unit * parsed(x);
    if (!spectrum.wavelength_um.empty() && wavelength <= spectrum.wavelength_um.back()) {
      throw Error(place, "has a wavelength that does not rise", "sort the rows");
    }
    spectrum.wavelength_um.push_back(wavelength);
    spectrum.value.push_back(parsed(y));
  }
  if (spectrum.value.empty()) throw Error(Place{name}, "holds no spectrum", "add rows");
  return spectrum;
}

}  // namespace umov
