#include "host/formats/cornell_brdf.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/scan_table.hpp"
#include "host/formats/text_lines.hpp"
#include "host/optics/angles.hpp"

namespace umov::formats {
namespace {

constexpr std::size_t most_wavelengths = 4096;
constexpr double relative_u = 0.025;  ///< reciprocity scatter of garnet red at 650 nm
constexpr std::size_t zeros_for_a_floor = 5;
constexpr double half_pi = std::numbers::pi / 2;
constexpr double rounding = 1e-6;  ///< of angles in the file, radians

struct Record {
  double theta_i, phi_i, theta_s, phi_s;
  std::vector<double> brdf_per_sr;
};

struct File {
  std::vector<std::string> title;  ///< comments before the first number
  std::vector<double> wavelengths_nm;
  std::vector<Record> records;
};

void split_blanks(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  std::size_t at = 0;
  while ((at = line.find_first_not_of(" \t", at)) != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(" \t", at), line.size());
    fields.push_back(line.substr(at, end - at));
    at = end;
  }
}

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& file) : lines_(bytes), file_(file) {}

  File read() {
    if (!next()) fail({}, "holds no numbers", "the file is empty or cut off");
    std::int64_t count = 0;
    if (fields_.size() != 1 || read_integer(fields_[0], count) != nullptr || count < 1 ||
        count > static_cast<std::int64_t>(most_wavelengths))
      fail({}, "should be the number of wavelengths alone", "the file is of another kind");
    title_open_ = false;
    while (contents_.wavelengths_nm.size() < static_cast<std::size_t>(count)) {
      if (!next()) fail({}, "the wavelengths are not complete", "the file may be cut off");
      for (const std::string_view field : fields_)
        add_wavelength(field, static_cast<std::size_t>(count));
    }
    while (next()) add_record();
    if (contents_.records.empty()) fail({}, "there are no records", "the file may be cut off");
    return std::move(contents_);
  }

 private:
  [[noreturn]] void fail(std::string_view column, const std::string& problem,
                         const std::string& remedy) const {
    throw Error(Place{file_, lines_.line_number(), std::string(column)}, problem, remedy);
  }

  /// Fields of the next line that is neither blank nor a comment.
  bool next() {
    std::string_view line;
    while (lines_.next(line)) {
      if (is_blank(line)) continue;
      if (line.starts_with('#')) {
        if (title_open_) contents_.title.emplace_back(trimmed(line.substr(1)).substr(0, 200));
        continue;
      }
      lines_.require_line_end(line, file_);
      split_blanks(line, fields_);
      return true;
    }
    return false;
  }

  double number(std::string_view field, std::string_view column, double low, double high) const {
    double value = 0;
    if (const char* problem = read_decimal(field, value))
      fail(column, std::string(problem) + ": \"" + std::string(field.substr(0, 40)) + "\"",
           "give a plain decimal number");
    if (!(value >= low && value <= high))
      fail(column, decimal_text(value) + " is out of range",
           "values lie from " + decimal_text(low) + " to " + decimal_text(high));
    return value;
  }

  void add_wavelength(std::string_view field, std::size_t count) {
    auto& list = contents_.wavelengths_nm;
    if (list.size() == count)
      fail("wavelength", "there are more wavelengths than announced", "correct their number");
    const double nm = number(field, "wavelength", 50, 1e5);
    if (!list.empty() && !(nm > list.back()))
      fail("wavelength", "wavelengths do not ascend", "sort the columns");
    list.push_back(nm);
  }

  void add_record() {
    const std::size_t wanted = 4 + contents_.wavelengths_nm.size();
    if (fields_.size() != wanted)
      fail({}, fmt::format("the record has {} numbers, not {}", fields_.size(), wanted),
           "four angles and one value a wavelength; the file may be cut off");
    constexpr double turn = 2 * std::numbers::pi + rounding;
    Record record{number(fields_[0], "theta_i", 0, half_pi - rounding),
                  number(fields_[1], "phi_i", -turn, turn),
                  number(fields_[2], "theta_s", 0, half_pi),
                  number(fields_[3], "phi_s", -turn, turn),
                  {}};
    for (std::size_t w = 4; w < wanted; ++w)
      record.brdf_per_sr.push_back(number(fields_[w], "brdf", 0, 1e6));
    const std::array<double, 3> direction{
        record.theta_i, record.theta_s,
        std::remainder(record.phi_s - record.phi_i, 2 * std::numbers::pi)};
    if (!directions_.insert(direction).second)
      fail({}, "a direction is given twice", "keep one record");
    contents_.records.push_back(std::move(record));
  }

  LineReader lines_;
  std::string file_;
  bool title_open_ = true;
  std::vector<std::string_view> fields_;
  std::set<std::array<double, 3>> directions_;
  File contents_;
};

