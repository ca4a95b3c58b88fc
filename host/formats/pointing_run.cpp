#include "host/formats/pointing_run.hpp"

#include <array>
#include <string>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/text_lines.hpp"

namespace umov::formats {
namespace {

/// The two numbers behind a label.
std::array<double, 2> two_numbers(std::string_view rest, const std::string& name,
                                  std::size_t line) {
  std::array<double, 2> numbers{};
  for (std::size_t i = 0; i < 2; ++i) {
    rest = trimmed(rest);
    const std::size_t end = std::min(rest.find_first_of(" \t"), rest.size());
    if (const char* wrong = read_decimal(rest.substr(0, end), numbers[i]))
      throw Error(Place{name, line, i == 0 ? "altitude" : "azimuth"}, wrong,
                  "a line reads `RAA: altitude azimuth`, in degrees");
    rest.remove_prefix(end);
  }
  if (numbers[0] < 0 || numbers[0] > 90)
    throw Error(Place{name, line, "altitude"}, "is not within 0 to 90 deg",
                "altitude comes first, then azimuth");
  return numbers;
}

}  // namespace

PointingRun parse_pointing_run(std::string_view text, const std::string& name) {
  PointingRun run;
  LineReader lines(text);
  std::string_view line;
  bool waiting = false;
  while (lines.next(line)) {
    if (line.starts_with("RAA:")) {
      if (waiting)
        throw Error(Place{name, lines.line_number(), ""}, "a star without its TAA line",
                    "every RAA line needs one TAA line behind it");
      const auto [altitude, azimuth] = two_numbers(line.substr(4), name, lines.line_number());
      run.encoder_altitude_deg.push_back(altitude);
      run.encoder_azimuth_deg.push_back(azimuth);
      waiting = true;
    } else if (line.starts_with("TAA:")) {
      if (!waiting)
        throw Error(Place{name, lines.line_number(), ""}, "a TAA line without its RAA line",
                    "every TAA line needs one RAA line before it");
      const auto [altitude, azimuth] = two_numbers(line.substr(4), name, lines.line_number());
      run.true_altitude_deg.push_back(altitude);
      run.true_azimuth_deg.push_back(azimuth);
      waiting = false;
    }
  }
  if (waiting || run.size() == 0)
    throw Error(Place{name, lines.line_number(), ""},
                run.size() == 0 ? "holds no star" : "ends within a star",
                "a pointing run has lines `RAA: …` and `TAA: …` for every star");
  return run;
}

PointingRun read_pointing_run(const std::filesystem::path& path) {
  return parse_pointing_run(read_whole_file(path), path.string());
}

}  // namespace umov::formats
