#include "host/invert/fitted_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/errors/error.hpp"
#include "host/invert/layout.hpp"
#include "host/invert/observations.hpp"
#include "host/invert/posterior.hpp"

namespace umov::invert {

FittedModel::FittedModel(const formats::FitResult& fit)
    : model_(brdf::Model::by_name(fit.model)), wavelengths_nm_(fit.wavelengths_nm) {
  const auto& list = model_.parameters();
  const formats::FitResult::Covariance& known = fit.covariance;
  const auto size = static_cast<Eigen::Index>(known.names.size());
  const auto at = [](Eigen::Index i) { return static_cast<std::size_t>(i); };

  Eigen::VectorXd slope = Eigen::VectorXd::Ones(size);
  if (!known.coordinates.empty()) {
    for (Eigen::Index i = 0; i < size; ++i) {
      const auto& k = known.coordinates[at(i)];
      slope[i] = Coordinate{scale_named(k.scale), 0, 1}.slope(k.at);
    }
  }
  covariance_.resize(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) {
      covariance_(i, j) = known.values[at(i * size + j)] / (slope[i] * slope[j]);
    }
  }
  if (!known.coordinates.empty()) {
    Eigen::VectorXd centre(size), lo(size), hi(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      const auto& k = known.coordinates[at(i)];
      centre[i] = k.centre;
      lo[i] = k.lo - k.at;
      hi[i] = k.hi - k.at;
    }
    std::vector<Hinge> hinges;
    for (const auto& order : known.orders) {
      hinges.push_back({order.value, Eigen::Map<const Eigen::VectorXd>(order.slope.data(), size)});
    }
    profile_ = LimitedProfile(covariance_, centre, lo, hi, hinges);
  }

  for (std::size_t w = 0; w < wavelengths_nm_.size(); ++w) {
    values_.emplace_back();
    active_.emplace_back();
    const std::string suffix = " " + wavelength_text(wavelengths_nm_[w]) + " nm";
    for (std::size_t p = 0; p < list.size(); ++p) {
      const formats::FitParameter* found = fit.find(list[p].name);
      if (found == nullptr) {
        throw Error("the fit has no parameter \"" + list[p].name + "\" of model " + model_.name(),
                    "fit again with this version");
      }
      values_.back().push_back(found->at(w).value);
      for (Eigen::Index row = 0; row < size; ++row) {
        const std::string& name = known.names[at(row)];
        if (name != list[p].name && name != list[p].name + suffix) continue;
        active_.back().parameters.push_back(static_cast<int>(p));
        active_.back().rows.push_back(row);
        active_.back().slopes.push_back(slope[row]);
        // At a limit the value in the file is the limit's; derivatives belong to the point at
        // which the fit stood.
        if (!known.coordinates.empty()) {
          const auto& k = known.coordinates[at(row)];
          values_.back().back() =
              Coordinate{scale_named(k.scale), list[p].min, list[p].max}.to_parameter(k.at);
        }
      }
    }
  }
}

bool FittedModel::has_wavelength(double nm) const {
  return std::any_of(wavelengths_nm_.begin(), wavelengths_nm_.end(),
                     [nm](double own) { return std::abs(own - nm) < 0.01; });
}

std::size_t FittedModel::wavelength(double nm) const {
  std::string known;
  for (std::size_t w = 0; w < wavelengths_nm_.size(); ++w) {
    if (std::abs(wavelengths_nm_[w] - nm) < 0.01) return w;
    known += (known.empty() ? "" : ", ") + wavelength_text(wavelengths_nm_[w]);
  }
  throw Error("the fit has no wavelength " + wavelength_text(nm) + " nm",
              "it was made at " + known + " nm");
}

double FittedModel::value(std::size_t wavelength, const View& view, const Channel& channel) const {
  double f = 0;
  evaluate_channels(model_, values_[wavelength], {}, wavelengths_nm_[wavelength] * 1e-3, view,
                    std::span(&channel, 1), std::span(&f, 1), {});
  return f;
}

Eigen::MatrixXd FittedModel::gradients(std::size_t wavelength, const View& view,
                                       std::span<const Channel> channels,
                                       std::span<double> f) const {
  const Active& active = active_[wavelength];
  const std::size_t count = active.parameters.size();
  std::vector<double> by(channels.size() * count);
  evaluate_channels(model_, values_[wavelength], active.parameters,
                    wavelengths_nm_[wavelength] * 1e-3, view, channels, f, by);
  Eigen::MatrixXd out =
      Eigen::MatrixXd::Zero(covariance_.rows(), static_cast<Eigen::Index>(channels.size()));
  for (std::size_t c = 0; c < channels.size(); ++c) {
    for (std::size_t a = 0; a < count; ++a) {
      out(active.rows[a], static_cast<Eigen::Index>(c)) = by[c * count + a] * active.slopes[a];
    }
  }
  return out;
}

Predicted FittedModel::predicted(double value, const Eigen::VectorXd& by_x) const {
  const Interval interval = interval_95(profile_, covariance_, value, by_x);
  return {value, std::sqrt(std::max(0.0, by_x.dot(covariance_ * by_x))), interval.lo, interval.hi};
}

Predicted FittedModel::brdf(std::size_t wavelength, const View& view,
                            const Channel& channel) const {
  double f = 0;
  const Eigen::MatrixXd by = gradients(wavelength, view, std::span(&channel, 1), std::span(&f, 1));
  Predicted out = predicted(f, by.col(0));
  out.lo = std::max(out.lo, 0.0);
  return out;
}

Predicted FittedModel::dolp(std::size_t wavelength, const View& view) const {
  const std::array channels{channel_of(0, 0), channel_of(0, 90)};
  std::array<double, 2> f{};
  const Eigen::MatrixXd by = gradients(wavelength, view, channels, f);
  const double sum = f[0] + f[1];
  if (!(sum > 0)) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan, nan, nan};
  }
  // d((a − b)/(a + b)) = 2 (b da − a db)/(a + b)².
  const Eigen::VectorXd gradient = 2 * (f[1] * by.col(0) - f[0] * by.col(1)) / (sum * sum);
  Predicted out = predicted((f[0] - f[1]) / sum, gradient);
  out.lo = std::max(out.lo, -1.0);
  out.hi = std::min(out.hi, 1.0);
  return out;
}

double FittedModel::sigma(std::size_t wavelength, const View& view, const Channel& channel,
                          double& value) const {
  const Eigen::VectorXd by =
      gradients(wavelength, view, std::span(&channel, 1), std::span(&value, 1)).col(0);
  return std::sqrt(std::max(0.0, by.dot(covariance_ * by)));
}

}  // namespace umov::invert
