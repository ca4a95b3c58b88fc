#include "host/calibrate/monte_carlo.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "host/calibrate/declared_causes.hpp"
#include "host/calibrate/normal_stream.hpp"
#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::calibrate {

namespace {

constexpr auto no_point = std::numeric_limits<std::size_t>::max();

constexpr double degree = optics::radians(1.0);

/// One draw of everything that no record shows.
struct Truth {
  double scale, shape, open_bias, undetermined;
  std::vector<double> retention, polarization, bias;  ///< by wavelength of the calibration
  std::map<double, double> range_error, dark_v;       ///< by amplifier range
  double kappa_per_v;
  std::vector<double> stray_even, stray_forward;  ///< by wavelength
  std::vector<double> declared;                   ///< by declared cause, in units of u
  std::optional<PolarizationCalibration> polarizers;
};

/// Spread of the truth that is drawn for a quantity with prior `prior_u` and result `result_u`.
/// Where scans fix it far better than the prior, drawing the whole prior would leave the linear
/// range for nothing: at this limit what the estimate does not follow is a twentieth of its
/// variance.
double drawn_u(double prior_u, double result_u) {
  return std::min(prior_u, std::sqrt(20.0) * result_u);
}

double cos_twice(double axis_deg) {
  return formats::is_open(axis_deg) ? 0.0 : std::cos(2.0 * axis_deg * degree);
}

/// One scan with what drawing its records needs.
struct Source {
  const CampaignScan* scan;
  ScanRows rows;
  NoiseModel noise;
  std::vector<std::size_t> run;
  bool standard = false;                     ///< it fixes the gain
  std::vector<std::size_t> record_to_point;  ///< of the reduced scan; no_point where it has none
};

class Drawing {
 public:
  Drawing(const std::vector<CampaignScan>& scans, const CampaignOptions& options,
          const Campaign& base, const CampaignScan& reduced, const Reduction& reduction,
          const ReduceOptions& reduce_options, const MonteCarloOptions& draws)
      : options_(options),
        base_(base),
        calibration_(base.calibration),
        reduction_(reduction),
        reduce_options_(reduce_options),
        draws_(draws),
        standard_(standard_of(scans, options)),
        reference_(campaign_reference(scans[standard_], options)) {
    reduce_options_.dolp = false;
    reduce_options_.mueller = false;
    for (const CampaignScan& scan : scans) sources_.push_back(source_of(scan));
    sources_[standard_].standard = true;
    const auto same = std::find_if(scans.begin(), scans.end(), [&](const CampaignScan& s) {
      return !reduced.sha256.empty() && s.sha256 == reduced.sha256;
    });
    reduced_ = static_cast<std::size_t>(same - scans.begin());
    outside_ = same == scans.end();
    if (outside_) sources_.push_back(source_of(reduced));
    Source& source = sources_[reduced_];
    source.record_to_point.assign(source.scan->table.size(), no_point);
    for (std::size_t point = 0; point < reduction.origin.size(); ++point)
      source.record_to_point[reduction.origin[point].record] = point;
    causes_ = declared_causes(reduction.table.points, reduction.origin, calibration_);
    if (calibration_.polarization && calibration_.polarization->covariance.size() > 0) {
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
          calibration_.polarization->covariance);
      polarization_root_ =
          solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
    }
    for (const WavelengthCalibration& w : calibration_.wavelengths)
      bias_decided_.push_back(w.bias_active);
  }

  /// BRDF of all points and DHR of one draw; empty where the chain refused.
  struct Outcome {
    std::vector<double> brdf_per_sr, dhr;
  };

  Outcome run(std::size_t draw) const {
    const Truth truth = draw_truth(draw);
    std::vector<CampaignScan> scans, linearity;
    for (std::size_t k = 0; k < sources_.size(); ++k) scans.push_back(redraw(k, draw, truth));
    CampaignScan reduced = scans[reduced_];
    if (outside_) scans.pop_back();
    for (std::size_t k = 0; k < scans.size(); ++k) {
      linearity.push_back(scans[k]);
      add_drift(sources_[k], k, draw, linearity.back());
    }
    CampaignSteps steps;
    steps.checks = false;
    steps.bias_decided = bias_decided_;
    steps.polarization = truth.polarizers;
    steps.linearity_scans = &linearity;
    steps.shape = base_.shape;
    const Campaign campaign = evaluate_campaign(scans, options_, steps);
    const Reduction result = reduce(reduced.table, campaign.calibration, reduce_options_);
    Outcome outcome{result.table.points.brdf_per_sr, result.table.dhr.dhr};
    for (const auto& factor : reduction_.table.factors) {
      const bool open = factor.name.starts_with("detector bias of open");
      if (!open && !factor.name.starts_with("undetermined")) continue;
      for (std::size_t i = 0; i < outcome.brdf_per_sr.size(); ++i)
        outcome.brdf_per_sr[i] +=
            (open ? truth.open_bias : truth.undetermined) * factor.per_point[i];
    }
    return outcome;
  }

