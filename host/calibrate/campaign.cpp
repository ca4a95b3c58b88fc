#include "host/calibrate/campaign.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "host/calibrate/reduce.hpp"
#include "host/calibrate/reference_file.hpp"
#include "host/errors/error.hpp"

namespace umov::calibrate {

namespace {

constexpr std::array<const char*, 4> roles = {"white", "mirror", "dark", "sample"};

/// A scan with what every step needs of it.
struct Prepared {
  const CampaignScan* scan;
  ScanRows rows;
  NoiseModel noise;
  Dark own, dark;  ///< measured in the scan itself; completed by the other scans'
};

/// Runs `work`; an error that names no file gets the scan's.
template <class Work>
auto naming(const CampaignScan& scan, Work&& work) {
  try {
    return work();
  } catch (const Error& error) {
    if (!error.place().file.empty()) throw;
    throw Error(Place{scan.file}, error.problem(), error.remedy());
  }
}

std::vector<Prepared> prepare(const std::vector<CampaignScan>& scans) {
  std::vector<Prepared> all;
  for (const CampaignScan& scan : scans)
    all.push_back(naming(scan, [&] {
      Prepared p{&scan, sort_rows(scan.table), fit_noise(scan.table), {}, {}};
      p.own = scan.role == "dark" ? find_dark_of_dark_scan(scan.table, p.noise)
                                  : find_dark(scan.table, p.rows, p.noise);
      return p;
    }));
  std::vector<Dark> darks;
  for (const Prepared& p : all) darks.push_back(p.own);
  const Dark pooled = pool(darks);
  for (Prepared& p : all) p.dark = merge(p.own, pooled);
  return all;
}

/// Dark of all scans of the instrument together.
Dark pooled_dark(const std::vector<Prepared>& all) {
  std::vector<Dark> darks;
  for (const Prepared& p : all) darks.push_back(p.own);
  return pool(darks);
}

std::vector<RangeInput> inputs_of(const std::vector<Prepared>& all) {
  std::vector<RangeInput> inputs;
  for (const Prepared& p : all)
    if (p.scan->role != "dark") inputs.push_back({&p.scan->table, &p.rows, &p.noise, &p.dark});
  return inputs;
}

/// All wavelengths of a campaign must have a gain.
void check_wavelengths(const std::vector<CampaignScan>& scans, const CampaignScan& standard) {
  const auto known = wavelengths_of(standard.table);
  for (const CampaignScan& scan : scans)
    for (double wavelength : wavelengths_of(scan.table))
      if (scan.role != "dark" && std::none_of(known.begin(), known.end(), [wavelength](double k) {
            return std::abs(k - wavelength) < 0.5;
          }))
        throw Error(Place{scan.file},
                    fmt::format("the scan has {:g} nm, at which the standard `{}` was not measured",
                                wavelength, standard.name),
                    "measure the standard at this wavelength too, or leave the scan out");
}

void say_missing(const std::vector<Prepared>& all, const Campaign& campaign,
                 std::vector<std::string>& missing) {
  const Calibration& c = campaign.calibration;
  if (!c.polarization)
    missing.push_back(
        "axes and extinction of polariser and analyser: no scan of role `mirror`; they count as "
        "ideal");
  std::set<double> gains;
  for (const Prepared& p : all)
    for (double gain : p.scan->table.gain) gains.insert(gain);
  std::string dark, ranges;
  for (double gain : gains) {
    if (!c.dark.measured(gain)) dark += fmt::format("{}{:g}", dark.empty() ? "" : ", ", gain);
    if (gain != *gains.begin() && !c.ranges.at(gain).measured)
      ranges += fmt::format("{}{:g}", ranges.empty() ? "" : ", ", gain);
  }
  if (!dark.empty())
    missing.push_back(fmt::format(
        "dark signal of range {}: no record with the shutter closed (block `shutter`, or a scan of "
        "role `dark`)",
        dark));
  if (!ranges.empty())
    missing.push_back(fmt::format(
        "ratio of range {}: no geometry was measured in it and in another one (block `nd`); "
        "nominal, with the tolerance as uncertainty",
        ranges));
  if (!c.nonlinearity.measured)
    missing.push_back(
        "linearity: the comparisons say less than the tolerance does (block `nd` on a strong "
        "signal, repeated, tells more)");
  if (std::none_of(c.stray.measured.begin(), c.stray.measured.end(), [](int m) { return m != 0; }))
    missing.push_back("stray light: no block `no_sample`");
  if (c.reciprocity.empty())
    missing.push_back(
        "reciprocity: the tested scan has no pair of exchanged directions (incidences that are "
        "among the exit angles)");
}

/// How the standard departs from Lambert's law, from its own scan; nullopt where that is tabulated
/// or the scan cannot tell.
std::optional<StandardShape> shape_of_standard(const StandardScan& standard,
                                               const Calibration& calibration) {
  if (standard.reference.tabulated() || !(standard.reference.shape_u() > 0)) return std::nullopt;
  ReduceOptions options;
  options.dolp = options.dhr = options.mueller = false;
  return find_standard_shape(reduce(standard.scan, calibration, options).table,
                             standard.reference.shape_u());
}

/// The scan whose reciprocity is tested.
const CampaignScan* reciprocity_scan(const std::vector<CampaignScan>& scans,
                                     const CampaignOptions& options, std::size_t standard) {
  if (options.reciprocity_scan.empty()) return &scans[standard];
  const CampaignScan* found = nullptr;
  for (const CampaignScan& scan : scans) {
    if (scan.name != options.reciprocity_scan || (scan.role != "white" && scan.role != "sample"))
      continue;
    if (found != nullptr)
      throw Error(Place{options.file, 0, "reciprocity.scan"},
                  fmt::format("{} and {} are both scans of `{}`", found->file, scan.file,
                              options.reciprocity_scan),
                  "give their samples different names");
    found = &scan;
  }
  if (found == nullptr)
    throw Error(Place{options.file, 0, "reciprocity.scan"},
                fmt::format("no white or sample scan is of `{}`", options.reciprocity_scan),
                "name a sample of the campaign, or leave the key out");
  return found;
}

}  // namespace

ReferenceStandard campaign_reference(const CampaignScan& scan, const CampaignOptions& options) {
  return naming(scan, [&] {
    for (const auto& [name, table] : options.reference_brdf)
      if (name == scan.name)
        return ReferenceStandard::from_table(read_reference_table(table), scan.table);
    if (const auto named = scan.table.key("reference_brdf")) {
      const std::filesystem::path file = *named;
      const bool as_it_is = file.is_absolute() || std::filesystem::exists(file);
      return ReferenceStandard::from_table(
          read_reference_table(as_it_is ? file
                                        : std::filesystem::path(scan.file).parent_path() / file),
          scan.table);
    }
    return ReferenceStandard::from_keys(scan.table);
  });
}

std::size_t standard_of(const std::vector<CampaignScan>& scans, const CampaignOptions& options) {
  std::size_t found = scans.size();
  std::string known;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    if (scans[k].role != "white") continue;
    known += (known.empty() ? "" : ", ") + scans[k].name;
    if (!options.standard.empty() && scans[k].name != options.standard) continue;
    if (found < scans.size()) {
      if (options.standard.empty()) continue;
      throw Error(Place{options.file, 0, "standard"},
                  fmt::format("{} and {} are both scans of `{}`", scans[found].file, scans[k].file,
                              options.standard),
                  "leave one of them out, or give their samples different names");
    }
    found = k;
  }
  if (known.empty())
    throw Error(Place{options.file}, "none of the scans is of role `white`",
                "scan a white standard with `role = \"white\"` in the plan and add that file");
  if (found == scans.size())
    throw Error(Place{options.file, 0, "standard"},
                fmt::format("no white scan is of `{}`", options.standard),
                "choose one of: " + known);
  return found;
}

