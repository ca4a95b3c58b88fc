#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/text_lines.hpp"
#include "host/formats/zemax_bsdf.hpp"

namespace umov::formats {
namespace {

constexpr const char* layout_remedy =
    "the order is Source, Symmetry, SpectralContent, ScatterType, SampleRotation, "
    "AngleOfIncidence, ScatterAzimuth, ScatterRadial, then the data";
constexpr std::string_view wavelength_comment = "wavelength:";

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

bool same_word(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
    return lower(x) == lower(y);
  });
}

/// Words of a text, over line ends, without the lines that start with '#'.
class Words {
 public:
  Words(std::string_view text, std::string name) : lines_(text), name_(std::move(name)) {}

  /// Next word; empty at the end of the text.
  std::string_view next() {
    while (true) {
      const auto start = std::find_if_not(rest_.begin(), rest_.end(), is_space);
      rest_.remove_prefix(static_cast<std::size_t>(start - rest_.begin()));
      if (!rest_.empty() && !(line_start_ && rest_.front() == '#')) break;
      if (!rest_.empty()) note(rest_.substr(1));
      if (!lines_.next(rest_)) return rest_ = {};
      line_start_ = true;
    }
    line_start_ = false;
    const auto end = std::find_if(rest_.begin(), rest_.end(), is_space);
    const std::string_view word = rest_.substr(0, static_cast<std::size_t>(end - rest_.begin()));
    rest_.remove_prefix(word.size());
    return word;
  }

  void expect(std::string_view keyword) {
    const std::string_view word = next();
    if (!same_word(word, keyword))
      fail(fmt::format("{} stands where {} is due", shown(word), keyword));
  }

  double number(const char* what) {
    const std::string_view word = next();
    double value = 0.0;
    if (word.empty()) fail(fmt::format("the file ends where {} is due", what));
    if (const char* problem = read_decimal(word, value))
      fail(fmt::format("{} where {} is due {}", shown(word), what, problem));
    return value;
  }

  [[noreturn]] void fail(const std::string& problem, const char* remedy = layout_remedy) const {
    throw Error(Place{name_, lines_.line_number()}, problem, remedy);
  }

  /// No more than this many words can follow.
  std::size_t most_words_left() const { return (lines_.bytes_left() + rest_.size() + 1) / 2; }
  std::optional<double> wavelength_um() const { return wavelength_um_; }

 private:
  static std::string shown(std::string_view word) {
    return word.empty() ? "the end of the file" : fmt::format("'{}'", word.substr(0, 40));
  }

  void note(std::string_view comment) {
    comment = trimmed(comment);
    if (!comment.starts_with(wavelength_comment)) return;
    comment = trimmed(comment.substr(wavelength_comment.size()));
    double nm = 0.0;
    const std::string_view text = comment.substr(0, comment.find(' '));
    if (read_decimal(text, nm) == nullptr && nm >= 10.0 && nm <= 1e6) wavelength_um_ = nm * 1e-3;
  }

  LineReader lines_;
  std::string name_;
  std::string_view rest_;
  bool line_start_ = false;
  std::optional<double> wavelength_um_;
};

std::size_t count_after(Words& words, const char* keyword) {
  words.expect(keyword);
  const double count = words.number("a number of angles");
  if (!(count >= 1.0) || count != std::floor(count))
    words.fail(fmt::format("{} {} is no number of angles", keyword, count));
  if (count > static_cast<double>(words.most_words_left()))
    words.fail(fmt::format("{} claims {} angles, more than the file has room for", keyword, count));
  return static_cast<std::size_t>(count);
}

std::vector<double> angles_after(Words& words, const char* keyword, double most) {
  const std::size_t count = count_after(words, keyword);
  std::vector<double> angles;
  angles.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = words.number("an angle");
    if (!(angle >= 0.0 && angle <= most))
      words.fail(fmt::format("{} {} is out of range", keyword, angle),
                 fmt::format("angles lie within 0 to {} degrees", most).c_str());
    if (i > 0 && !(angle > angles.back()))
      words.fail(fmt::format("{} {} does not rise above {}", keyword, angle, angles.back()),
                 "sort the angles and give each once");
    angles.push_back(angle);
  }
  return angles;
}

}  // namespace

bool looks_like_zemax(std::string_view bytes) {
  LineReader lines(bytes.substr(0, 65536));
  std::string_view line;
  while (lines.next(line)) {
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    const std::string_view word = line.substr(0, line.find_first_of(" \t"));
    return same_word(word, "Source") || same_word(word, "Symmetry");
  }
  return false;
}

