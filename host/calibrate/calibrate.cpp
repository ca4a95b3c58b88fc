// From scans of white standards to a Calibration.
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "host/calibrate/calibration.hpp"
#include "host/calibrate/reduce.hpp"
#include "host/calibrate/standard_fit.hpp"
#include "host/calibrate/standard_rows.hpp"
#include "host/calibrate/standard_scatter.hpp"
#include "host/errors/error.hpp"
#include "host/formats/order_statistics.hpp"
#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

constexpr double degree = optics::radians(1.0);
/// Records this many standard deviations off the richest model are left out (speckle, a
/// reflection).
constexpr double reject_at = 5.0;

bool varies(const std::vector<StandardRow>& rows, double StandardRow::*lever) {
  return std::any_of(rows.begin(), rows.end(), [&](const StandardRow& row) {
    return std::abs(row.*lever - rows.front().*lever) > 1e-3;
  });
}

StandardFit fit_wavelength(std::vector<StandardRow>& rows, const PreparedStandard& input,
                           double wavelength, std::size_t number, const CalibrateOptions& options,
                           WavelengthCalibration& entry, std::vector<std::string>& notes) {
  if (rows.size() < 2)
    throw Error(fmt::format("the white scan `{}` has {} usable records at {:g} nm",
                            input.standard->name, rows.size(), wavelength),
                "measure the standard unsaturated in plane, within the angles of its own table");
  double low = 90, high = -90;
  for (const StandardRow& row : rows) {
    low = std::min(low, row.theta_r_deg);
    high = std::max(high, row.theta_r_deg);
  }
  // One-sided scans say nothing of odd terms: the other side is taken as the mirror image.
  const bool two_sided = low < -20 && high > 20;
  StandardModel model;
  model.reference_deg = options.reference_angle_deg;
  const bool any_retention = std::any_of(rows.begin(), rows.end(), [](const StandardRow& row) {
    return std::abs(row.retention_lever) > 1e-3;
  });
  if (any_retention) model.retention_u = input.standard->reference.retention_u();

  // Rejection in rounds, as a far outlier drags the fit and widens its scatter; the median of the
  // residuals does not follow a few of them.
  const std::size_t all = rows.size();
  StandardFit fit;
  for (int round = 0; round < 6; ++round) {
    fit = choose_instrument_function(rows, model, options.max_degree, two_sided);
    std::vector<double> size;
    for (double pull : fit.pull) size.push_back(std::abs(pull));
    const double scatter = std::max(1.0, formats::median(std::move(size)) / 0.6745);
    std::vector<StandardRow> kept;
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (std::abs(fit.pull[i]) < reject_at * scatter) kept.push_back(rows[i]);
    if (kept.size() == rows.size() || kept.size() < 2 || round == 5) break;
    rows = std::move(kept);
  }
  entry.rejected += all - rows.size();
  const PolarizationWavelength* wafer =
      options.polarization ? options.polarization->find(wavelength) : nullptr;
  const bool can_bias = varies(rows, &StandardRow::bias_lever);
  if (options.bias == CalibrateOptions::Bias::on && !can_bias)
    throw Error(
        "the detector's polarisation bias is asked for, but the white scan has one analyser state "
        "only",
        "measure the standard with analyser P and S, best with both polariser states");
  if (wafer != nullptr && options.bias != CalibrateOptions::Bias::off) {
    // The wafer's δ is prior knowledge of the standard's: so it counts once.
    model.bias = true;
    model.bias_prior = wafer->detector_bias;
    model.bias_prior_u = std::max(wafer->detector_bias_u, 1e-7);
    model.polarization_u = input.standard->reference.polarization_u();
    fit = choose_instrument_function(rows, model, options.max_degree, two_sided);
    const auto at = static_cast<Eigen::Index>(fit.model.degrees.size()) + 1;
    entry.bias_active = true;
    entry.detector_bias = fit.parameters(at);
    entry.detector_bias_u = std::sqrt(fit.covariance(at, at));
  } else if (options.bias != CalibrateOptions::Bias::off && can_bias) {
    model.bias = true;
    StandardFit with = choose_instrument_function(rows, model, options.max_degree, two_sided);
    const auto at = static_cast<Eigen::Index>(with.model.degrees.size()) + 1;
    entry.detector_bias = with.parameters(at);
    // A standard that polarises by itself looks the same as a biased detector.
    const double polarization_u = input.standard->reference.polarization_u();
    with.covariance(at, at) += polarization_u * polarization_u;
    entry.detector_bias_u = std::sqrt(with.covariance(at, at));
    entry.bias_active = options.bias == CalibrateOptions::Bias::on ||
                        std::abs(entry.detector_bias) > 3.0 * entry.detector_bias_u;
    if (number < options.bias_decided.size()) entry.bias_active = options.bias_decided[number];
    if (entry.bias_active) fit = with;
  } else if (options.bias != CalibrateOptions::Bias::off) {
    // One analyser state says nothing of δ: it may be what the standard's own polarisation may be.
    entry.detector_bias_u = input.standard->reference.polarization_u();
  }
  if (!entry.bias_active) {
    for (std::size_t i = 0; i < rows.size(); ++i)
      entry.gain_bias_lever +=
          fit.response(0, static_cast<Eigen::Index>(i)) * rows[i].signal_v * rows[i].bias_lever;
  }
  entry.instrument_function.degrees = fit.model.degrees;
  entry.instrument_function.reference_deg = model.reference_deg;
  for (std::size_t k = 0; k < fit.model.degrees.size(); ++k)
    entry.instrument_function.coefficients.push_back(
        fit.parameters(static_cast<Eigen::Index>(k) + 1));
  const double reach = std::max(std::abs(low), std::abs(high));
  entry.instrument_function.min_deg = two_sided ? low : -reach;
  entry.instrument_function.max_deg = two_sided ? high : reach;
  if (!two_sided)
    notes.push_back(fmt::format(
        "{:g} nm: the standard was scanned on one side of the normal; IF is taken as symmetric",
        wavelength));
  if (any_retention && !varies(rows, &StandardRow::retention_lever))
    notes.push_back(fmt::format(
        "{:g} nm: one polarisation state only; the linear polarisation that the standard keeps "
        "(0 +- {:g}) limits the gain: add states with crossed or open analyser",
        wavelength, model.retention_u));
  if (fit.dof > 20 && fit.chi2 / fit.dof > 1.5)
    notes.push_back(fmt::format(
        "{:g} nm: the standard's records scatter {:.1f} times their noise about the fit; the "
        "uncertainty is widened by that",
        wavelength, std::sqrt(fit.chi2 / fit.dof)));
  return fit;
}