void check_campaign_scans(const std::vector<CampaignScan>& scans, const CampaignOptions& options) {
  const CampaignScan* mirror = nullptr;
  std::string device, device_file;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const CampaignScan& scan = scans[k];
    if (std::find(roles.begin(), roles.end(), scan.role) == roles.end())
      throw Error(Place{scan.file},
                  scan.role.empty() ? "the scan has no key `role`"
                                    : fmt::format("the scan's role is `{}`", scan.role),
                  "set `role` in its plan to white, mirror, dark or sample");
    for (std::size_t l = 0; l < k; ++l)
      if (!scan.sha256.empty() && scans[l].sha256 == scan.sha256)
        throw Error(Place{scan.file}, fmt::format("is the same measurement as {}", scans[l].file),
                    "leave one of them out: it would count twice");
    if (scan.role == "mirror") {
      if (mirror != nullptr)
        throw Error(Place{scan.file},
                    fmt::format("is a second mirror scan beside {}", mirror->file),
                    "keep one of them in a campaign");
      mirror = &scan;
    }
    if (scan.role == "dark") {
      const auto open =
          std::count(scan.table.shutter_open.begin(), scan.table.shutter_open.end(), 1);
      if (open > 0)
        throw Error(
            Place{scan.file},
            fmt::format("is of role `dark`, but {} of its records have the shutter open", open),
            "measure the dark signal with the shutter closed, or correct the role");
    }
    // An emulated instrument's number stands for its sample, too.
    if (const auto named = scan.table.key("device");
        named && named->find("EMU-") == std::string::npos) {
      if (!device.empty() && *named != device)
        throw Error(Place{scan.file},
                    fmt::format("was measured on `{}`, {} on `{}`", *named, device_file, device),
                    "calibrate each instrument with its own scans");
      device = *named;
      device_file = scan.file;
    }
  }
  check_wavelengths(scans, scans[standard_of(scans, options)]);
}