 private:
  static Source source_of(const CampaignScan& scan) {
    Source source{&scan, sort_rows(scan.table), fit_noise(scan.table), {}, false, {}};
    source.run = runs_of(scan.table, source.rows);
    return source;
  }

  Truth draw_truth(std::size_t draw) const {
    NormalStream normal(draws_.seed, draw, DrawPurpose::truth);
    Truth truth{};
    truth.scale = normal();
    truth.shape = calibration_.shape_u * normal();
    truth.open_bias = normal();
    truth.undetermined = normal();
    for (const WavelengthCalibration& w : calibration_.wavelengths) {
      truth.retention.push_back((reference_.polarised() ? 0.0 : reference_.retention_u()) *
                                normal());
      truth.polarization.push_back(reference_.polarization_u() * normal());
      truth.bias.push_back((w.bias_active ? 0.0 : w.detector_bias_u) * normal());
    }
    const double range_tolerance = options_.linearity.range_tolerance;
    for (const RangeError& range : calibration_.ranges.ranges)
      truth.range_error[range.gain] =
          drawn_u((range.measured ? 10.0 : 1.0) * range_tolerance, range.u) * normal();
    for (const DarkLevel& level : calibration_.dark.levels)
      truth.dark_v[level.gain] = level.records == 0 ? level.x_u * normal() : 0.0;
    truth.kappa_per_v =
        drawn_u(options_.linearity.kappa_tolerance_per_v, calibration_.nonlinearity.kappa_u_per_v) *
        normal();
    const StrayLight& stray = calibration_.stray;
    const auto lines = static_cast<Eigen::Index>(stray.wavelength_nm.size());
    for (Eigen::Index w = 0; w < 2 * lines; ++w)
      (w < lines ? truth.stray_even : truth.stray_forward)
          .push_back(drawn_u(options_.stray.tolerance_per_sr, std::sqrt(stray.covariance(w, w))) *
                     normal());
    for (std::size_t k = 0; k < causes_.size(); ++k) truth.declared.push_back(normal());
    if (polarization_root_.size() > 0) truth.polarizers = draw_polarizers(normal);
    return truth;
  }

  PolarizationCalibration draw_polarizers(NormalStream& normal) const {
    PolarizationCalibration drawn = *calibration_.polarization;
    Eigen::VectorXd z(polarization_root_.cols());
    for (Eigen::Index k = 0; k < z.size(); ++k) z(k) = normal();
    const Eigen::VectorXd shift = polarization_root_ * z;
    for (std::size_t w = 0; w < drawn.wavelengths.size(); ++w) {
      PolarizationVector values = drawn.wavelengths[w].values();
      values += shift.segment<polarization_parameters>(static_cast<Eigen::Index>(w) *
                                                       polarization_parameters);
      for (auto p : {PolarizationParameter::polarizer_extinction,
                     PolarizationParameter::analyzer_extinction})
        values(index_of(p)) = std::max(values(index_of(p)), 0.0);
      drawn.wavelengths[w].set_values(values);
    }
    return drawn;
  }

  /// Relative change of a record's light by the declared causes: angles, source, solid angle.
  double declared_change(const Source& source, std::size_t i, const Truth& truth) const {
    if (causes_.empty()) return 0;
    const formats::ScanTable& scan = source.scan->table;
    double change = 0;
    const bool reduced = !source.record_to_point.empty();
    if (reduced && source.record_to_point[i] != no_point) {
      const std::size_t point = source.record_to_point[i];
      const double f = reduction_.table.points.brdf_per_sr[point];
      if (!(std::abs(f) > 0)) return 0;
      for (std::size_t k = 0; k < causes_.size(); ++k)
        if (!causes_[k].own_per_sr.empty())
          change += truth.declared[k] * causes_[k].own_per_sr[point] / f;
    } else if (source.standard) {
      const double slope = reference_.log_slope_per_deg(
          scan.theta_i_deg[i], scan.theta_r_deg[i], scan.phi_r_deg[i], scan.wavelength_nm[i],
          scan.polarizer_deg[i], scan.analyzer_deg[i]);
      for (std::size_t k = 0; k < causes_.size(); ++k)
        if (causes_[k].through_standard)
          change +=
              truth.declared[k] * slope *
              detector_shift_deg(calibration_.systematics[*causes_[k].through_standard],
                                 calibration_.declared, scan.theta_r_deg[i], scan.direction[i]);
    }
    return change;
  }