/// fit_wavelength with the scatter that its own residuals show taken as noise of the standard's
/// records: strong signals then weigh no more than they are worth.
StandardFit fit_with_own_scatter(std::vector<StandardRow>& rows, const PreparedStandard& input,
                                 double wavelength, std::size_t number,
                                 const CalibrateOptions& options, WavelengthCalibration& entry,
                                 std::vector<std::string>& notes) {
  const std::vector<StandardRow> all = rows;
  const WavelengthCalibration blank = entry;
  double about_fit2 = 0, between_angles = 0;
  for (int round = 0;; ++round) {
    std::vector<std::string> own_notes;
    StandardFit fit = fit_wavelength(rows, input, wavelength, number, options, entry, own_notes);
    if (round == 0) between_angles = scatter_between_angles(rows, fit);
    const double more = round < 3 ? scatter_about_fit(rows, fit) : 0.0;
    if (more == 0) {
      if (about_fit2 > 0)
        notes.push_back(fmt::format(
            "{:g} nm: the standard's records scatter by {:.2g} % about the fit beyond their noise, "
            "which widens its uncertainty",
            wavelength, 100 * std::sqrt(about_fit2)));
      if (between_angles > 0) {
        entry.record_scatter =
            std::hypot(between_angles, std::sqrt(input.noise.relative2_normalised(wavelength)));
        notes.push_back(fmt::format(
            "{:g} nm: {:.2g} % of that from one angle to the next; `reduce` counts it as noise of "
            "every record",
            wavelength, 100 * between_angles));
      }
      notes.insert(notes.end(), own_notes.begin(), own_notes.end());
      return fit;
    }
    about_fit2 += more * more;
    rows = all;
    for (StandardRow& row : rows) row.variance += about_fit2 * row.signal_v * row.signal_v;
    entry = blank;
    entry.standard_scatter = std::sqrt(about_fit2);
  }
}

/// What one standard deviation of a systematic quantity does to the standard's records.
class StandardShifts {
 public:
  StandardShifts(const PreparedStandard& input, const CalibrateOptions& options)
      : input_(input),
        options_(options),
        electronics_(electronics_shifts(input.ranges, input.nonlinearity)),
        stray_(options.stray.shifts()) {}