Campaign evaluate_campaign(const std::vector<CampaignScan>& scans, const CampaignOptions& options,
                           const CampaignSteps& steps) {
  const std::size_t standard_number = standard_of(scans, options);
  check_wavelengths(scans, scans[standard_number]);
  const std::vector<Prepared> all = prepare(scans);
  const std::vector<RangeInput> inputs = inputs_of(all);

  Campaign campaign;
  CalibrateOptions settings;
  settings.max_degree = options.max_degree;
  settings.bias = options.bias;
  settings.bias_decided = steps.bias_decided;
  settings.declared = options.declared;
  settings.dark = pooled_dark(all);
  settings.checks = false;
  if (steps.linearity_scans != nullptr) {
    const std::vector<Prepared> others = prepare(*steps.linearity_scans);
    campaign.linearity = find_linearity(inputs_of(others), options.linearity);
  } else {
    campaign.linearity = find_linearity(inputs, options.linearity);
  }
  settings.linearity = campaign.linearity;

  std::vector<StandardScan> standards;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    if (scans[k].role != "white") continue;
    if (k == standard_number) settings.standard = standards.size();
    standards.push_back(
        {scans[k].table, campaign_reference(scans[k], options), scans[k].name, scans[k].sha256});
  }
  const auto calibrate_now = [&] {
    return naming(scans[standard_number], [&] {
      return calibrate(standards, std::span<const formats::ScanTable>{}, settings);
    });
  };

  std::vector<std::string> notes = campaign.linearity.notes;
  if (steps.polarization) {
    settings.polarization = steps.polarization;
  } else {
    for (const Prepared& p : all)
      if (p.scan->role == "mirror") {
        PolarizationOptions polarization = options.polarization;
        polarization.range_tolerance = options.linearity.range_tolerance;
        settings.polarization = naming(*p.scan, [&] {
          return find_polarization(p.scan->table, polarization, p.dark, campaign.linearity.ranges);
        });
        for (const std::string& note : settings.polarization->notes)
          notes.push_back(p.scan->name + ": " + note);
      }
  }

  // Stray light needs the gain, and the standard's signal contains stray light: each round leaves
  // the square of what they share, .3 % at a thousandth of a white tile.
  std::vector<std::string> stray_notes;
  for (int round = 0; round < 3; ++round) {
    const Calibration present = calibrate_now();
    std::vector<StrayGain> gains;
    for (const WavelengthCalibration& w : present.wavelengths)
      gains.push_back({w.wavelength_nm, w.gain_constant_v, w.phase_rad});
    stray_notes.clear();
    settings.stray = find_stray_light(inputs, gains, present.solid_angle_sr,
                                      campaign.linearity.ranges, options.stray, stray_notes);
    if (settings.stray.records == 0) break;
  }
  notes.insert(notes.end(), stray_notes.begin(), stray_notes.end());
  campaign.shape = steps.shape;
  if (!steps.shape && options.shape_from_reciprocity)
    campaign.shape = shape_of_standard(standards[settings.standard], calibrate_now());
  if (campaign.shape) {
    standards[settings.standard].reference.set_shape(campaign.shape->amplitude, campaign.shape->u);
    notes.push_back(fmt::format(
        "{}: by {} reciprocal pairs its BRDF departs from Lambert's law by {:+.3f} +- {:.3f} times "
        "the curve `reference shape`; the instrument function is free of that",
        standards[settings.standard].name, campaign.shape->pairs, campaign.shape->amplitude,
        campaign.shape->u));
  }
  campaign.calibration = calibrate_now();
  Calibration& calibration = campaign.calibration;
  calibration.notes.insert(calibration.notes.end(), notes.begin(), notes.end());

  calibration.inputs.clear();
  for (const CampaignScan& scan : scans)
    calibration.inputs.push_back({scan.name, scan.role, scan.sha256});
  if (steps.checks) {
    calibration.checks = check_standards(standards, settings.standard, calibration);
    const CampaignScan& tested = *reciprocity_scan(scans, options, standard_number);
    ReduceOptions reduce_options;
    reduce_options.dolp = reduce_options.dhr = reduce_options.mueller = false;
    const Reduction reduction =
        naming(tested, [&] { return reduce(tested.table, calibration, reduce_options); });
    calibration.reciprocity = check_reciprocity(reduction.table, options.reciprocity);
    calibration.keys.emplace_back("reciprocity_target",
                                  fmt::format("{:g}", options.reciprocity_target));
  }
  say_missing(all, campaign, campaign.missing);
  for (const std::string& what : campaign.missing)
    calibration.notes.push_back("not calibrated: " + what);
  return campaign;
}

}  // namespace umov::calibrate
