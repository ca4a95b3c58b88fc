#include "host/calibrate/reduce.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/calibrate/aperture.hpp"
#include "host/calibrate/dhr.hpp"
#include "host/calibrate/dolp.hpp"
#include "host/calibrate/ideal_states.hpp"
#include "host/calibrate/point_factors.hpp"
#include "host/errors/error.hpp"
#include "host/formats/order_statistics.hpp"
#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

constexpr double degree = optics::radians(1.0);
/// Relative difference of solid angles that comes from printing them.
constexpr double same_solid_angle = 1e-6;

/// Dark of the scan itself where it has shutter-closed rows, else the calibration's. Where neither
/// was measured, the scan's own estimate of the uncertainty stands.
struct DarkChoice {
  DarkLevel level;
  bool own = false;
};

DarkChoice choose_dark(const Dark& own, const Dark& calibration, double gain) {
  if (own.measured(gain)) return {own.at(gain), true};
  if (calibration.measured(gain)) return {calibration.at(gain), false};
  for (const DarkLevel& level : calibration.levels)
    if (level.gain == gain) return {level, false};
  return {own.at(gain), true};
}

/// Geometry, wavelength and incident state in steps finer than any drive's.
using Key = std::array<long long, 5>;

Key key_of(const formats::ScanTable& scan, std::size_t i) {
  const auto rounded = [](double v) {
    return std::isnan(v) ? -999999999LL : std::llround(v * 1e4);
  };
  return {rounded(scan.theta_i_deg[i]), rounded(scan.theta_r_deg[i]), rounded(scan.phi_r_deg[i]),
          rounded(scan.wavelength_nm[i]), rounded(scan.polarizer_deg[i])};
}

struct Analysed {
  double s = 0, p = 0;
};

bool is_axis(double axis_deg, double wanted_deg) {
  return !formats::is_open(axis_deg) &&
         std::abs(std::remainder(axis_deg - wanted_deg, 180.0)) < 0.01;
}

/// Signals behind P and S analyser by geometry. Their Q/I is the lever of a record with the
/// analyser open; where they are missing the response of the bare detector is not known better than
/// δ.
std::map<Key, Analysed> analysed_signals(const formats::ScanTable& scan, const ScanRows& set_up,
                                         const Calibration& calibration) {
  std::map<Key, Analysed> result;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (set_up.row[i] != RowUse::plain || scan.saturated[i] != 0 || !(scan.monitor_v[i] > 0))
      continue;
    const WavelengthCalibration& entry = calibration.at(scan.wavelength_nm[i]);
    const double bias = entry.bias_active ? entry.detector_bias : 0.0;
    if (is_axis(scan.analyzer_deg[i], 90))
      result[key_of(scan, i)].s = scan.x_v[i] / scan.monitor_v[i] / (1 + bias);
    if (is_axis(scan.analyzer_deg[i], 0))
      result[key_of(scan, i)].p = scan.x_v[i] / scan.monitor_v[i] / (1 - bias);
  }
  return result;
}

void check_scan(const formats::ScanTable& scan, const Calibration& calibration) {
  if (scan.size() == 0)
    throw Error("the scan has no records", "give a scan with at least one record");
  if (calibration.wavelengths.empty())
    throw Error("the calibration is empty", "make it with `umov calibrate`");
  for (double wavelength : wavelengths_of(scan)) calibration.at(wavelength);
  if (const auto role = scan.key("role"); role && (*role == "dark" || *role == "mirror"))
    throw Error(fmt::format("a scan of role `{}` has no BRDF", *role),
                "reduce scans of role `sample` or `white`");
}

/// The standard's records, too, were taken at other angles than commanded; what that did to gain
/// and instrument function goes with the alignment.
class AlignedStandard {
 public:
  AlignedStandard(const Calibration& calibration, const Alignment& alignment)
      : calibration_(calibration) {
    const DeclaredDoubts& declared = calibration.declared;
    for (const Systematic& s : calibration.systematics) {
      if (s.kind == Systematic::Kind::detector_zero && alignment.theta_r_zero_deg != 0)
        parts_.push_back({&s, alignment.theta_r_zero_deg / declared.theta_r_zero_u_deg});
      if (s.kind == Systematic::Kind::standard_lean && alignment.standard_lean_deg != 0)
        parts_.push_back({&s, alignment.standard_lean_deg / declared.sample_lean_u_deg});
    }
  }

