// The joint fit of a mirror scan: Levenberg–Marquardt over all wavelengths, with the scatter beyond
// the noise law learned from the residuals.
//
// Signal per monitor reading of a record: (1 + ρ_g) exp(g) Aᵀ R(-β_r) F(θ) R(β_i) S, with F the
// linear part of the Fresnel Mueller matrix (P7), g the free scale of its angle and set, ρ_g the
// error of the amplifier range, S and A as in polarization.hpp. A normal that leans by b towards +y
// turns the plane of incidence by β_i = -b/sin θ for the source's basis and by b cos 2θ/sin θ for
// that of the arm, to which an arm that stands at azimuth a adds -a cos θ (first order in a and b):
// β_r = b cos 2θ/sin θ - a cos θ.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "host/calibrate/mirror_scan.hpp"
#include "host/calibrate/polarization.hpp"
#include "host/errors/error.hpp"
#include "host/formats/order_statistics.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/fresnel.hpp"
#include "host/optics/refractive_index.hpp"

namespace umov::calibrate {

namespace {

/// Angle of incidence, tilt out of plane, azimuth of the arm, play of polariser and analyser.
constexpr Eigen::Index shared = 5;
using Geometry = Eigen::Matrix<double, shared, 1>;
constexpr Eigen::Index per_wave = polarization_parameters + 2;  // and n, κ
constexpr double reject_at = 6;

Eigen::Matrix3d turn(double angle) {
  const double c = std::cos(2 * angle), s = std::sin(2 * angle);
  Eigen::Matrix3d m;
  m << 1, 0, 0, 0, c, s, 0, -s, c;
  return m;
}

/// Signal per monitor of a unit scale. `geometry`: the shared parameters in degrees; `v`: the nine
/// parameters, n, κ of the wavelength.
double reflected(const MirrorRow& row, const Geometry& geometry,
                 const Eigen::Matrix<double, per_wave, 1>& v) {
  const double theta = std::clamp(optics::radians(row.theta_i_deg + geometry(0)), 1e-3, 1.5707);
  const double lean = optics::radians(geometry(1)), azimuth = optics::radians(geometry(2));
  const auto r = optics::fresnel_reflection(v(9), std::max(0.0, v(10)), std::cos(theta));
  Eigen::Matrix3d fresnel;
  fresnel << r.mean, r.half_difference, 0, r.half_difference, r.mean, 0, 0, 0, r.cross_re;
  PolarizationVector parameters = v.head<polarization_parameters>();
  parameters(0) -= 0.5 * row.polarizer_direction * geometry(3);
  parameters(1) -= 0.5 * row.analyzer_direction * geometry(4);
  const Eigen::Vector3d in =
      turn(-lean / std::sin(theta)) * source_vector(parameters, row.polarizer_deg);
  const double exit_turn = lean * std::cos(2 * theta) / std::sin(theta) - azimuth * std::cos(theta);
  const Eigen::Vector3d out = turn(-exit_turn) * (fresnel * in);
  return analyzer_vector(parameters, row.analyzer_deg).dot(out);
}

class MirrorFit {
 public:
  MirrorFit(MirrorRecords records, const PolarizationOptions& options, const RangeErrors& ranges,
            const optics::IndexTable& index)
      : records_(std::move(records)), options_(options) {
    const auto waves = static_cast<Eigen::Index>(records_.wavelengths_nm.size());
    first_scale_ = shared + per_wave * waves;
    first_monitor_ = first_scale_ + static_cast<Eigen::Index>(records_.scales.size());
    first_range_ = first_monitor_ + static_cast<Eigen::Index>(records_.sets);
    const auto gains = static_cast<Eigen::Index>(records_.gains.size());
    count_ = first_range_ + gains;
    value_ = Eigen::VectorXd::Zero(count_);
    prior_ = Eigen::VectorXd::Zero(count_);
    prior_u_ = Eigen::VectorXd::Constant(count_, 1e6);
    step_ = Eigen::VectorXd::Constant(count_, 1e-6);
    prior_u_(0) = options.incidence_offset_u_deg;
    prior_u_(1) = options.tilt_out_of_plane_u_deg;
    prior_u_(2) = options.azimuth_offset_u_deg;
    prior_u_(3) = prior_u_(4) = options.play_u_deg;
    step_.head(shared).setConstant(1e-4);
    for (Eigen::Index w = 0; w < waves; ++w) {
      const Eigen::Index at = shared + per_wave * w;
      const double um = records_.wavelengths_nm[static_cast<std::size_t>(w)] * 1e-3;
      Eigen::Matrix<double, per_wave, 1> start, u, h;
      start << 0, 0, 1e-4, 1e-4, 0, 0, 0, 0, 1, index.n(um), index.kappa(um);
      // Axes and extinctions are known by the data alone; the leak's coherence is what a dichroic
      // sheet has, down to none.
      u << 20, 20, 1, 1, options.bias_u, options.bias_u, 0.5, 0.5, 0.5,
          options.n_relative_u * start(9), options.kappa_u;
      h << 1e-4, 1e-4, 1e-7, 1e-7, 1e-6, 1e-6, 1e-5, 1e-5, 1e-3, 1e-5, 1e-5;
      value_.segment<per_wave>(at) = start;
      prior_.segment<per_wave>(at) = start;
      prior_u_.segment<per_wave>(at) = u;
      step_.segment<per_wave>(at) = h;
      // Extinction starts at nothing known.
      prior_(at + 2) = prior_(at + 3) = 0;
    }
    for (Eigen::Index k = 0; k < gains; ++k) {
      const double gain = records_.gains[static_cast<std::size_t>(k)];
      const Eigen::Index number = ranges.number(gain);
      const RangeError error =
          number >= 0 ? ranges.at(gain) : RangeError{gain, 0, options.range_tolerance, false};
      value_(first_range_ + k) = prior_(first_range_ + k) = error.error;
      // The lowest range is the scale itself.
      prior_u_(first_range_ + k) = k == 0 ? 1e-9 : std::max(error.u, 1e-9);
    }
    relative2_.assign(records_.sets, 1e-4);
    share_.assign(records_.sets, 1.0);
    kept_.assign(records_.rows.size(), true);
    start_scales();
  }