  /// Relative change of a record's light by what is not known of standard and detector.
  double light_change(const Source& source, std::size_t i, const Truth& truth) const {
    const formats::ScanTable& scan = source.scan->table;
    const std::size_t w = calibration_.index_of(scan.wavelength_nm[i]);
    const double lever = -cos_twice(scan.analyzer_deg[i]);
    double change = truth.bias[w] * lever + declared_change(source, i, truth);
    if (!source.standard) return change;
    const WavelengthCalibration& entry = calibration_.wavelengths[w];
    return change + entry.reference_relative_u * truth.scale +
           truth.shape * ReferenceStandard::shape(scan.theta_r_deg[i]) +
           truth.retention[w] * cos_twice(scan.polarizer_deg[i]) * cos_twice(scan.analyzer_deg[i]) +
           truth.polarization[w] * lever;
  }

  CampaignScan redraw(std::size_t k, std::size_t draw, const Truth& truth) const {
    const Source& source = sources_[k];
    CampaignScan scan = *source.scan;
    scan.sha256.clear();
    formats::ScanTable& table = scan.table;
    NormalStream normal(draws_.seed, draw, DrawPurpose::noise, k);
    for (std::size_t i = 0; i < table.size(); ++i) {
      const double gain = table.gain[i], wavelength = table.wavelength_nm[i];
      const bool closed = table.shutter_open[i] == 0;
      double variance =
          closed ? source.noise.variance_x(wavelength, gain, table.x_v[i])
                 : record_variance(source.noise, calibration_.at(wavelength), gain, table.x_v[i]);
      if (source.standard && !closed)
        variance = standard_variance(calibration_.at(wavelength), variance, table.x_v[i]);
      const double variance_y = source.noise.variance_y(wavelength, gain, table.x_v[i]);
      double x = table.x_v[i], y = table.y_v[i];
      if (!closed && scan.role != "dark") {
        const DarkLevel dark = calibration_.dark.at(gain);
        const std::size_t w = calibration_.index_of(wavelength);
        const double stray = stray_volts(source, i, w, truth);
        double factor = 1.0 + light_change(source, i, truth);
        const double signal = std::hypot(x - dark.x_v, y - dark.y_v);
        factor /= 1.0 + truth.kappa_per_v * signal * factor;
        if (const auto error = truth.range_error.find(gain); error != truth.range_error.end())
          factor *= 1.0 + error->second;
        const double phase = calibration_.wavelengths[w].phase_rad;
        x = dark.x_v + (x - dark.x_v) * factor + stray * std::cos(phase);
        y = dark.y_v + (y - dark.y_v) * factor + stray * std::sin(phase);
        if (const auto level = truth.dark_v.find(gain); level != truth.dark_v.end())
          x += level->second;
      }
      table.x_v[i] = x + std::sqrt(variance) * normal();
      table.y_v[i] = y + std::sqrt(variance_y) * normal();
    }
    return scan;
  }

  /// A record of the standard scatters as its fit says.
  static double standard_variance(const WavelengthCalibration& w, double variance, double signal) {
    const double widening = w.dof > 0 ? std::max(1.0, w.chi2 / w.dof) : 1.0;
    return widening * (variance + w.standard_scatter * w.standard_scatter * signal * signal);
  }

  double stray_volts(const Source& source, std::size_t i, std::size_t w, const Truth& truth) const {
    if (truth.stray_even.empty()) return 0;
    const formats::ScanTable& scan = source.scan->table;
    const double level =
        truth.stray_even[w] + truth.stray_forward[w] * calibration_.stray.forward_share(
                                                           scan.theta_r_deg[i], scan.phi_r_deg[i]);
    return level * calibration_.wavelengths[w].gain_constant_v * stray_share(scan.analyzer_deg[i]) *
           calibration_.solid_angle_sr * scan.monitor_v[i];
  }