  /// Volts by which the signal found from a record falls.
  double drop_v(const StandardRow& row, const Systematic& systematic, double wavelength) const {
    switch (systematic.kind) {
      case Systematic::Kind::dark:
        return row.gain == systematic.gain ? input_.dark.at(systematic.gain).x_u : 0.0;
      case Systematic::Kind::range:
        return electronic_drop_v(row, input_.ranges.number(systematic.gain));
      case Systematic::Kind::nonlinearity:
        return electronic_drop_v(row, electronics_.cols() - 1);
      case Systematic::Kind::stray:
        return row.volts_per_stray *
               options_.stray.level_shift(stray_.col(static_cast<Eigen::Index>(systematic.cause)),
                                          wavelength, row.theta_r_deg, row.phi_r_deg);
      default:
        return -row.signal_v * row.log_slope_per_deg *
               detector_shift_deg(systematic, options_.declared, row.theta_r_deg, row.direction);
    }
  }

 private:
  double electronic_drop_v(const StandardRow& row, Eigen::Index column) const {
    const Eigen::Index range = input_.ranges.number(row.gain);
    const double error = range < 0 ? 0.0 : electronics_(range, column);
    const double kappa = electronics_(electronics_.rows() - 1, column);
    return row.signal_v * (error - kappa * row.signal_v);
  }

  const PreparedStandard& input_;
  const CalibrateOptions& options_;
  Eigen::MatrixXd electronics_, stray_;
};

PreparedStandard prepare(const StandardScan& standard,
                         std::span<const formats::ScanTable> dark_scans,
                         const CalibrateOptions& options, std::vector<std::string>& notes) {
  PreparedStandard input;
  input.standard = &standard;
  const formats::ScanTable& scan = standard.scan;
  input.set_up = sort_rows(scan);
  for (const std::string& note : input.set_up.notes)
    notes.push_back(fmt::format("{}: {}", standard.name, note));
  input.noise = fit_noise(scan);
  input.dark = find_dark(scan, input.set_up, input.noise);
  for (const formats::ScanTable& dark : dark_scans)
    input.dark = merge(input.dark, find_dark_of_dark_scan(dark, fit_noise(dark)));
  input.dark = merge(input.dark, options.dark);
  input.phases = find_phase(scan, input.set_up, input.noise, input.dark);
  const auto solid_angle = scan.number("solid_angle_sr");
  input.solid_angle_sr = solid_angle.value_or(1e-4);
  if (!(input.solid_angle_sr > 0))
    throw Error(
        fmt::format("key `solid_angle_sr` of `{}` is {:g}", standard.name, input.solid_angle_sr),
        "give the detector's solid angle in sr, such as 1e-4");
  if (!solid_angle)
    notes.push_back(fmt::format(
        "{}: no key `solid_angle_sr`; 1e-4 sr is taken (only its product with the gain counts)",
        standard.name));
  input.theta_i_deg = 90;
  for (std::size_t i = 0; i < scan.size(); ++i)
    if (input.set_up.row[i] == RowUse::plain)
      input.theta_i_deg = std::min(input.theta_i_deg, std::abs(scan.theta_i_deg[i]));
  if (!standard.reference.tabulated() && standard.reference.shape_amplitude() == 0)
    notes.push_back(
        fmt::format("{}: its reflectance alone is known, so it counts as Lambertian at incidence "
                    "{:g} deg, with a "
                    "departure of relative amplitude {:g} in the uncertainty (key "
                    "reference_shape_u; a table of its "
                    "BRDF, key reference_brdf, does away with it)",
                    standard.name, input.theta_i_deg, standard.reference.shape_u()));
  return input;
}

}  // namespace

std::vector<StandardCheck> check_standards(std::span<const StandardScan> standards,
                                           std::size_t used, const Calibration& calibration) {
  std::vector<StandardCheck> checks;
  for (std::size_t s = 0; s < standards.size(); ++s) {
    ReduceOptions options;
    options.dolp = false;
    const Reduction reduction = reduce(standards[s].scan, calibration, options);
    for (std::size_t k = 0; k < reduction.table.dhr.dhr.size(); ++k) {
      StandardCheck check;
      check.standard = standards[s].name;
      check.wavelength_nm = reduction.table.dhr.wavelength_nm[k];
      check.stated = standards[s]
                         .reference.dhr(check.wavelength_nm)
                         .value_or(std::numeric_limits<double>::quiet_NaN());
      check.computed = reduction.table.dhr.dhr[k];
      check.computed_u = reduction.table.dhr.dhr_u[k];
      check.used_for_gain = s == used;
      checks.push_back(check);
    }
  }
  return checks;
}

