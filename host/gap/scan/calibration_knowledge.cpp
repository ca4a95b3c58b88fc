// A calibration as knowledge of the diagnosis: see knowledge.hpp.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/errors/error.hpp"
#include "host/gap/scan/knowledge.hpp"
#include "host/optics/angles.hpp"

namespace umov::gap::scan {
namespace {

using calibrate::Calibration;
using calibrate::PolarizationWavelength;

/// Least share of an effect's usual size that a calibration leaves open: it is of another day.
constexpr double ages_by = 0.1;
/// A value within so many of its uncertainties may as well be none.
constexpr double doubtful = 2;

/// Collects what is known of one effect after the other.
class Knower {
 public:
  Knower(const Calibration& calibration, const ScanRecords& records, std::vector<Effect>& effects,
         std::vector<Tolerance>& limits)
      : calibration_(calibration),
        nm_(records.wavelengths_nm),
        solid_angle_sr_(records.solid_angle_sr),
        effects_(effects),
        limits_(limits) {}

  std::vector<KnownEffect> find(std::vector<std::string>& notes) {
    electronics();
    polarisation();
    stray();
    bench();
    std::vector<std::string> words;
    for (const KnownEffect& k : known_) {
      const Effect& effect = effects_[k.effect];
      for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
        if (effect.parameters[i].shape) continue;
        double mean = 0;
        for (const auto& value : k.value) mean += value[i] / static_cast<double>(k.value.size());
        if (mean != 0)
          words.push_back(
              fmt::format("{} {} {:.3g}", effect.name, effect.parameters[i].name, mean));
      }
    }
    if (!words.empty())
      notes.push_back(fmt::format(
          "the calibration's own values are in the simulation, and a cause says what goes beyond "
          "them: {} (means over the wavelengths)",
          fmt::join(words, ", ")));
    return std::move(known_);
  }

 private:
  Parameter& parameter(EffectId id, std::size_t i) { return effects_[number(id)].parameters[i]; }

  KnownEffect& entry(EffectId id) {
    for (KnownEffect& k : known_)
      if (k.effect == number(id)) return k;
    known_.push_back({number(id), {}});
    known_.back().value.assign(nm_.size(),
                               std::vector<double>(effects_[number(id)].parameters.size(), 0.0));
    return known_.back();
  }

  /// What is usual stays open where the calibration knows less than that.
  void narrow(EffectId id, std::size_t i, double u) {
    Parameter& p = parameter(id, i);
    p.prior_u = std::clamp(u, ages_by * p.prior_u, p.prior_u);
    limit(id, i, u);
  }

  /// What the calibration itself may be off by is no news.
  void limit(EffectId id, std::size_t i, double u) {
    if (u > 0)
      limits_.push_back({effects_[number(id)].name, parameter(id, i).name, u, doubtful * u, "", 0});
  }

  void know(EffectId id, std::size_t i, std::vector<double> value, double u) {
    Parameter& p = parameter(id, i);
    const bool one_sided = p.lo >= p.absent;
    if (one_sided)
      for (double& v : value) v = std::max(v, 0.0);
    narrow(id, i, u);
    for (double& v : value)
      if (std::abs(v) < doubtful * u) v = 0;
    if (std::all_of(value.begin(), value.end(), [](double v) { return v == 0; })) return;
    KnownEffect& k = entry(id);
    for (std::size_t w = 0; w < nm_.size(); ++w) k.value[w][i] = value[w];
    // Less than the calibration's value is possible too, down to none.
    if (one_sided) p.lo = -*std::min_element(value.begin(), value.end());
  }

  template <class Value>
  std::vector<double> by_wavelength(const Value& value) const {
    std::vector<double> result;
    for (const double nm : nm_) result.push_back(value(nm));
    return result;
  }

  template <class Value>
  double largest(const Value& value) const {
    double most = 0;
    for (const double nm : nm_) most = std::max(most, static_cast<double>(value(nm)));
    return most;
  }