  void run() {
    for (int round = 0; round < 8; ++round) {
      const double before = chi2_;
      minimise();
      const bool same_rows = !reject();
      learn_scatter();
      minimise();
      if (round > 1 && same_rows && std::abs(chi2_ - before) < 1e-3 * (1 + before)) break;
    }
  }

  PolarizationCalibration result(const std::string& index_name);

 private:
  Eigen::Matrix<double, per_wave, 1> wave(const Eigen::VectorXd& v, std::size_t w) const {
    return v.segment<per_wave>(shared + per_wave * static_cast<Eigen::Index>(w));
  }

  double range_factor(const Eigen::VectorXd& v, double gain) const {
    const auto at = std::lower_bound(records_.gains.begin(), records_.gains.end(), gain);
    return 1.0 + v(first_range_ + std::distance(records_.gains.begin(), at));
  }

  double modelled(const Eigen::VectorXd& v, const MirrorRow& row) const {
    return row.monitor_v * range_factor(v, row.gain) *
           std::exp(v(first_scale_ + static_cast<Eigen::Index>(row.scale))) *
           reflected(row, v.head<shared>(), wave(v, row.wavelength));
  }

  double log_monitor(const Eigen::VectorXd& v, const MirrorMonitor& m) const {
    // The monitor's own reading of unit light: the source vector is divided by it.
    const double reading =
        monitor_reading(wave(v, m.wavelength).head<polarization_parameters>(), m.polarizer_deg);
    return v(first_monitor_ + static_cast<Eigen::Index>(m.set)) + std::log(reading);
  }

  static double monitor_reading(const PolarizationVector& p, double axis_deg) {
    // I + mQ of the beam behind the polariser: with I' = I/(I + mQ), Q' = Q/(I + mQ) known, the
    // absolute I comes from the same formulas with m = 0.
    PolarizationVector bare = p;
    bare(index_of(PolarizationParameter::monitor_bias)) = 0;
    const Eigen::Vector3d relative = source_vector(bare, axis_deg);  // (1, Q/I, U/I)
    const double q = p(index_of(PolarizationParameter::source_q));
    const double u = p(index_of(PolarizationParameter::source_u));
    double intensity = 1.0;
    if (!formats::is_open(axis_deg)) {
      const double e = p(index_of(PolarizationParameter::polarizer_extinction));
      const Eigen::Vector3d n =
          ideal_source_vector(axis_deg + p(index_of(PolarizationParameter::polarizer_axis_deg)));
      intensity = 0.5 * (1 + e) + 0.5 * (1 - e) * (n(1) * q + n(2) * u);
    }
    return intensity * (1.0 + p(index_of(PolarizationParameter::monitor_bias)) * relative(1));
  }

