#include "host/gap/scan/substance.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::gap::scan {
namespace {

/// Records with light from the sample.
bool counts(const Record& r) {
  return r.shutter_open && !r.sample_removed && !r.long_pass && !r.saturated;
}

void require_light(const ScanRecords& all) {
  std::size_t open = 0, saturated = 0, usable = 0, positive = 0;
  for (const Record& r : all.records) {
    if (!r.shutter_open || r.sample_removed || r.long_pass) continue;
    ++open;
    saturated += r.saturated ? 1 : 0;
    if (!counts(r)) continue;
    ++usable;
    positive += r.x_v > 0 ? 1 : 0;
  }
  if (open == 0)
    throw Error(
        fmt::format("all {} records were taken without light from the sample: they tell of dark "
                    "signals, not of a simulation's gap",
                    all.records.size()),
        "diagnose them together with the scan of the sample");
  if (saturated * 2 > open)
    throw Error(fmt::format("{} of {} records are saturated: what is left is the measurement's own "
                            "choice of dim angles",
                            saturated, open),
                "measure again with less light or a smaller amplifier range");
  // Noise alone is positive as often as not; light never is.
  constexpr double noise_most = 0.6, noise_least = 0.4;
  const double share = static_cast<double>(positive) / static_cast<double>(usable);
  const bool dark = std::all_of(all.records.begin(), all.records.end(), [](const Record& r) {
    return !counts(r) || (r.x_v == 0 && r.y_v == 0);
  });
  if (dark || (share > noise_least && share < noise_most))
    throw Error(dark ? "the signal is zero in all records: nothing can be diagnosed from it"
                     : "the signal is noise about zero: there is no light in these records",
                "check laser, shutter and lock-in");
}

void require_variety(const ScanRecords& all) {
  const std::size_t n = all.wavelengths_nm.size();
  std::vector<double> least(n, 1e300), most(n, -1e300), least_v = least, most_v = most;
  std::set<double> angles;
  for (const Record& r : all.records) {
    if (!counts(r)) continue;
    angles.insert(r.theta_r);
    const double level = r.x_v / r.monitor_v;
    least[r.wavelength] = std::min(least[r.wavelength], level);
    most[r.wavelength] = std::max(most[r.wavelength], level);
    least_v[r.wavelength] = std::min(least_v[r.wavelength], r.x_v);
    most_v[r.wavelength] = std::max(most_v[r.wavelength], r.x_v);
  }
  if (angles.size() < 5)
    throw Error(fmt::format("{} detector angle{} too few for a diagnosis", angles.size(),
                            angles.size() == 1 ? " is" : "s are"),
                "measure lobes and what lies between them: twenty angles or more");
  const auto constant = [](double from, double to) {
    return from <= to && !(to - from > 1e-6 * std::abs(to));
  };
  for (std::size_t w = 0; w < n; ++w)
    if (constant(least[w], most[w]) || constant(least_v[w], most_v[w]))
      throw Error(fmt::format("the signal at {:g} nm is the same in all records: nothing can be "
                              "diagnosed from it",
                              all.wavelengths_nm[w]),
                  "check that the lock-in was read at each angle");
}

/// Light on the way back to the source over light in the mirror direction, at the steepest
/// incidence where both were measured; nullopt where that is nowhere at `least_theta_i` or steeper.
std::optional<double> retro_over_mirror(const ScanRecords& all, double least_theta_i) {
  struct Mean {
    double sum = 0;
    int count = 0;
    double value() const { return sum / count; }
  };
  std::map<double, std::pair<Mean, Mean>> by_incidence;  // retro, mirror
  for (const Record& r : all.records) {
    if (!counts(r) || r.phi_r != 0 || r.theta_i < least_theta_i) continue;
    const double near = std::min(optics::radians(5.0), 0.5 * r.theta_i);
    const double level = r.x_v / (r.monitor_v * all.gain_constant_v[r.wavelength]);
    auto& [retro, mirror] = by_incidence[r.theta_i];
    for (const auto& [mean, off] : {std::pair<Mean*, double>{&retro, r.theta_r + r.theta_i},
                                    {&mirror, r.theta_r - r.theta_i}}) {
      if (std::abs(off) >= near) continue;
      mean->sum += level;
      ++mean->count;
    }
  }
  for (auto at = by_incidence.rbegin(); at != by_incidence.rend(); ++at) {
    const auto& [retro, mirror] = at->second;
    if (retro.count > 0 && mirror.count > 0)
      return retro.value() / std::max(mirror.value(), 1e-300);
  }
  return std::nullopt;
}

/// The lobe of a surface lies on the mirror side.
void require_mirror_side(ScanRecords& all) {
  // At small incidence both directions lie within one lobe, and less of a ratio says as much.
  constexpr double certain = 2, certain_when_shallow = 1.5, suspicious = 1.3;
  const std::optional<double> steep = retro_over_mirror(all, optics::radians(20.0));
  const double ratio = steep ? *steep : retro_over_mirror(all, optics::radians(5.0)).value_or(1.0);
  if (ratio > (steep ? certain : certain_when_shallow))
    throw Error(fmt::format("the sample is {:.1f} times brighter on the way back to the source "
                            "than in the mirror direction, as if theta_r had the wrong sign",
                            ratio),
                "theta_r_deg is positive on the mirror side of the normal: turn the column's sign");
  if (ratio > suspicious)
    all.notes.push_back(fmt::format(
        "the sample is {:.1f} times brighter on the way back to the source than in the mirror "
        "direction: if it is no retroreflector, theta_r has the wrong sign (positive on the mirror "
        "side of the normal) and no cause below can be trusted",
        ratio));
}

void note_what_is_missing(ScanRecords& all) {
  std::set<double> incidences;
  std::set<std::tuple<bool, double, bool, double>> states;
  for (const Record& r : all.records) {
    if (!counts(r)) continue;
    incidences.insert(r.theta_i);
    states.insert({r.polarizer_open, r.polarizer, r.analyzer_open, r.analyzer});
  }
  if (all.wavelengths_nm.size() == 1)
    all.notes.push_back(
        "one wavelength only: what is told by its spectrum (dust, water, crosstalk, fluorescence) "
        "cannot be told from what is not");
  if (incidences.size() == 1)
    all.notes.push_back(
        "one angle of incidence only: errors of angles, footprints and the shape of the lobe can "
        "stand in for one another");
  if (states.size() == 1)
    all.notes.push_back(
        "one state of polariser and analyser only: leakage, rotation and a polarising detector "
        "cannot be seen");
}

}  // namespace

void require_substance(ScanRecords& all) {
  if (all.wavelengths_nm.size() > most_wavelengths)
    throw Error(fmt::format("{} wavelengths are more than a diagnosis takes at a time",
                            all.wavelengths_nm.size()),
                fmt::format("choose up to {} of them", most_wavelengths));
  require_light(all);
  require_variety(all);
  require_mirror_side(all);
  note_what_is_missing(all);
}

}  // namespace umov::gap::scan