TablePtr read_zemax(std::string_view bytes, const std::string& name) {
  Words words(bytes, name);
  words.expect("Source");
  words.next();  // always "Measured"
  words.expect("Symmetry");
  const std::string_view symmetry = words.next();
  SpecularAxes axes;
  axes.symmetric = same_word(symmetry, "PlaneSymmetrical");
  if (!axes.symmetric && !same_word(symmetry, "ASymmetrical") &&
      !same_word(symmetry, "ASymmetrical4D"))
    words.fail(fmt::format("there is no symmetry '{}'", symmetry.substr(0, 40)),
               "write PlaneSymmetrical, ASymmetrical or ASymmetrical4D");
  words.expect("SpectralContent");
  const std::string_view content = words.next();
  const bool tristimulus = same_word(content, "XYZ");
  if (!tristimulus && !same_word(content, "Monochrome"))
    words.fail(fmt::format("there is no spectral content '{}'", content.substr(0, 40)),
               "write Monochrome or XYZ");
  words.expect("ScatterType");
  if (const std::string_view type = words.next(); !same_word(type, "BRDF"))
    words.fail(same_word(type, "BTDF")
                   ? "holds transmission"
                   : fmt::format("there is no scatter type '{}'", type.substr(0, 40)),
               "only BRDF files can be imported");
  if (const std::size_t rotations = count_after(words, "SampleRotation"); rotations != 1)
    words.fail(fmt::format("holds {} sample rotations: the surface is anisotropic", rotations),
               "write a file with one rotation; tables here are isotropic");
  words.number("a sample rotation");
  axes.theta_i_deg = angles_after(words, "AngleOfIncidence", std::nextafter(90.0, 0.0));
  // The azimuth of a plane-symmetrical file ends at 180: beyond it stands the mirror image.
  axes.azimuth_deg = angles_after(words, "ScatterAzimuth", axes.symmetric ? 180.0 : 360.0);
  axes.radial_deg = angles_after(words, "ScatterRadial", 180.0);

  const std::size_t channels = tristimulus ? 3 : 1;
  const std::size_t slice = axes.azimuth_deg.size() * axes.radial_deg.size();
  const std::size_t incidences = axes.theta_i_deg.size();
  // Each axis is shorter than the file, so that the products stay far below the range of size_t.
  const std::size_t most = words.most_words_left();
  if (slice > most || slice * incidences > most || slice * incidences * channels > most)
    words.fail(
        fmt::format("claims {} values, more than the file has room for",
                    static_cast<double>(slice) * static_cast<double>(incidences * channels)));
  std::array<std::vector<double>, 3> values, tis;
  for (std::size_t channel = 0; channel < channels; ++channel) {
    constexpr std::array<const char*, 3> names = {"TristimulusX", "TristimulusY", "TristimulusZ"};
    words.expect(tristimulus ? names[channel] : "Monochrome");
    words.expect("DataBegin");
    values[channel].reserve(slice * incidences);
    for (std::size_t i = 0; i < incidences; ++i) {
      words.expect("TIS");
      const double total = words.number("a total integrated scatter");
      if (!(total >= 0.0)) words.fail(fmt::format("TIS {} is negative", total), "TIS is 0 or more");
      tis[channel].push_back(total);
      for (std::size_t k = 0; k < slice; ++k) {
        const double value = words.number("a BRDF value");
        if (!(value >= 0.0))
          words.fail(fmt::format("BRDF {} is negative", value), "a BRDF is 0 or more");
        values[channel].push_back(value);
      }
    }
    words.expect("DataEnd");
  }
  if (const std::string_view word = words.next(); !word.empty())
    words.fail(fmt::format("'{}' follows the last value", word.substr(0, 40)),
               "the file ends with DataEnd");
  std::vector<double> wavelengths = {words.wavelength_um().value_or(zemax_unnamed_um)};
  if (tristimulus) {
    wavelengths.assign(std::begin(zemax_tristimulus_um), std::end(zemax_tristimulus_um));
    std::swap(values[0], values[2]);  // ascending wavelengths: Z, Y, X
    std::swap(tis[0], tis[2]);
  }
  for (std::size_t channel = 1; channel < channels; ++channel) {
    values[0].insert(values[0].end(), values[channel].begin(), values[channel].end());
    tis[0].insert(tis[0].end(), tis[channel].begin(), tis[channel].end());
  }
  return std::make_shared<SpecularTable>(std::move(axes), std::move(wavelengths),
                                         std::move(values[0]), std::move(tis[0]), name);
}

}  // namespace umov::formats