  void start_scales() {
    std::vector<std::vector<double>> ratio(records_.scales.size());
    for (const MirrorRow& row : records_.rows) {
      const double model = reflected(row, value_.head<shared>(), wave(value_, row.wavelength));
      if (row.signal_v > 0 && model > 0)
        ratio[row.scale].push_back(std::log(row.signal_v / (row.monitor_v * model)));
    }
    for (std::size_t k = 0; k < ratio.size(); ++k)
      if (!ratio[k].empty())
        value_(first_scale_ + static_cast<Eigen::Index>(k)) = formats::median(ratio[k]);
    for (const MirrorMonitor& m : records_.monitors)
      value_(first_monitor_ + static_cast<Eigen::Index>(m.set)) = m.log_monitor + std::log(2.0);
  }

  double variance(const MirrorRow& row, double model) const {
    return share_[row.set] * row.variance_v2 + relative2_[row.set] * model * model;
  }

  /// Residuals: records, monitors, ties between the scales of one angle, priors.
  Eigen::VectorXd residuals(const Eigen::VectorXd& v) const {
    const auto n = static_cast<Eigen::Index>(records_.rows.size());
    const auto m = static_cast<Eigen::Index>(records_.monitors.size());
    const auto t = static_cast<Eigen::Index>(ties_.size());
    Eigen::VectorXd r(n + m + t + count_);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      r(i) =
          kept_[k] ? (records_.rows[k].signal_v - modelled(v, records_.rows[k])) * weight_[k] : 0.0;
    }
    for (Eigen::Index i = 0; i < m; ++i) {
      const MirrorMonitor& monitor = records_.monitors[static_cast<std::size_t>(i)];
      r(n + i) = (monitor.log_monitor - log_monitor(v, monitor)) / monitor.u;
    }
    for (Eigen::Index i = 0; i < t; ++i) {
      const auto& [a, b] = ties_[static_cast<std::size_t>(i)];
      r(n + m + i) = (v(first_scale_ + a) - v(first_scale_ + b)) / scale_tie_u;
    }
    r.tail(count_) = (v - prior_).cwiseQuotient(prior_u_);
    return r;
  }

  Eigen::MatrixXd jacobian(const Eigen::VectorXd& v) const {
    const auto n = static_cast<Eigen::Index>(records_.rows.size());
    const auto m = static_cast<Eigen::Index>(records_.monitors.size());
    const auto t = static_cast<Eigen::Index>(ties_.size());
    Eigen::MatrixXd j = Eigen::MatrixXd::Zero(n + m + t + count_, count_);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (!kept_[k]) continue;
      const MirrorRow& row = records_.rows[k];
      const double model = modelled(v, row), w = -weight_[k];
      j(i, first_scale_ + static_cast<Eigen::Index>(row.scale)) = w * model;
      const auto at = std::lower_bound(records_.gains.begin(), records_.gains.end(), row.gain);
      j(i, first_range_ + std::distance(records_.gains.begin(), at)) =
          w * model / range_factor(v, row.gain);
      const double scale = model / reflected(row, v.head<shared>(), wave(v, row.wavelength));
      const Eigen::Index first = shared + per_wave * static_cast<Eigen::Index>(row.wavelength);
      const auto derivative = [&](Eigen::Index parameter) {
        const auto shifted = [&](double sign) {
          Geometry geometry = v.head<shared>();
          auto own = wave(v, row.wavelength);
          if (parameter < shared)
            geometry(parameter) += sign * step_(parameter);
          else
            own(parameter - first) += sign * step_(parameter);
          return reflected(row, geometry, own);
        };
        return w * scale * (shifted(1) - shifted(-1)) / (2 * step_(parameter));
      };
      for (Eigen::Index p = 0; p < shared; ++p) j(i, p) = derivative(p);
      for (Eigen::Index p = first; p < first + per_wave; ++p) j(i, p) = derivative(p);
    }
    for (Eigen::Index i = 0; i < m; ++i) {
      const MirrorMonitor& monitor = records_.monitors[static_cast<std::size_t>(i)];
      j(n + i, first_monitor_ + static_cast<Eigen::Index>(monitor.set)) = -1.0 / monitor.u;
      const Eigen::Index first = shared + per_wave * static_cast<Eigen::Index>(monitor.wavelength);
      for (Eigen::Index p = first; p < first + polarization_parameters; ++p) {
        Eigen::VectorXd up = v, down = v;
        up(p) += step_(p);
        down(p) -= step_(p);
        j(n + i, p) =
            -(log_monitor(up, monitor) - log_monitor(down, monitor)) / (2 * step_(p)) / monitor.u;
      }
    }
    for (Eigen::Index i = 0; i < t; ++i) {
      const auto& [a, b] = ties_[static_cast<std::size_t>(i)];
      j(n + m + i, first_scale_ + a) = 1.0 / scale_tie_u;
      j(n + m + i, first_scale_ + b) = -1.0 / scale_tie_u;
    }
    for (Eigen::Index p = 0; p < count_; ++p) j(n + m + t + p, p) = 1.0 / prior_u_(p);
    return j;
  }

