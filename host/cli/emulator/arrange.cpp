// What a person at the emulated instrument changes between parts of a scan.
#include <charconv>
#include <cmath>

#include "hil/plant/sample_catalog.hpp"
#include "host/cli/emulator/emulated_instrument.hpp"
#include "host/errors/error.hpp"

namespace umov::emulator {
namespace {

constexpr const char* known_settings =
    "use sample_azimuth_deg=180, iris_fraction=0.5, sample_removed=1, filter=long_pass or "
    "sample=NAME";

double number(const std::string& key, const std::string& text, double lowest, double highest) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, value);
  if (code != std::errc() || stop != end || !(value >= lowest && value <= highest))
    throw Error("the emulated instrument can't be arranged with " + key + "=" + text,
                known_settings);
  return value;
}

}  // namespace

void EmulatedInstrument::arrange(const std::vector<std::pair<std::string, std::string>>& settings) {
  plant::Setup setup;
  std::shared_ptr<const plant::Sample> sample = own_sample_;
  for (const auto& [key, value] : settings) {
    if (key == "sample_azimuth_deg") {
      setup.sample_azimuth_deg = number(key, value, -360, 360);
    } else if (key == "iris_fraction") {
      setup.iris_fraction = number(key, value, 1e-3, 1);
    } else if (key == "sample_removed") {
      setup.sample_removed = number(key, value, 0, 1) != 0;
    } else if (key == "filter" && value == "long_pass") {
      setup.long_pass = true;
    } else if (key == "sample") {
      sample = plant::make_sample(value);
    } else {
      throw Error("the emulated instrument can't be arranged with " + key + "=" + value,
                  known_settings);
    }
  }
  plant_->place_sample(std::move(sample));
  plant_->arrange(setup);
}

}  // namespace umov::emulator