  /// What a BRDF is to be multiplied by.
  double factor(std::size_t wavelength, double theta_r_deg, double bias_lever) const {
    double sum = 0;
    for (const auto& [systematic, times] : parts_)
      sum += times * log_shift(calibration_.wavelengths[wavelength], theta_r_deg, bias_lever,
                               systematic->shift[wavelength]);
    // The factor describes by how much points read too high; they are put right.
    return std::exp(-sum);
  }

 private:
  const Calibration& calibration_;
  std::vector<std::pair<const Systematic*, double>> parts_;
};

void take_out_aperture(formats::BrdfTable::Points& points, std::vector<PointOrigin>& origin,
                       const Calibration& calibration, double solid_angle_sr,
                       const BrdfShape& shape, ReduceSummary& summary) {
  const double half_angle = calibration.declared.aperture_half_angle_deg *
                            std::sqrt(solid_angle_sr / calibration.solid_angle_sr);
  if (!(half_angle > 0)) return;
  const ApertureExcess excess = shape ? aperture_excess(points, shape, half_angle)
                                      : aperture_excess(points, angle_slopes(points), half_angle);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points.brdf_per_sr[i] -= excess.per_sr[i];
    origin[i].aperture_excess_per_sr = excess.per_sr[i];
    origin[i].aperture_doubt_per_sr = excess.doubt_per_sr[i];
    if (points.used[i] != 0 && points.brdf_u[i] < 0.1 * std::abs(points.brdf_per_sr[i]))
      summary.largest_aperture_share = std::max(summary.largest_aperture_share,
                                                std::abs(excess.per_sr[i] / points.brdf_per_sr[i]));
  }
  if (summary.largest_aperture_share > 1e-4)
    summary.notes.push_back(fmt::format(
        "the detector disc's averaging is taken out of the points: up to {:.2g} % of the BRDF",
        100 * summary.largest_aperture_share));
  if (excess.too_narrow > 0)
    summary.notes.push_back(fmt::format(
        "{} points lie on a lobe as narrow as the detector disc: the disc's averaging is not taken "
        "out of them and stands in their uncertainty",
        excess.too_narrow));
}

void set_slopes(const formats::BrdfTable::Points& points, std::vector<PointOrigin>& origin,
                const BrdfShape& shape) {
  const AngleSlopes slopes = shape ? angle_slopes(points, shape) : angle_slopes(points);
  for (std::size_t i = 0; i < origin.size(); ++i) {
    origin[i].by_incidence_per_sr_deg = slopes.incidence[i];
    origin[i].by_detector_per_sr_deg = slopes.detector[i];
  }
}

void summarise(const formats::BrdfTable& table, ReduceSummary& summary) {
  std::vector<double> own, total;
  for (std::size_t i = 0; i < table.points.size(); ++i) {
    if (table.points.used[i] == 0) continue;
    double variance = table.points.brdf_u[i] * table.points.brdf_u[i];
    const double f = std::abs(table.points.brdf_per_sr[i]);
    own.push_back(std::sqrt(variance) / f);
    for (const auto& factor : table.factors) variance += factor.per_point[i] * factor.per_point[i];
    total.push_back(std::sqrt(variance) / f);
  }
  summary.median_relative_u = formats::median(own);
  summary.median_relative_total_u = formats::median(total);
}

}  // namespace