Calibration calibrate(std::span<const StandardScan> standards,
                      std::span<const formats::ScanTable> dark_scans,
                      const CalibrateOptions& options) {
  if (options.standard >= standards.size())
    throw Error("no scan of a white standard is given",
                "scan a white tile with `role = \"white\"` in the plan and give that file");
  Calibration calibration;
  const StandardScan& standard = standards[options.standard];
  PreparedStandard input = prepare(standard, dark_scans, options, calibration.notes);
  const RangeInput range_input{&standard.scan, &input.set_up, &input.noise, &input.dark};
  if (options.linearity) {
    input.ranges = options.linearity->ranges;
    input.nonlinearity = options.linearity->nonlinearity;
  } else {
    input.ranges = find_range_errors(std::span(&range_input, 1), options.range_tolerance);
  }

  calibration.solid_angle_sr = input.solid_angle_sr;
  calibration.shape_u = standard.reference.shape_u();
  calibration.shape_amplitude = standard.reference.shape_amplitude();
  calibration.dark = input.dark;
  calibration.ranges = input.ranges;
  calibration.nonlinearity = input.nonlinearity;
  calibration.stray = options.stray;
  calibration.polarization = options.polarization;
  calibration.declared = options.declared;
  for (const DarkLevel& level : input.dark.levels)
    calibration.systematics.push_back({Systematic::Kind::dark, level.gain});
  for (const RangeError& range : input.ranges.ranges)
    if (range.u > 0) calibration.systematics.push_back({Systematic::Kind::range, range.gain});
  if (input.nonlinearity.kappa_u_per_v > 0)
    calibration.systematics.push_back({Systematic::Kind::nonlinearity, 0});
  for (std::size_t k = 0; k < 2 * options.stray.wavelength_nm.size(); ++k)
    calibration.systematics.push_back({Systematic::Kind::stray, 0, k});
  for (const Systematic& angle : angle_systematics(options.declared))
    calibration.systematics.push_back(angle);
  const StandardShifts shifts(input, options);

  for (double wavelength : wavelengths_of(standard.scan)) {
    WavelengthCalibration entry;
    entry.wavelength_nm = wavelength;
    for (const LockinPhase& phase : input.phases)
      if (std::abs(phase.wavelength_nm - wavelength) < 0.5) {
        entry.phase_rad = phase.phase_rad;
        entry.phase_u_rad = phase.u_rad;
      }
    std::vector<StandardRow> rows = rows_of(input, wavelength, entry.phase_rad);
    const std::size_t all = rows.size();
    const double shadow = remove_gross(rows);
    entry.rejected = all - rows.size();
    calibration.retro_shadow_deg = std::max(calibration.retro_shadow_deg, shadow);
    const PolarizationWavelength* wafer =
        options.polarization ? options.polarization->find(wavelength) : nullptr;
    apply_polarization(rows, wafer);
    subtract_stray(rows, options.stray, wavelength);
    set_variances(rows, input, wavelength);
    const StandardFit fit = fit_with_own_scatter(
        rows, input, wavelength, calibration.wavelengths.size(), options, entry, calibration.notes);
    entry.gain_constant_v = std::exp(fit.parameters(0));
    const Eigen::Index kept = entry.parameters();
    entry.covariance = fit.covariance.topLeftCorner(kept, kept);
    entry.reference_relative_u = standard.reference.relative_u(wavelength);
    entry.records = rows.size();
    entry.chi2 = fit.chi2;
    entry.dof = fit.dof;
    if (wafer != nullptr) entry.polarization_shift = polarization_shift(rows, fit, *wafer, kept);
    for (Systematic& systematic : calibration.systematics) {
      Eigen::VectorXd shift = Eigen::VectorXd::Zero(kept);
      for (std::size_t i = 0; i < rows.size(); ++i)
        shift -= shifts.drop_v(rows[i], systematic, wavelength) *
                 fit.response.col(static_cast<Eigen::Index>(i)).head(kept);
      systematic.shift.push_back(shift);
    }
    calibration.wavelengths.push_back(std::move(entry));
  }
  if (calibration.retro_shadow_deg > 0)
    calibration.notes.push_back(
        fmt::format("the standard is dark on the way back to the source (detector in the beam?): "
                    "directions nearer "
                    "than {:g} deg to it are flagged by `reduce`",
                    calibration.retro_shadow_deg));
  for (const StandardScan& s : standards) calibration.inputs.push_back({s.name, "white", s.sha256});
  calibration.keys.emplace_back("standard", standard.name);
  if (const auto device = standard.scan.key("device"))
    calibration.keys.emplace_back("device", *device);
  if (options.checks)
    calibration.checks = check_standards(standards, options.standard, calibration);
  return calibration;
}

}  // namespace umov::calibrate