  void set_weights() {
    weight_.resize(records_.rows.size());
    for (std::size_t i = 0; i < weight_.size(); ++i)
      weight_[i] = 1.0 / std::sqrt(variance(records_.rows[i], modelled(value_, records_.rows[i])));
    if (!ties_.empty()) return;
    for (std::size_t a = 0; a < records_.scales.size(); ++a)
      for (std::size_t b = a + 1; b < records_.scales.size(); ++b)
        if (records_.scales[a].wavelength == records_.scales[b].wavelength &&
            std::abs(records_.scales[a].theta_i_deg - records_.scales[b].theta_i_deg) < 0.01) {
          ties_.emplace_back(a, b);
          break;  // each to the next of its angle
        }
  }

  void minimise() {
    set_weights();
    double damping = 1e-3;
    Eigen::VectorXd r = residuals(value_);
    double cost = r.squaredNorm();
    for (int iteration = 0; iteration < 60; ++iteration) {
      const Eigen::MatrixXd j = jacobian(value_);
      normal_ = j.transpose() * j;
      const Eigen::VectorXd gradient = j.transpose() * r;
      bool better = false;
      double drop = 0;
      for (int attempt = 0; attempt < 12 && !better; ++attempt) {
        Eigen::MatrixXd damped = normal_;
        damped.diagonal() *= 1.0 + damping;
        const Eigen::VectorXd step = damped.ldlt().solve(-gradient);
        Eigen::VectorXd next = value_ + step;
        limit(next);
        const Eigen::VectorXd trial = residuals(next);
        const double trial_cost = trial.squaredNorm();
        if (std::isfinite(trial_cost) && trial_cost <= cost) {
          better = true;
          drop = cost - trial_cost;
          value_ = next;
          r = trial;
          cost = trial_cost;
          damping = std::max(damping / 10, 1e-9);
        } else {
          damping *= 10;
        }
      }
      if (!better || drop < 1e-7 * (1 + cost)) break;
    }
    const Eigen::MatrixXd j = jacobian(value_);
    normal_ = j.transpose() * j;
    chi2_ = cost;
    // Leverages, for the residuals' own loss of scatter.
    const Eigen::LDLT<Eigen::MatrixXd> solver(normal_);
    leverage_.resize(records_.rows.size());
    for (std::size_t i = 0; i < leverage_.size(); ++i) {
      const Eigen::VectorXd row = j.row(static_cast<Eigen::Index>(i)).transpose();
      leverage_[i] = std::clamp(row.dot(solver.solve(row)), 0.0, 1.0);
    }
  }

  /// Extinctions cannot be negative by more than the model can bear; indices stay physical.
  void limit(Eigen::VectorXd& v) const {
    for (std::size_t w = 0; w < records_.wavelengths_nm.size(); ++w) {
      const Eigen::Index at = shared + per_wave * static_cast<Eigen::Index>(w);
      for (Eigen::Index k : {at + 2, at + 3}) v(k) = std::clamp(v(k), 1e-9, 0.5);
      for (Eigen::Index k : {at + 6, at + 7}) v(k) = std::clamp(v(k), -0.999, 0.999);
      v(at + 9) = std::max(v(at + 9), 1.01);
      v(at + 10) = std::max(v(at + 10), 0.0);
    }
  }