  void electronics() {
    know(EffectId::lockin_phase, 0,
         by_wavelength([&](double nm) { return optics::degrees(calibration_.at(nm).phase_rad); }),
         largest([&](double nm) { return optics::degrees(calibration_.at(nm).phase_u_rad); }));
    std::size_t i = 0;
    for (const double range : {10.0, 100.0, 1000.0}) {
      const calibrate::RangeError error = calibration_.ranges.at(range);
      if (error.measured)
        know(EffectId::gain_ratio_error, i, std::vector<double>(nm_.size(), error.error), error.u);
      ++i;
    }
    const calibrate::Nonlinearity& law = calibration_.nonlinearity;
    if (law.measured)
      know(EffectId::detector_nonlinearity, 0, std::vector<double>(nm_.size(), law.kappa_per_v),
           law.kappa_u_per_v);
    double dark_u = 0;
    for (const calibrate::DarkLevel& level : calibration_.dark.levels)
      if (level.records > 0) dark_u = std::max(dark_u, level.x_u);
    if (dark_u > 0) narrow(EffectId::dark_offset, 0, dark_u);
  }

  void polarisation() {
    const auto bias_u = [&](double nm) {
      const calibrate::WavelengthCalibration& own = calibration_.at(nm);
      const Eigen::Index last = own.covariance.rows() - 1;
      return own.bias_active && last >= 0 ? std::sqrt(own.covariance(last, last))
                                          : own.detector_bias_u;
    };
    know(EffectId::detector_polarization_bias, 0, by_wavelength([&](double nm) {
           const calibrate::WavelengthCalibration& own = calibration_.at(nm);
           return own.bias_active ? own.detector_bias : 0.0;
         }),
         largest(bias_u));
    if (!calibration_.polarization) return;
    const auto element = [&](EffectId id, double PolarizationWavelength::*value,
                             double PolarizationWavelength::*u) {
      know(id, 0, by_wavelength([&](double nm) {
             const PolarizationWavelength* own = calibration_.polarization->find(nm);
             return own == nullptr ? 0.0 : own->*value;
           }),
           largest([&](double nm) {
             const PolarizationWavelength* own = calibration_.polarization->find(nm);
             return own == nullptr ? parameter(id, 0).prior_u : own->*u;
           }));
    };
    using P = PolarizationWavelength;
    element(EffectId::polarizer_leakage, &P::polarizer_extinction, &P::polarizer_extinction_u);
    element(EffectId::analyzer_leakage, &P::analyzer_extinction, &P::analyzer_extinction_u);
    element(EffectId::polarizer_rotation, &P::polarizer_axis_deg, &P::polarizer_axis_u_deg);
    element(EffectId::analyzer_rotation, &P::analyzer_axis_deg, &P::analyzer_axis_u_deg);
  }

  void stray() {
    const calibrate::StrayLight& s = calibration_.stray;
    if (s.empty()) return;
    const auto n = static_cast<Eigen::Index>(s.wavelength_nm.size());
    const auto level = [&](EffectId id, const std::vector<double>& values, Eigen::Index first) {
      bool all = true;
      for (const double nm : nm_) {
        const Eigen::Index i = s.number(nm);
        all = all && i >= 0 && s.measured[static_cast<std::size_t>(i)] != 0;
      }
      const auto value = by_wavelength([&](double nm) {
        const Eigen::Index i = s.number(nm);
        return i < 0 ? 0.0 : values[static_cast<std::size_t>(i)];
      });
      const double u = largest([&](double nm) {
        const Eigen::Index i = s.number(nm);
        return i < 0 ? 0.0 : std::sqrt(std::max(0.0, s.covariance(first + i, first + i)));
      });
      know(id, 0, value, all ? u : parameter(id, 0).prior_u);
    };
    level(EffectId::stray_light, s.even_per_sr, 0);
    level(EffectId::stray_forward, s.forward_per_sr, n);
    for (KnownEffect& k : known_)
      if (k.effect == number(EffectId::stray_forward))
        hold_shape(EffectId::stray_forward, 1, s.forward_width_deg, k);
  }

  /// What goes beyond a known level has the known shape.
  void hold_shape(EffectId id, std::size_t i, double value, KnownEffect& known) {
    Parameter& p = parameter(id, i);
    p.absent = p.lo = p.hi = value;
    for (auto& own : known.value) own[i] = value;
    auto& probes = effects_[number(id)].probes;
    probes.resize(1);
    for (Probe& probe : probes.front()) probe[i] = value;
  }