  void add_drift(const Source& source, std::size_t k, std::size_t draw, CampaignScan& scan) const {
    NormalStream drift(draws_.seed, draw, DrawPurpose::drift, k);
    NormalStream slow(draws_.seed, draw, DrawPurpose::linearity_noise, k);
    const std::size_t runs =
        source.run.empty() ? 0 : *std::max_element(source.run.begin(), source.run.end()) + 1;
    std::vector<double> offset;
    for (std::size_t r = 0; r < runs; ++r) offset.push_back(options_.linearity.drift * drift());
    for (std::size_t i = 0; i < scan.table.size(); ++i) {
      const double there = source.noise.relative2_normalised(scan.table.wavelength_nm[i]);
      const double more =
          base_.linearity.slow_noise * base_.linearity.slow_noise - there;  // redraw had the rest
      const double factor = 1.0 + offset[source.run[i]] + std::sqrt(std::max(0.0, more)) * slow();
      scan.table.x_v[i] *= factor;
      scan.table.y_v[i] *= factor;
    }
  }

  const CampaignOptions& options_;
  const Campaign& base_;
  const Calibration& calibration_;
  const Reduction& reduction_;
  ReduceOptions reduce_options_;
  const MonteCarloOptions& draws_;
  std::size_t standard_, reduced_ = 0;
  ReferenceStandard reference_;
  bool outside_ = false;  ///< the reduced scan is none of the campaign's
  std::vector<Source> sources_;
  std::vector<DeclaredCause> causes_;
  Eigen::MatrixXd polarization_root_;
  std::vector<bool> bias_decided_;
};

/// Sums of deviations from the value itself, so that no digits are lost.
struct Moments {
  std::vector<double> sum, squares;
  void add(const std::vector<double>& value, const std::vector<double>& about) {
    sum.resize(about.size());
    squares.resize(about.size());
    for (std::size_t i = 0; i < about.size() && i < value.size(); ++i) {
      const double d = value[i] - about[i];
      sum[i] += d;
      squares[i] += d * d;
    }
  }
  double mean(std::size_t i, double n) const { return sum[i] / n; }
  double deviation(std::size_t i, double n) const {
    return std::sqrt(std::max(0.0, (squares[i] - sum[i] * sum[i] / n) / (n - 1.0)));
  }
};

}  // namespace

MonteCarlo monte_carlo(const std::vector<CampaignScan>& scans, const CampaignOptions& options,
                       const Campaign& base, const CampaignScan& scan, const Reduction& reduction,
                       const ReduceOptions& reduce_options, const MonteCarloOptions& draws) {
  if (draws.draws < 10)
    throw Error("fewer than ten draws say nothing of a standard deviation",
                "ask for some hundreds, such as 400");
  const Drawing drawing(scans, options, base, scan, reduction, reduce_options, draws);
  std::vector<std::optional<Drawing::Outcome>> outcomes(draws.draws);
  std::atomic<bool> stopped{false};
  std::mutex reporting;
  std::size_t done = 0;
  std::string refusal;
  for_each_index(draws.draws, draws.threads, [&](std::size_t k) {
    if (stopped) return;
    std::string refused;
    try {
      outcomes[k] = drawing.run(k);
    } catch (const Error& error) {
      refused = error.what();
    }
    const std::lock_guard lock(reporting);
    if (!refused.empty()) refusal = refused;
    if (draws.progress && !draws.progress(++done, draws.draws)) stopped = true;
  });
  if (stopped) throw Error("the Monte Carlo check was stopped", "start it again");

  MonteCarlo result;
  Moments points, dhr;
  for (const auto& outcome : outcomes) {
    if (!outcome) {
      ++result.failed;
      continue;
    }
    ++result.draws;
    points.add(outcome->brdf_per_sr, reduction.table.points.brdf_per_sr);
    dhr.add(outcome->dhr, reduction.table.dhr.dhr);
  }
  if (result.failed * 10 > draws.draws)
    throw Error(
        fmt::format("{} of {} draws failed, one with: {}", result.failed, draws.draws, refusal),
        "the campaign is too near to what calibration refuses; measure more");
  const auto n = static_cast<double>(result.draws);
  for (std::size_t i = 0; i < points.sum.size(); ++i) {
    result.u_per_sr.push_back(points.deviation(i, n));
    result.shift_per_sr.push_back(points.mean(i, n));
  }
  for (std::size_t i = 0; i < dhr.sum.size(); ++i) result.dhr_u.push_back(dhr.deviation(i, n));
  return result;
}

}  // namespace umov::calibrate