Reduction reduce(const formats::ScanTable& scan, const Calibration& calibration,
                 const ReduceOptions& options) {
  check_scan(scan, calibration);
  Reduction result;
  formats::BrdfTable& table = result.table;
  ReduceSummary& summary = result.summary;
  summary.records = scan.size();
  const ScanRows set_up = sort_rows(scan);
  summary.notes = set_up.notes;
  const NoiseModel noise = fit_noise(scan);
  const Dark own_dark = find_dark(scan, set_up, noise);
  const double solid_angle = scan.number("solid_angle_sr").value_or(calibration.solid_angle_sr);
  if (!(solid_angle > 0))
    throw Error(fmt::format("key `solid_angle_sr` is {:g}", solid_angle),
                "give it in sr, such as 1e-4");

  const auto analysed = analysed_signals(scan, set_up, calibration);
  const AlignedStandard standard(calibration, options.alignment);

  auto& points = table.points;
  std::vector<PointOrigin> origin;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (set_up.row[i] != RowUse::plain) {
      ++summary.excluded;
      continue;
    }
    if (scan.saturated[i] != 0 && !noise.has(scan.wavelength_nm[i])) {
      // All of this wavelength is saturated: there is no uncertainty to give.
      ++summary.saturated;
      ++summary.excluded;
      continue;
    }
    const bool aligned = scan.phi_r_deg[i] == 0;
    const double theta_i = scan.theta_i_deg[i] + (aligned ? options.alignment.theta_i_deg() : 0.0);
    const double theta_r = scan.theta_r_deg[i] + (aligned ? options.alignment.theta_r_deg() : 0.0);
    const double cosine = std::cos(theta_r * degree);
    if (!(cosine > 1e-6) || !(scan.monitor_v[i] > 0)) {
      ++summary.excluded;
      continue;
    }
    const double gain = scan.gain[i];
    PointOrigin o;
    o.record = i;
    o.wavelength = calibration.index_of(scan.wavelength_nm[i]);
    o.gain = gain;
    o.theta_i_commanded_deg = scan.theta_i_deg[i];
    o.theta_r_commanded_deg = scan.theta_r_deg[i];
    o.direction = scan.direction[i];
    const WavelengthCalibration& entry = calibration.wavelengths[o.wavelength];
    const DarkChoice dark = choose_dark(own_dark, calibration.dark, gain);
    o.own_dark = dark.own;

    const bool true_states = has_true_states(calibration, o.wavelength);
    if (true_states) {
      // δ is taken out with everything else that the mirror scan knows.
    } else if (formats::is_open(scan.analyzer_deg[i])) {
      const auto found = analysed.find(key_of(scan, i));
      if (found != analysed.end() && found->second.s > 0 && found->second.p > 0)
        o.bias_lever = (found->second.s - found->second.p) / (found->second.s + found->second.p);
      else
        o.open_bias = 1.0 / std::sqrt(3.0);  // Q/I anywhere between -1 and 1
    } else {
      o.bias_lever = -std::cos(2.0 * scan.analyzer_deg[i] * degree);
    }
    const double response = entry.bias_active ? 1.0 + entry.detector_bias * o.bias_lever : 1.0;

    const InstrumentFunction& function = entry.instrument_function;
    const double arm = std::clamp(scan.theta_r_deg[i], function.min_deg, function.max_deg);
    const bool covered = function.covers(scan.theta_r_deg[i]);
    const double correction =
        function.value(arm) * (aligned ? standard.factor(o.wavelength, arm, o.bias_lever) : 1.0);

    const double volts = (scan.x_v[i] - dark.level.x_v) * std::cos(entry.phase_rad) +
                         (scan.y_v[i] - dark.level.y_v) * std::sin(entry.phase_rad);
    const double true_part = 1.0 + calibration.ranges.at(gain).error;
    o.signal_v = calibration.nonlinearity.true_signal(volts / true_part);
    o.stray_v =
        entry.gain_constant_v * stray_share(scan.analyzer_deg[i]) * solid_angle * scan.monitor_v[i];
    o.per_volt =
        correction / (entry.gain_constant_v * solid_angle * scan.monitor_v[i] * cosine * response);
    o.other_solid_angle =
        std::abs(solid_angle / calibration.solid_angle_sr - 1.0) > same_solid_angle;
    const double stray =
        calibration.stray.level(scan.wavelength_nm[i], scan.theta_r_deg[i], scan.phi_r_deg[i]);
    const double f = (o.signal_v - o.stray_v * stray) * o.per_volt;
    const double sd = std::sqrt(record_variance(noise, entry, gain, scan.x_v[i]));
    o.noise_dof = entry.record_scatter > 0
                      ? entry.dof
                      : noise.dof_normalised(scan.wavelength_nm[i], gain, scan.x_v[i]);
    const double u = sd * o.per_volt / true_part;

    bool used = true;
    if (scan.saturated[i] != 0) {
      ++summary.saturated;
      used = false;
    }
    if (!covered && !options.extrapolate_instrument_function) {
      ++summary.outside_instrument_function;
      used = false;
    }
    if (from_retro_deg(scan.theta_i_deg[i], scan.theta_r_deg[i], scan.phi_r_deg[i]) <
        calibration.retro_shadow_deg - 1e-6) {
      ++summary.in_shadow;
      used = false;
    }
    // Such a point stays: leaving out those that noise pushes down would raise the mean of the
    // rest.
    if (!(f > u)) ++summary.below_noise;
    points.theta_i_deg.push_back(theta_i);
    points.theta_r_deg.push_back(theta_r);
    points.phi_r_deg.push_back(scan.phi_r_deg[i]);
    points.wavelength_nm.push_back(scan.wavelength_nm[i]);
    points.polarizer_deg.push_back(scan.polarizer_deg[i]);
    points.analyzer_deg.push_back(scan.analyzer_deg[i]);
    points.brdf_per_sr.push_back(f);
    points.brdf_u.push_back(u);
    points.used.push_back(used ? 1 : 0);
    origin.push_back(o);
  }
  if (points.size() == 0)
    throw Error("no record of the scan was taken with the plain set-up",
                "give a scan with rows outside of the blocks that change the set-up");
  summary.points = points.size();
  take_out_aperture(points, origin, calibration, solid_angle, options.shape, summary);
  set_slopes(points, origin, options.shape);
  table.factors = point_factors(points, origin, calibration, own_dark);
  result.origin = origin;
  std::vector<std::size_t> wavelength;
  for (const PointOrigin& o : origin) wavelength.push_back(o.wavelength);
  for (std::string& note : to_ideal_states(table, wavelength, calibration))
    summary.notes.push_back(std::move(note));
  table.keys = scan.keys;
  for (const auto& [name, value] : calibration.keys)
    table.keys.emplace_back("calibration_" + name, value);
  if (options.alignment.theta_i_deg() != 0 || options.alignment.theta_r_deg() != 0) {
    table.keys.emplace_back("aligned_theta_i_deg",
                            fmt::format("{:.4f}", options.alignment.theta_i_deg()));
    table.keys.emplace_back("aligned_theta_r_deg",
                            fmt::format("{:.4f}", options.alignment.theta_r_deg()));
  }

  if (options.dolp) {
    const DolpCount count = add_dolp(table);
    summary.dolp = table.dolp.dolp.size();
    summary.dolp_skipped = count.skipped;
    if (count.measured + count.summed > 0)
      table.keys.emplace_back("dolp_denominator", count.summed == 0 ? "measured PU"
                                                  : count.measured == 0
                                                      ? "PP + PS"
                                                      : "measured PU, else PP + PS");
    if (count.summed > 0)
      summary.notes.push_back(
          fmt::format("{} of {} DOLP values are divided by PP + PS, as PU was not measured there",
                      count.summed, count.summed + count.measured));
  }
  if (options.mueller) {
    table.mueller = find_mueller(table, options.mueller_partial, summary.mueller);
    if (!summary.mueller.undetermined.empty())
      summary.notes.push_back(fmt::format(
          "{} of {} directions have states for all nine linear Mueller elements; not determined "
          "somewhere: {}",
          summary.mueller.complete, summary.mueller.directions,
          fmt::join(summary.mueller.undetermined, ", ")));
    if (summary.mueller.unphysical > 0)
      summary.notes.push_back(fmt::format(
          "the Mueller elements of {} directions are unphysical by more than three standard "
          "errors: look for an instrument error that no uncertainty covers",
          summary.mueller.unphysical));
  }
  if (options.dhr) {
    DhrOptions dhr_options;
    dhr_options.normal_incidence_within_deg = options.normal_incidence_within_deg;
    for (const DhrDetail& detail : add_dhr(table, dhr_options)) {
      if (detail.gap_deg > 0)
        summary.notes.push_back(fmt::format(
            "{:g} nm: {}: a specular part there is not included in the DHR ({:.2g} deg to either "
            "side are bridged, u {:.2g})",
            detail.wavelength_nm,
            calibration.retro_shadow_deg > 0 ? "the mirror direction lies in the shadow"
                                             : "the mirror direction has no usable point",
            detail.gap_deg, detail.gap_u));
      table.keys.emplace_back(fmt::format("dhr_states_{:g}", detail.wavelength_nm), detail.states);
      table.keys.emplace_back(
          fmt::format("dhr_parts_{:g}", detail.wavelength_nm),
          fmt::format(
              "u: noise {:.2g}, calibration {:.2g}, quadrature {:.2g}, beyond the last angle "
              "{:.2g}, polarisation {:.2g}, shadow {:.2g}; {:.3g} of the value lies beyond the "
              "last angle",
              detail.noise_u, detail.shared_u, detail.quadrature_u, detail.extrapolation_u,
              detail.polarisation_u, detail.gap_u, detail.extrapolation));
    }
  }
  summarise(table, summary);
  for (const std::string& note : calibration.notes)
    if (calibration.inputs.empty()) summary.notes.push_back(note);
  return result;
}

}  // namespace umov::calibrate