  /// Declared by whoever aligned the bench: they count as they stand.
  void bench() {
    const calibrate::DeclaredDoubts& d = calibration_.declared;
    const auto declare = [&](EffectId id, double u) {
      if (u > 0) parameter(id, 0).prior_u = u;
      limit(id, 0, u);
    };
    declare(EffectId::incidence_zero, d.theta_i_zero_u_deg);
    declare(EffectId::detector_zero, d.theta_r_zero_u_deg);
    declare(EffectId::sample_tilt_in_plane, d.sample_lean_u_deg);
    declare(EffectId::detector_eccentricity, d.theta_r_eccentricity_u_deg);
    declare(EffectId::backlash, d.theta_r_play_u_deg);
    const double half_angle_deg =
        d.aperture_half_angle_deg * std::sqrt(solid_angle_sr_ / calibration_.solid_angle_sr);
    if (half_angle_deg > 0)
      know(EffectId::finite_aperture, 0, std::vector<double>(nm_.size(), half_angle_deg),
           0.5 * d.solid_angle_relative_u * half_angle_deg);
  }

  const Calibration& calibration_;
  const std::vector<double>& nm_;
  double solid_angle_sr_;
  std::vector<Effect>& effects_;
  std::vector<Tolerance>& limits_;
  std::vector<KnownEffect> known_;
};

/// One standard deviation of ln C: the standard's own statistics and all that calibrations share.
double gain_u(const Calibration& calibration, std::size_t w) {
  const calibrate::WavelengthCalibration& own = calibration.wavelengths[w];
  double square = own.reference_relative_u * own.reference_relative_u +
                  calibration.declared.source_relative_u * calibration.declared.source_relative_u;
  if (own.covariance.rows() > 0) square += own.covariance(0, 0);
  if (calibration.polarization && own.polarization_shift.rows() > 0) {
    const Eigen::VectorXd shift = own.polarization_shift.row(0).transpose();
    square += shift.dot(calibration.polarization->block(w) * shift);
  }
  for (const calibrate::Systematic& s : calibration.systematics)
    if (w < s.shift.size() && s.shift[w].size() > 0) square += s.shift[w][0] * s.shift[w][0];
  return std::sqrt(square);
}

/// Q/I of the light behind an ideal polariser.
double share_of_s(const Record& r) {
  return r.polarizer_open ? 0.0 : -std::cos(2 * r.polarizer);
}

}  // namespace

std::vector<KnownEffect> know_effects(const Calibration& calibration, ScanRecords& records,
                                      std::vector<Effect>& effects,
                                      std::vector<Tolerance>& limits) {
  return Knower(calibration, records, effects, limits).find(records.notes);
}

void correct_records(const Calibration& calibration, ScanRecords& records) {
  for (std::size_t w = 0; w < records.wavelengths_nm.size(); ++w) {
    const std::size_t own = calibration.index_of(records.wavelengths_nm[w]);
    records.gain_constant_v[w] = calibration.wavelengths[own].gain_constant_v;
    records.gain_constant_relative_u[w] = gain_u(calibration, own);
  }
  const double shadow = optics::radians(calibration.retro_shadow_deg);
  std::size_t in_shadow = 0, beyond = 0;
  std::vector<Record> kept;
  kept.reserve(records.records.size());
  for (Record r : records.records) {
    const double cos_off = std::cos(r.theta_i) * std::cos(r.theta_r) -
                           std::sin(r.theta_i) * std::sin(r.theta_r) * std::cos(r.phi_r);
    if (shadow > 0 && std::acos(std::clamp(cos_off, -1.0, 1.0)) < shadow) {
      ++in_shadow;
      continue;
    }
    const double nm = records.wavelengths_nm[r.wavelength];
    const calibrate::DarkLevel dark = calibration.dark.at(r.gain);
    r.x_v -= dark.x_v;
    r.y_v -= dark.y_v;
    const calibrate::InstrumentFunction& function = calibration.at(nm).instrument_function;
    const double theta_r_deg = optics::degrees(r.theta_r);
    if (!function.covers(theta_r_deg)) ++beyond;
    // As if less light had come: what counts is its product with all else.
    r.monitor_v /= function.value(std::clamp(theta_r_deg, function.min_deg, function.max_deg));
    if (calibration.polarization) {
      const PolarizationWavelength* p = calibration.polarization->find(nm);
      if (p != nullptr) r.monitor_v /= 1 + p->monitor_bias * share_of_s(r);
    }
    kept.push_back(r);
  }
  records.records = std::move(kept);
  if (in_shadow > 0)
    records.notes.push_back(fmt::format(
        "{} records within {:g} deg of the way back to the source are left out: the calibration "
        "saw the detector's shadow there",
        in_shadow, calibration.retro_shadow_deg));
  if (beyond > 0)
    records.notes.push_back(
        fmt::format("{} records lie beyond the angles of the white standard: the instrument "
                    "function is held at its edge there",
                    beyond));
}

}  // namespace umov::gap::scan
