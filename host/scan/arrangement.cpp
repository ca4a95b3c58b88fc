#include "host/scan/arrangement.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "host/errors/error.hpp"

namespace umov::scan {
namespace {

/// Settings that change the set-up, in the order in which it is best done.
constexpr std::array<std::string_view, 6> manual_settings = {
    "sample", "sample_removed", "sample_azimuth_deg", "iris_fraction", "filter", "retarder_deg"};

bool is_manual(std::string_view key) {
  return key != "optical_density";  // the filter wheel does it
}

/// How a setting comes about; `value` null: how it is taken back.
std::string sentence(std::string_view key, const std::string* value) {
  if (key == "sample")
    return value ? fmt::format("Put {} in the place of the sample.", *value)
                 : "Put the sample back in its place.";
  if (key == "sample_removed")
    return value ? "Take the sample away and leave the stage empty."
                 : "Put the sample back in its place.";
  if (key == "sample_azimuth_deg")
    return value ? fmt::format("Turn the sample to {} deg about its normal.", *value)
                 : "Turn the sample back to 0 deg about its normal.";
  if (key == "iris_fraction")
    return value ? fmt::format("Set the detector's iris to {} of its usual diameter.", *value)
                 : "Open the detector's iris to its usual diameter.";
  if (key == "filter" && (!value || *value == "long_pass"))
    return value ? "Put the long-pass filter before the detector."
                 : "Take the filter before the detector out.";
  return value ? fmt::format("Set {} to {}.", key, *value)
               : fmt::format("Take {} back to what it was.", key);
}

}  // namespace

const std::string* Arrangement::find(std::string_view key) const {
  for (const auto& [name, value] : settings)
    if (name == key) return &value;
  return nullptr;
}

std::string Arrangement::text() const {
  if (plain()) return "plain";
  std::string result;
  for (const auto& [key, value] : settings)
    result += fmt::format("{}{}={}", result.empty() ? "" : " ", key, value);
  return result;
}

Arrangement arrangement_of(const formats::Block& block) {
  Arrangement result;
  for (const auto& setting : block.settings)
    if (is_manual(setting.first)) result.settings.push_back(setting);
  return result;
}

std::vector<Stretch> stretches(const Program& program, const Arrangement& standing) {
  std::vector<Stretch> result;
  for (const formats::Block& block : program.blocks) {
    const std::string name = standing.find("sample") != nullptr ? "white_tile" : block.name;
    Arrangement arrangement = standing;
    for (auto& setting : arrangement_of(block).settings)
      if (arrangement.find(setting.first) == nullptr)
        arrangement.settings.push_back(std::move(setting));
    const auto first = static_cast<std::uint32_t>(block.first);
    const auto end = static_cast<std::uint32_t>(block.last + 1);
    if (!result.empty() && result.back().arrangement == arrangement) {
      result.back().end = end;
      result.back().blocks += ", " + name;
    } else {
      result.push_back({first, end, name, std::move(arrangement)});
    }
  }
  return result;
}

void require_plain(const std::vector<Stretch>& all, const std::string& plan) {
  for (const Stretch& stretch : all) {
    if (stretch.arrangement.plain()) continue;
    const std::string block = stretch.blocks.substr(0, stretch.blocks.find(','));
    throw Error({plan},
                fmt::format("block {} needs a change at the instrument ({}) that the controller "
                            "can't make",
                            block, stretch.arrangement.text()),
                fmt::format("be there to make it (--arrange ask), or measure the blocks one by "
                            "one: --block main, then --block {} --arrange made after the change",
                            block));
  }
}

std::vector<std::string> instructions(const ArrangementRequest& request) {
  std::vector<std::string> result;
  const auto add = [&](std::string_view key) {
    const std::string* wanted = request.wanted.find(key);
    const std::string* present = request.present ? request.present->find(key) : nullptr;
    if (wanted == nullptr && present == nullptr) return;
    if (wanted != nullptr && present != nullptr && *wanted == *present) return;
    std::string text = sentence(key, wanted);
    if (std::find(result.begin(), result.end(), text) == result.end())
      result.push_back(std::move(text));
  };
  for (const auto key : manual_settings) add(key);
  const auto add_others = [&](const Arrangement& arrangement) {
    for (const auto& [key, value] : arrangement.settings)
      if (std::find(manual_settings.begin(), manual_settings.end(), key) == manual_settings.end())
        add(key);
  };
  add_others(request.wanted);
  if (request.present) add_others(*request.present);
  if (!request.present) {
    result.push_back(fmt::format(
        "Make sure that {} is as usual: the sample in its place and not turned, the iris open, no "
        "filter before the detector.",
        result.empty() ? "everything" : "all else"));
  }
  return result;
}

}  // namespace umov::scan