  /// Flags records far off; true where that changed anything.
  bool reject() {
    std::vector<std::vector<double>> size(records_.sets);
    std::vector<double> pull(records_.rows.size());
    for (std::size_t i = 0; i < pull.size(); ++i) {
      const MirrorRow& row = records_.rows[i];
      pull[i] = std::abs(row.signal_v - modelled(value_, row)) * weight_[i];
      size[row.set].push_back(pull[i]);
    }
    bool changed = false;
    for (std::size_t i = 0; i < pull.size(); ++i) {
      const double scatter = std::max(1.0, formats::median(size[records_.rows[i].set]) / 0.6745);
      const bool keep = pull[i] < reject_at * scatter;
      changed = changed || keep != kept_[i];
      kept_[i] = keep;
    }
    return changed;
  }

  /// Scatter of each set, by the likelihood of its residuals with the leverage taken out: what goes
  /// with the signal, and the share of the noise law that is left after division by the monitor
  /// (the law cannot tell fluctuation of the source, which cancels, from photon noise).
  void learn_scatter() {
    struct Term {
      double squared, fixed, model2, freedom;
    };
    for (std::size_t s = 0; s < records_.sets; ++s) {
      std::vector<Term> terms;
      for (std::size_t i = 0; i < records_.rows.size(); ++i) {
        const MirrorRow& row = records_.rows[i];
        if (row.set != s || !kept_[i]) continue;
        const double model = modelled(value_, row), free = 1.0 - leverage_[i];
        if (free < 0.02) continue;
        const double d = row.signal_v - model;
        terms.push_back({d * d, row.variance_v2, model * model, free});
      }
      if (terms.size() < 5) continue;
      double best = std::numeric_limits<double>::infinity();
      for (const double share : {1.0, 0.7, 0.5, 0.35, 0.25, 0.17, 0.12, 0.08, 0.06, 0.04})
        for (int k = 0; k <= 120; ++k) {
          const double c = std::pow(10.0, -10.0 + 0.08 * k);
          // Weak pulls to a part in a thousand and to the law keep both from running to nothing.
          const double away = (std::log(c) - std::log(1e-6)) / 4.0, off = std::log(share) / 1.5;
          double deviance = away * away + off * off;
          for (const Term& t : terms) {
            const double v = share * t.fixed + c * t.model2;
            deviance += std::min(t.squared / v, 25.0 * t.freedom) + t.freedom * std::log(v);
          }
          if (deviance < best) {
            best = deviance;
            relative2_[s] = c;
            share_[s] = share;
          }
        }
    }
  }

  static constexpr double scale_tie_u = 0.005;  ///< drift of the source between blocks
  MirrorRecords records_;
  PolarizationOptions options_;
  Eigen::Index first_scale_ = 0, first_monitor_ = 0, first_range_ = 0, count_ = 0;
  Eigen::VectorXd value_, prior_, prior_u_, step_;
  Eigen::MatrixXd normal_;
  std::vector<double> relative2_, share_, weight_, leverage_;
  std::vector<bool> kept_;
  std::vector<std::pair<Eigen::Index, Eigen::Index>> ties_;
  double chi2_ = 0;
};

