#include "host/gap/answer/words.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace umov::gap {
namespace {

/// The effect with what cannot be told from it.
std::string with_rivals(const std::string& effect, const Diagnosis& d) {
  for (const auto& set : d.ambiguity_sets) {
    if (std::find(set.begin(), set.end(), effect) == set.end()) continue;
    std::vector<std::string> names;
    for (const std::string& member : set) names.push_back(plain_name(member));
    return fmt::format("one of {}", fmt::join(names, ", "));
  }
  return plain_name(effect);
}

/// "a, b and c".
std::string listed(const std::vector<std::string>& names) {
  if (names.size() < 2) return names.empty() ? "" : names[0];
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

/// Whole per cent, but never all of it where something is left.
std::string in_percent(double fraction, bool all) {
  const double percent = 100 * std::clamp(fraction, 0.0, 1.0);
  if (all || percent < 99.5) return fmt::format("{:.0f}", percent);
  return fmt::format("{:.1f}", std::min(percent, 99.9));
}

constexpr std::array<std::pair<const char*, const char*>, 7> circumstance_words{{
    {"polarizer_deg", "the polariser's setting"},
    {"analyzer_deg", "the analyser's setting"},
    {"gain", "the amplifier's range"},
    {"wavelength_nm", "the wavelength"},
    {"direction", "the direction of travel"},
    {"theta_i_deg", "θi"},
    {"theta_r_deg", "θr"},
}};

constexpr std::array<std::pair<const char*, const char*>, 12> menu_words{{
    {"reverse", "the same scan with the detector moving the other way"},
    {"serpentine", "the same scan with every second row in the other direction"},
    {"flip", "the same scan with the sample turned by 180° about its normal"},
    {"pm45", "polariser and analyser at ±45° as well"},
    {"shutter", "a few records with the shutter closed"},
    {"nd", "the same scan at a tenth and at a hundredth of the power (neutral-density filters)"},
    {"iris", "the same scan with the detector's aperture at half its diameter"},
    {"oop", "directions out of the plane of incidence"},
    {"white_tile", "a white tile in the sample's place"},
    {"repeat", "reference points measured again"},
    {"long_pass", "a long-pass filter before the detector: only fluorescence passes it"},
    {"no_sample", "the same scan with the sample taken away"},
}};

/// A sentence on what is left where it varies with a circumstance; empty where nothing does.
std::string variation_in_words(const Diagnosis& d) {
  if (!varies(d)) return "";
  const Variation& v = d.variation;
  std::string with = v.with;
  for (const auto& [name, words] : circumstance_words)
    if (with == name) with = words;
  const std::string unit = v.unit == "1" ? "" : v.unit == "deg" ? "°" : " " + v.unit;
  std::string how;
  switch (v.kind) {
    case Variation::Kind::level:
      how = fmt::format("changes with {}: at {} it is another than elsewhere", with,
                        v.at_name.empty() ? fmt::format("{:.4g}{}", v.at, unit) : v.at_name);
      break;
    case Variation::Kind::trend:
      how = fmt::format("changes steadily with {}", with);
      break;
    case Variation::Kind::step:
      how = fmt::format("steps at {} = {:.4g}{}", with, v.at, unit);
      break;
    case Variation::Kind::swing:
      how = fmt::format("swings with {}, with a period of {:.3g}{}", with, v.at, unit);
      break;
    case Variation::Kind::wander:
      how = fmt::format("wanders in the course of the scan by {:.2g} %", 100 * v.at);
      break;
  }
  const std::string name = plain_name(v.what);
  const bool vowel = std::string_view("aeiou").find(name.front()) != std::string_view::npos;
  return fmt::format(" What is left looks like {} {} that {}.", vowel ? "an" : "a", name, how);
}

}  // namespace

std::string plain_name(const std::string& effect) {
  if (effect == "sample_model") return "richer reflectance model";
  std::string name = effect;
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::vector<std::string> separations_in_words(const FurtherScan& scan) {
  std::vector<std::string> all;
  for (const std::vector<std::string>& pair : scan.separates) {
    std::vector<std::string> names;
    for (const std::string& name : pair) names.push_back(plain_name(name));
    std::string words = fmt::format("{}", fmt::join(names, " from "));
    if (std::find(all.begin(), all.end(), words) == all.end()) all.push_back(std::move(words));
  }
  return all;
}

bool is_series(std::size_t parameters) {
  constexpr std::size_t many = 8;
  return parameters > many;
}

std::string menu_in_words(const std::string& menu) {
  for (const auto& [name, words] : menu_words)
    if (menu == name) return words;
  return menu;
}

std::string verdict_sentence(const Diagnosis& d) {
  switch (d.verdict) {
    case Verdict::none_needed:
      return "The simulation agrees with the measurement within its noise: no effect is needed.";
    case Verdict::unexplained:
      return fmt::format(
          "The simulation misses the measurement by {:.2g} % of the signal, and no effect in the "
          "catalogue explains it.{}",
          d.before.percent, variation_in_words(d));
    default:
      break;
  }
  std::vector<std::string> names;
  for (const Cause& c : d.causes) {
    const std::string name = with_rivals(c.effect, d);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  const bool all = d.verdict == Verdict::explained;
  std::string sentence =
      fmt::format("{} {} {} % of the gap ({} to {} %); {} significant is left.", listed(names),
                  names.size() > 1 ? "together close" : "closes",
                  in_percent(d.closed_fraction.value, all), in_percent(d.closed_fraction.lo, all),
                  in_percent(d.closed_fraction.hi, all), all ? "nothing" : "something");
  if (sentence[0] >= 'a' && sentence[0] <= 'z')
    sentence[0] = static_cast<char>(sentence[0] - 'a' + 'A');
  return sentence + variation_in_words(d);
}

}  // namespace umov::gap