/// Noise of the detector shows as c/cos θi in the BRDF. Where z values of a wavelength came out
/// below zero and were clipped, about as many were driven the other way: c is the root mean square
/// of the z smallest values left, times cos θi. Wavelengths with too few zeros take the median.
std::vector<double> floors(const File& file) {
  std::vector<double> list(file.wavelengths_nm.size(), 0.0), known;
  for (std::size_t w = 0; w < list.size(); ++w) {
    std::vector<double> positive;
    std::size_t zeros = 0;
    for (const Record& record : file.records) {
      const double scaled = record.brdf_per_sr[w] * std::cos(record.theta_i);
      if (scaled > 0) {
        positive.push_back(scaled);
      } else {
        ++zeros;
      }
    }
    if (zeros < zeros_for_a_floor || positive.size() < zeros) continue;
    std::nth_element(positive.begin(), positive.begin() + static_cast<std::ptrdiff_t>(zeros) - 1,
                     positive.end());
    double squares = 0;
    for (std::size_t n = 0; n < zeros; ++n) squares += positive[n] * positive[n];
    list[w] = std::sqrt(squares / static_cast<double>(zeros));
    known.push_back(list[w]);
  }
  if (known.empty()) return list;
  std::nth_element(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2),
                   known.end());
  for (double& floor : list)
    if (floor == 0) floor = known[known.size() / 2];
  return list;
}

/// Angles in the file have six decimals; what they were meant as has fewer.
double tidy_deg(double radians) {
  return std::round(optics::degrees(radians) * 1e3) / 1e3 + 0.0;
}

}  // namespace

bool is_cornell_brdf(std::string_view bytes) {
  const std::string_view start = bytes.substr(0, 65536);
  LineReader lines(start);
  std::string_view line;
  std::int64_t count = 0;
  while (lines.next(line)) {
    if (is_blank(line) || line.starts_with('#')) continue;
    return read_integer(trimmed(line), count) == nullptr && count >= 1 && start.starts_with('#');
  }
  return false;
}

BrdfTable read_cornell_brdf(std::string_view bytes, const std::string& file) {
  const File contents = Reader(bytes, file).read();
  const std::vector<double> floor = floors(contents);
  BrdfTable table;
  std::string sample;
  for (const std::string& line : contents.title) {
    // The comments end with the names of the columns.
    if (line.empty() || line.starts_with("num wls")) continue;
    sample += (sample.empty() ? "" : "; ") + line;
  }
  table.keys = {{"sample", sample.empty() ? "unnamed" : sample},
                {"role", "sample"},
                {"source", "Cornell gonioreflectometer text, " + file},
                {"uncertainty",
                 fmt::format("assumed: {:g} % of the value, and a noise floor over cos theta_i "
                             "estimated from the values that were clipped to zero",
                             100 * relative_u)}};
  auto& p = table.points;
  for (const Record& record : contents.records) {
    const double phi =
        std::remainder(record.phi_s - record.phi_i - std::numbers::pi, 2 * std::numbers::pi);
    double theta_r_deg = tidy_deg(record.theta_s), phi_r_deg = tidy_deg(phi);
    if (std::abs(phi_r_deg) == 180) {
      theta_r_deg = -theta_r_deg + 0.0;
      phi_r_deg = 0;
    }
    for (std::size_t w = 0; w < contents.wavelengths_nm.size(); ++w) {
      const double value = record.brdf_per_sr[w];
      p.theta_i_deg.push_back(tidy_deg(record.theta_i));
      p.theta_r_deg.push_back(theta_r_deg);
      p.phi_r_deg.push_back(phi_r_deg);
      p.wavelength_nm.push_back(contents.wavelengths_nm[w]);
      p.polarizer_deg.push_back(open_axis);
      p.analyzer_deg.push_back(open_axis);
      p.brdf_per_sr.push_back(value);
      p.brdf_u.push_back(std::hypot(relative_u * value, floor[w] / std::cos(record.theta_i)));
      p.used.push_back(value > 0 ? 1 : 0);
    }
  }
  return table;
}

}  // namespace umov::formats
