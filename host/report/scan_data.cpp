// The raw scan in the order of time.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "host/report/json_parts.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {

namespace {

/// More records than this are drawn every second, third … one: the figure shows no more dots
/// anyway.
constexpr std::size_t most_drawn = 9000;

double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string duration(double seconds) {
  if (seconds < 120) return fmt::format("{:.0f} s", seconds);
  if (seconds < 7200) return fmt::format("{:.1f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

struct Series {
  std::vector<double> time_s, signal_v, monitor, gain;
  std::vector<std::int64_t> index;
};

Json ranges_json(const formats::ScanTable& scan) {
  struct Range {
    long long records = 0, saturated = 0;
    double largest = 0;
  };
  std::map<double, Range> ranges;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    Range& range = ranges[scan.gain[i]];
    ++range.records;
    range.saturated += scan.saturated[i] != 0;
    range.largest = std::max(range.largest, std::abs(scan.x_v[i]));
  }
  Json out = Json::array();
  for (const auto& [gain, range] : ranges)
    out.push_back({{"gain", plain(gain)},
                   {"records", count(range.records)},
                   {"largest", plain(range.largest, 3)},
                   {"saturated", count(range.saturated)}});
  return out;
}

std::string summary(const ScanInput& input, std::size_t wavelengths) {
  const formats::ScanTable& scan = input.file.table;
  long long saturated = 0, closed = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    saturated += scan.saturated[i] != 0;
    closed += scan.shutter_open[i] == 0;
  }
  const double seconds = scan.size() == 0 ? 0 : scan.time_s.back() - scan.time_s.front();
  std::string text = fmt::format(
      "{}: {} records at {} wavelength{} in {} of instrument time; {} saturated, {} with the "
      "shutter closed.",
      input.source.name, count(static_cast<long long>(scan.size())), wavelengths,
      wavelengths == 1 ? "" : "s", duration(seconds), count(saturated), count(closed));
  if (!scan.blocks.empty()) {
    text += " Set-up blocks: ";
    for (std::size_t b = 0; b < scan.blocks.size(); ++b) {
      const auto& block = scan.blocks[b];
      text += fmt::format("{}{} (records {} to {})", b == 0 ? "" : ", ", block.name, block.first,
                          block.last);
    }
    text += ".";
  }
  return text;
}

}  // namespace

Json scan_data(const ScanInput& input) {
  const formats::ScanTable& scan = input.file.table;
  std::map<double, Series> series;
  std::map<double, std::vector<double>> monitors;
  for (std::size_t i = 0; i < scan.size(); ++i)
    monitors[scan.wavelength_nm[i]].push_back(scan.monitor_v[i]);
  std::map<double, double> usual;
  for (auto& [nm, values] : monitors) usual[nm] = median(std::move(values));
  const std::size_t stride = std::max<std::size_t>(1, (scan.size() + most_drawn - 1) / most_drawn);
  Json saturated_time = Json::array(), saturated_signal = Json::array();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (scan.saturated[i] != 0) {
      saturated_time.push_back(rounded(scan.time_s[i], 7));
      saturated_signal.push_back(rounded(std::abs(scan.x_v[i])));
    }
    if (i % stride != 0) continue;
    Series& s = series[scan.wavelength_nm[i]];
    s.time_s.push_back(scan.time_s[i]);
    s.signal_v.push_back(std::abs(scan.x_v[i]));
    s.monitor.push_back(scan.monitor_v[i] / usual[scan.wavelength_nm[i]]);
    s.gain.push_back(scan.gain[i]);
    s.index.push_back(scan.index[i]);
  }
  Json list = Json::array();
  for (const auto& [nm, s] : series)
    list.push_back({{"wavelength_nm", rounded(nm, 6)},
                    {"time_s", rounded(s.time_s, 7)},
                    {"signal_v", rounded(s.signal_v, 4)},
                    {"monitor", rounded(s.monitor, 6)},
                    {"gain", rounded(s.gain)},
                    {"index", s.index}});
  return {{"name", input.source.name},
          {"summary", summary(input, series.size())},
          {"records", scan.size()},
          {"thinned", stride > 1 ? fmt::format(" (one in {} drawn)", stride) : std::string()},
          {"series", std::move(list)},
          {"saturated",
           {{"time_s", std::move(saturated_time)}, {"signal_v", std::move(saturated_signal)}}},
          {"ranges", ranges_json(scan)}};
}

}  // namespace umov::report
