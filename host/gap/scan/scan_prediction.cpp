// What a scan's records should read, and how that changes with each parameter.
#include "host/gap/scan/scan_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include <ceres/jet.h>

#include "host/gap/scan/chain.hpp"
#include "host/gap/scan/effects/free_form.hpp"

namespace umov::gap::scan {
namespace {

/// Derivatives carried by one pass of the chain.
constexpr int lanes = 8;
using Dual = ceres::Jet<double, lanes>;

}  // namespace

template <class T, class A>
void ScanModel::evaluate(const Explanation& explanation, const std::vector<T>& values,
                         const std::vector<A>& angles, std::size_t record, T& x, T& y,
                         bool bent) const {
  const std::size_t wavelengths = source_.size();
  const std::size_t parameters = held_.size();
  const Record& r = records_.records[record];
  // The other wavelengths matter to effects that mix them only.
  bool mixes = false;
  Switched<T> on;
  Switched<A> bending;
  on.wavelengths = bending.wavelengths = wavelengths;
  std::size_t next = base_.size();
  for (std::size_t k = 0; k < explanation.effects.size(); ++k) {
    on.values[explanation.effects[k]] = &values[next];
    bending.values[explanation.effects[k]] = &angles[next];
    next += explanation.alpha[k].size();
    mixes = mixes || explanation.effects[k] == number(EffectId::laser_crosstalk) ||
            explanation.effects[k] == number(EffectId::wavelength_error);
  }
  // Behind the parameters: what is added to the sum of each series.
  for (std::size_t s = 0; next + s < values.size(); ++s) on.lift[s] = &values[next + s];
  std::array<Material<T>, most_wavelengths> materials{};
  thread_local std::vector<T> own;
  own.resize(wavelengths * parameters);
  for (std::size_t w = 0; w < wavelengths; ++w) {
    if (!mixes && w != r.wavelength) continue;
    for (std::size_t i = 0; i < parameters; ++i) {
      const int from = source_[w][i];
      T& value = own[w * parameters + i];
      if (from < 0) {
        value = T(held_[i]);
      } else {
        const T& given = values[static_cast<std::size_t>(from)];
        using std::sqrt;
        value = squared_[static_cast<std::size_t>(from)] ? T(sqrt(given)) : given;
      }
    }
  }
  for (std::size_t w = 0; w < wavelengths; ++w)
    materials[w] = {&model_, std::span<const T>(own).subspan(w * parameters, parameters),
                    records_.wavelengths_nm[w] * 1e-3, w, lobe_};
  thread_local std::vector<T> known_values;
  thread_local std::vector<A> known_angles;
  add_known(known_, effects_, r.wavelength, on, known_values);
  add_known(known_, effects_, r.wavelength, bending, known_angles);
  const ChainBase<T> base{std::span<const Material<T>>(materials).first(wavelengths),
                          std::span<const T>(values).first(wavelengths), records_.gain_constant_v,
                          records_.solid_angle_sr};
  const Lockin<T> out = record_signal(r, base, bent, on, bending);
  x = out.x;
  y = out.y;
}

void ScanModel::predict(const Explanation& explanation, Eigen::VectorXd& mean,
                        Eigen::MatrixXd* jacobian, const std::vector<bool>& wanted) const {
  const auto n = static_cast<Eigen::Index>(used_.size());
  std::vector<double> values = explanation.base;
  std::vector<bool> fitted(values.size(), true), turns(values.size(), false);
  bool bent = known_bends_;
  for (std::size_t k = 0; k < explanation.effects.size(); ++k) {
    const auto id = static_cast<EffectId>(explanation.effects[k]);
    const bool turning = moves_pose(id);
    bent = bent || changes_geometry(id);
    // A rotated polariser needs the pose, not bent directions.
    const auto& declared = effects_[explanation.effects[k]].parameters;
    for (std::size_t i = 0; i < declared.size(); ++i) {
      values.push_back(explanation.alpha[k][i]);
      fitted.push_back(!declared[i].choice);
      turns.push_back(turning);
    }
  }
  mean.resize(2 * n);
  if (jacobian == nullptr) {
    for (Eigen::Index i = 0; i < n; ++i)
      evaluate(explanation, values, values, used_[static_cast<std::size_t>(i)], mean[i],
               mean[n + i], bent);
    return;
  }
  jacobian->setZero(2 * n, static_cast<Eigen::Index>(values.size()));
  const std::size_t wavelengths = source_.size();
  const std::size_t parameters = values.size();
  bool mixes = false;
  for (const std::size_t e : explanation.effects)
    mixes =
        mixes || e == number(EffectId::laser_crosstalk) || e == number(EffectId::wavelength_error);
  const auto is_free = [this](int i) {
    const Parameter& p = base_[static_cast<std::size_t>(i)];
    return p.lo < p.hi;
  };
  // The coefficients of a series act by its sum alone: one derivative, to what is added to the sum,
  // serves them all.
  const std::vector<SeriesColumns> series = series_of(explanation);
  std::vector<bool> in_series(parameters, false);
  for (const SeriesColumns& s : series)
    for (std::size_t i = 0; i < s.columns; ++i) in_series[s.first + i] = true;
  values.resize(parameters + (series.empty() ? 0 : series_count), 0.0);
  // Parameters that a record of each wavelength depends on; those that turn angles come last: only
  // they need angles with derivatives.
  std::vector<std::vector<std::size_t>> active(wavelengths);
  std::vector<std::size_t> own_of(wavelengths);
  for (std::size_t w = 0; w < wavelengths; ++w) {
    std::vector<bool> there(parameters, false);
    there[w] = true;
    for (std::size_t v = 0; v < wavelengths; ++v)
      if (mixes || v == w)
        for (const int from : source_[v])
          if (from >= 0) there[static_cast<std::size_t>(from)] = is_free(from);
    for (std::size_t i = base_.size(); i < parameters; ++i) there[i] = fitted[i] && !in_series[i];
    for (std::size_t i = 0; i < parameters; ++i)
      if (there[i] && (wanted.empty() || wanted[i])) active[w].push_back(i);
    for (const SeriesColumns& s : series)
      if (wanted.empty() || wanted[s.first])
        active[w].push_back(parameters + static_cast<std::size_t>(s.id));
    const auto first_turning =
        std::stable_partition(active[w].begin(), active[w].end(),
                              [&](std::size_t i) { return i >= parameters || !turns[i]; });
    own_of[w] = static_cast<std::size_t>(first_turning - active[w].begin());
  }
  std::vector<Dual> dual(values.size());
  std::vector<Term> terms(most_terms);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t record = used_[static_cast<std::size_t>(i)];
    const Record& r = records_.records[record];
    const auto& list = active[r.wavelength];
    const std::size_t own = own_of[r.wavelength];
    if (list.empty()) {
      evaluate(explanation, values, values, record, mean[i], mean[n + i], bent);
      continue;
    }
    for (std::size_t first = 0; first < list.size();) {
      const std::size_t last = std::min(first < own ? own : list.size(), first + lanes);
      for (std::size_t k = 0; k < values.size(); ++k) dual[k] = Dual(values[k]);
      for (std::size_t k = first; k < last; ++k)
        dual[list[k]].v[static_cast<Eigen::Index>(k - first)] = 1;
      Dual x, y;
      if (first < own) {
        evaluate(explanation, dual, values, record, x, y, bent);
      } else {
        evaluate(explanation, dual, dual, record, x, y, bent);
      }
      mean[i] = x.a;
      mean[n + i] = y.a;
      for (std::size_t k = first; k < last; ++k) {
        const double by_x = x.v[static_cast<Eigen::Index>(k - first)];
        const double by_y = y.v[static_cast<Eigen::Index>(k - first)];
        if (list[k] < parameters) {
          (*jacobian)(i, static_cast<Eigen::Index>(list[k])) = by_x;
          (*jacobian)(n + i, static_cast<Eigen::Index>(list[k])) = by_y;
          continue;
        }
        const SeriesColumns& s = *std::find_if(series.begin(), series.end(), [&](const auto& c) {
          return parameters + static_cast<std::size_t>(c.id) == list[k];
        });
        // At the commanded angles: what bends them is small against a term's width.
        const Series& declared = all_series[static_cast<std::size_t>(s.id)];
        const std::span<Term> used = std::span<Term>(terms).first(declared.terms);
        series_basis(s.id, slope_at(values, r.wavelength), facet_frames_[record], used);
        const std::size_t column =
            s.first + (declared.spectral ? r.wavelength * declared.terms : 0);
        for (std::size_t j = 0; j < declared.terms; ++j) {
          (*jacobian)(i, static_cast<Eigen::Index>(column + j)) = by_x * used[j].value;
          (*jacobian)(n + i, static_cast<Eigen::Index>(column + j)) = by_y * used[j].value;
        }
      }
      first = last;
    }
  }
}

std::vector<ScanModel::SeriesColumns> ScanModel::series_of(const Explanation& explanation) const {
  std::vector<SeriesColumns> found;
  std::size_t next = base_.size();
  for (std::size_t k = 0; k < explanation.effects.size(); ++k) {
    for (const Series& s : all_series)
      if (number(s.effect) == explanation.effects[k])
        found.push_back({s.id, next + s.first, s.terms * (s.spectral ? source_.size() : 1)});
    next += explanation.alpha[k].size();
  }
  return found;
}

double ScanModel::slope_at(const std::vector<double>& values, std::size_t wavelength) const {
  if (lobe_ < 0) return 1.0;
  const std::size_t slope = static_cast<std::size_t>(lobe_) + 2;
  const int from = source_[wavelength][slope];
  return from < 0 ? held_[slope] : values[static_cast<std::size_t>(from)];
}

}  // namespace umov::gap::scan