PolarizationCalibration MirrorFit::result(const std::string& index_name) {
  PolarizationCalibration out;
  const std::size_t waves = records_.wavelengths_nm.size();
  const Eigen::VectorXd scale = normal_.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd unit = scale.asDiagonal() * normal_ * scale.asDiagonal();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(count_, count_);
  const Eigen::MatrixXd covariance =
      scale.asDiagonal() * unit.ldlt().solve(identity) * scale.asDiagonal();
  const auto side = static_cast<Eigen::Index>(waves) * polarization_parameters;
  out.covariance = Eigen::MatrixXd::Zero(side, side);
  std::vector<double> widening(waves, 1.0);
  for (std::size_t w = 0; w < waves; ++w) {
    PolarizationWavelength entry;
    entry.wavelength_nm = records_.wavelengths_nm[w];
    const auto own = wave(value_, w);
    entry.set_values(own.head<polarization_parameters>());
    entry.index_n = own(9);
    entry.index_kappa = own(10);
    const Eigen::Index at = shared + per_wave * static_cast<Eigen::Index>(w);
    entry.index_n_u = std::sqrt(covariance(at + 9, at + 9));
    entry.index_kappa_u = std::sqrt(covariance(at + 10, at + 10));
    double slow = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < records_.rows.size(); ++i) {
      const MirrorRow& row = records_.rows[i];
      if (row.wavelength != w) continue;
      if (!kept_[i]) {
        ++entry.rejected;
        continue;
      }
      ++entry.records;
      const double pull = (row.signal_v - modelled(value_, row)) * weight_[i];
      entry.chi2 += pull * pull;
      entry.dof += 1.0 - leverage_[i];
      slow = std::min(slow, relative2_[row.set]);
    }
    entry.slow_noise = std::sqrt(slow);
    if (entry.dof > 0) widening[w] = std::sqrt(std::max(1.0, entry.chi2 / entry.dof));
    out.wavelengths.push_back(entry);
  }
  const double position2 = options_.position_u_deg * options_.position_u_deg;
  const double polarizer2 = position2 + 0.25 * value_(3) * value_(3);
  const double analyzer2 = position2 + 0.25 * value_(4) * value_(4);
  for (std::size_t a = 0; a < waves; ++a)
    for (std::size_t b = 0; b < waves; ++b) {
      const auto to_a = static_cast<Eigen::Index>(a) * polarization_parameters;
      const auto to_b = static_cast<Eigen::Index>(b) * polarization_parameters;
      out.covariance.block(to_a, to_b, polarization_parameters, polarization_parameters) =
          widening[a] * widening[b] *
          covariance.block(shared + per_wave * static_cast<Eigen::Index>(a),
                           shared + per_wave * static_cast<Eigen::Index>(b),
                           polarization_parameters, polarization_parameters);
      // The drives are the same for all wavelengths.
      out.covariance(to_a, to_b) += polarizer2;
      out.covariance(to_a + 1, to_b + 1) += analyzer2;
    }
  out.set_uncertainties();
  out.incidence_offset_deg = value_(0);
  out.incidence_offset_u_deg = std::sqrt(covariance(0, 0));
  out.tilt_out_of_plane_deg = value_(1);
  out.tilt_out_of_plane_u_deg = std::sqrt(covariance(1, 1));
  out.azimuth_offset_deg = value_(2);
  out.azimuth_offset_u_deg = std::sqrt(covariance(2, 2));
  out.polarizer_play_deg = value_(3);
  out.polarizer_play_u_deg = std::sqrt(covariance(3, 3));
  out.analyzer_play_deg = value_(4);
  out.analyzer_play_u_deg = std::sqrt(covariance(4, 4));
  out.index = index_name;
  out.notes = records_.notes;
  for (const PolarizationWavelength& entry : out.wavelengths) {
    if (!(entry.polarizer_axis_u_deg < 1.0) || !(entry.analyzer_axis_u_deg < 1.0))
      throw Error(
          fmt::format("the mirror scan does not determine the axes at {:g} nm (polariser "
                      "+-{:.2g} deg, analyser +-{:.2g} deg)",
                      entry.wavelength_nm, entry.polarizer_axis_u_deg, entry.analyzer_axis_u_deg),
          "add states a few degrees to either side of the crossed ones, such as P/84 and "
          "P/96, S/6 and S/-6, at several angles of incidence");
    if (entry.dof > 20 && entry.chi2 / entry.dof > 1.5)
      out.notes.push_back(
          fmt::format("{:g} nm: the mirror's records scatter {:.1f} times their noise about the "
                      "fit; the uncertainties are widened by that",
                      entry.wavelength_nm, std::sqrt(entry.chi2 / entry.dof)));
    if (entry.records > 0 && entry.rejected * 20 > entry.records)
      out.notes.push_back(
          fmt::format("{:g} nm: {} of {} records of the mirror scan are far off "
                      "the fit and left out",
                      entry.wavelength_nm, entry.rejected, entry.records + entry.rejected));
  }
  return out;
}

optics::IndexTable index_table(const std::string& name) {
  const auto names = optics::IndexTable::embedded_names();
  if (std::find(names.begin(), names.end(), name) != names.end())
    return optics::IndexTable::embedded(name);
  return optics::IndexTable::from_file(name);
}

}  // namespace

PolarizationCalibration find_polarization(const formats::ScanTable& mirror_scan,
                                          const PolarizationOptions& options, const Dark& dark,
                                          const RangeErrors& ranges) {
  MirrorFit fit(mirror_records(mirror_scan, dark), options, ranges, index_table(options.index));
  fit.run();
  PolarizationCalibration result = fit.result(options.index);
  result.mirror = mirror_scan.key("sample").value_or("");
  return result;
}

}  // namespace umov::calibrate
