#include "host/gap/scan/record.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "host/calibrate/calibration.hpp"
#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/gap/scan/knowledge.hpp"
#include "host/optics/angles.hpp"

namespace umov::gap::scan {
namespace {

struct Arrangement {
  bool flipped = false, removed = false, long_pass = false, usable = true;
  double iris_fraction = 1;
};

Arrangement arrangement_of(const formats::Block& block, std::vector<std::string>& notes) {
  Arrangement a;
  for (const auto& [key, value] : block.settings) {
    double number = 0;
    const bool numeric = formats::read_decimal(value, number) == nullptr;
    if (key == "sample_azimuth_deg" && numeric && (number == 0 || number == 180)) {
      a.flipped = number == 180;
    } else if (key == "sample_removed") {
      a.removed = value == "1";
    } else if (key == "filter" && value == "long_pass") {
      a.long_pass = true;
    } else if (key == "iris_fraction" && numeric && number > 0) {
      a.iris_fraction = number;
    } else if (key == "sample" || key == "retarder_deg" || key == "sample_azimuth_deg") {
      a.usable = false;
    }
  }
  if (!a.usable)
    notes.push_back(
        fmt::format("block {} is not used: its set-up is not in the simulation", block.name));
  return a;
}

std::size_t index_of_wavelength(const std::vector<double>& all, double nm) {
  for (std::size_t i = 0; i < all.size(); ++i)
    if (std::abs(all[i] - nm) < 0.5) return i;
  return all.size();
}

void append(const formats::ScanTable& scan, ScanRecords& out) {
  const std::size_t n = scan.size();
  if (n == 0) throw Error("a scan without records", "measure, or name another file");
  std::vector<Arrangement> arrangement(scan.blocks.size());
  for (std::size_t b = 0; b < scan.blocks.size(); ++b)
    arrangement[b] = arrangement_of(scan.blocks[b], out.notes);
  const double first = *std::min_element(scan.time_s.begin(), scan.time_s.end());
  const double last = *std::max_element(scan.time_s.begin(), scan.time_s.end());
  const double duration = std::max(last - first, 1e-9);

  int row = out.records.empty() ? 0 : out.records.back().row + 1;
  const Record* before = nullptr;
  for (std::size_t i = 0; i < n; ++i) {
    Arrangement a;
    for (std::size_t b = 0; b < scan.blocks.size(); ++b)
      if (scan.index[i] >= scan.blocks[b].first && scan.index[i] <= scan.blocks[b].last)
        a = arrangement[b];
    if (!a.usable) continue;
    Record r{};
    r.theta_i = optics::radians(scan.theta_i_deg[i]);
    r.theta_r = optics::radians(scan.theta_r_deg[i]);
    r.phi_r = optics::radians(scan.phi_r_deg[i]);
    r.wavelength = index_of_wavelength(out.wavelengths_nm, scan.wavelength_nm[i]);
    // Longer wavelengths pass the filter, with a transmittance that nobody states.
    if (a.long_pass && r.wavelength > 0) continue;
    r.polarizer_open = formats::is_open(scan.polarizer_deg[i]);
    r.analyzer_open = formats::is_open(scan.analyzer_deg[i]);
    r.polarizer = r.polarizer_open ? 0 : optics::radians(scan.polarizer_deg[i]);
    r.analyzer = r.analyzer_open ? 0 : optics::radians(scan.analyzer_deg[i]);
    r.direction = scan.direction[i];
    r.gain = scan.gain[i];
    r.monitor_v = scan.monitor_v[i];
    r.time = (scan.time_s[i] - first) / duration;
    r.time_s = scan.time_s[i] - first;
    r.shutter_open = scan.shutter_open[i] != 0;
    r.saturated = scan.saturated[i] != 0;
    r.sample_flipped = a.flipped;
    r.sample_removed = a.removed;
    r.long_pass = a.long_pass;
    r.iris_fraction = a.iris_fraction;
    r.x_v = scan.x_v[i];
    r.y_v = scan.y_v[i];
    if (before != nullptr) {
      const bool same =
          before->theta_i == r.theta_i && before->phi_r == r.phi_r &&
          before->wavelength == r.wavelength && before->polarizer_open == r.polarizer_open &&
          before->analyzer_open == r.analyzer_open && before->polarizer == r.polarizer &&
          before->analyzer == r.analyzer && before->shutter_open == r.shutter_open;
      if (!same) ++row;
    }
    r.row = row;
    out.records.push_back(r);
    before = &out.records.back();
  }
}

}  // namespace

ScanRecords prepare_records(const std::vector<formats::ScanTable>& scans,
                            const calibrate::Calibration* calibration) {
  if (scans.empty()) throw Error("no scan is given", "name a scan.h5 or a Scan CSV");
  ScanRecords out;
  out.wavelengths_nm = calibrate::wavelengths_of(scans.front());
  const formats::ScanTable& head = scans.front();
  out.solid_angle_sr = head.number("solid_angle_sr")
                           .value_or(calibration == nullptr ? 0.0 : calibration->solid_angle_sr);
  if (!(out.solid_angle_sr > 0))
    throw Error("the scan does not state its aperture", "add the key `# solid_angle_sr: …`");
  for (const double nm : out.wavelengths_nm) {
    const std::string key = fmt::format("gain_constant_{:g}", nm);
    const auto constant = calibration == nullptr
                              ? head.number(key)
                              : std::optional(calibration->at(nm).gain_constant_v);
    if (!constant || !(*constant > 0))
      throw Error(
          fmt::format("the scan does not state the instrument's gain at {:g} nm", nm),
          fmt::format("add the key `# {}: …` (volts), or name a calibration (--calibration)", key));
    out.gain_constant_v.push_back(*constant);
  }
  out.gain_constant_relative_u.assign(out.wavelengths_nm.size(),
                                      head.number("gain_constant_relative_u").value_or(0.01));
  out.adc_full_scale_v = head.number("adc_full_scale_v").value_or(0);
  const auto sample = [](const formats::ScanTable& scan) {
    return scan.key("sample").value_or("");
  };
  for (const formats::ScanTable& scan : scans) {
    if (sample(scan) != sample(head) && !sample(scan).empty() && !sample(head).empty())
      throw Error(fmt::format("the scans are of different samples: \"{}\" and \"{}\"", sample(head),
                              sample(scan)),
                  "diagnose each by itself; only scans of one sample go together");
    for (const double nm : calibrate::wavelengths_of(scan))
      if (index_of_wavelength(out.wavelengths_nm, nm) == out.wavelengths_nm.size())
        throw Error(fmt::format("a further scan has {:g} nm, which the first has not", nm),
                    "diagnose scans of the same instrument and sample together");
    std::size_t total = 0;
    for (const formats::ScanTable& s : scans) total += s.size();
    out.records.reserve(total);
    append(scan, out);
  }
  if (calibration != nullptr) correct_records(*calibration, out);
  return out;
}

std::array<long long, 8> place_of(const Record& r) {
  const auto exact = [](double number) { return std::llround(number * 1e6); };
  const int arrangement = (r.polarizer_open ? 1 : 0) + (r.analyzer_open ? 2 : 0) +
                          (r.sample_flipped ? 4 : 0) + (r.long_pass ? 8 : 0) +
                          (r.sample_removed ? 16 : 0) + (r.shutter_open ? 0 : 32);
  return {
      exact(r.theta_i),   exact(r.theta_r),  exact(r.phi_r), static_cast<long long>(r.wavelength),
      exact(r.polarizer), exact(r.analyzer), arrangement,    exact(r.iris_fraction)};
}

void thin(ScanRecords& records, std::size_t most) {
  const std::size_t all = records.records.size();
  if (most == 0 || all <= most) return;
  const std::size_t every = (all + most - 1) / most;
  std::vector<Record> kept;
  std::size_t place = 0;
  int row = -1;
  constexpr int often = 3;
  std::map<std::array<long long, 8>, int> times;
  for (const Record& r : records.records) ++times[place_of(r)];
  std::map<std::array<long long, 8>, bool> keep;
  for (const Record& r : records.records) {
    place = r.row == row ? place + 1 : 0;
    row = r.row;
    const auto where = place_of(r);
    // Rows begin at different places, so that together they see every angle.
    const bool due = (place + static_cast<std::size_t>(row)) % every == 0;
    const bool lit = r.shutter_open && !r.sample_removed;
    if (lit ? keep.try_emplace(where, due || times[where] >= often).first->second : due)
      kept.push_back(r);
  }
  records.records = std::move(kept);
  records.notes.push_back(
      fmt::format("thinned to {} of {} records for a quick answer: small effects may be missed",
                  records.records.size(), all));
}

}  // namespace umov::gap::scan
