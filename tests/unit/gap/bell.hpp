// The smallest measurement with everything that the engine asks for: a bell-shaped peak.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "host/gap/engine/forward_model.hpp"

namespace umov::gap {

/// A bell scanned twenty times under two settings in turn: its height and width are fitted, its
/// place may be off, a constant may be added.
class Bell final : public ForwardModel {
 public:
  explicit Bell(std::uint64_t seed) {
    height_and_width_ = {{"height", "1", "", 1.0, 0.5, 2.0}, {"width", "1", "", 1.0, 0.5, 2.0}};
    Effect zero{
        "zero", "geometry", "the bell is elsewhere", "-", {{"zero", "1", "", 0, -1, 1, 0.01}}};
    Effect offset{"offset", "detector", "a constant", "-", {{"offset", "1", "", 0, -1, 1, 0.01}}};
    zero.probes = {{{0.002}}};
    offset.probes = {{{0.002}}};
    effects_ = {zero, offset};
    Circumstance time{{"time", "1", {}}}, setting{{"setting", "1", {}}},
        place{{"place", "1", {}}, true, "geometry"};
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    constexpr int rows = 20, points = 61;
    seen_.value.resize(rows * points);
    for (int i = 0; i < rows * points; ++i) {
      place.axis.value.push_back(-3 + 0.1 * (i % points));
      time.axis.value.push_back(static_cast<double>(i) / (rows * points));
      setting.axis.value.push_back((i / points) % 2);
      seen_.row.push_back(i / points);
      seen_.channel.push_back(0);
      noise_.push_back(sigma * normal(random));
    }
    seen_.channels = {"all"};
    seen_.axes = {place.axis, time.axis};
    seen_.circumstances = {time, setting, place};
    measure([](double, double, double) { return 0.0; });
  }

  /// The bell's place is off by `zero` of time, setting and place.
  template <class F>
  void measure(const F& zero) {
    for (Eigen::Index i = 0; i < seen_.value.size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const auto& c = seen_.circumstances;
      const double off = zero(c[0].axis.value[k], c[1].axis.value[k], c[2].axis.value[k]);
      seen_.value[i] = bell(place(i) - off, 1, 1) + noise_[k];
    }
  }
  /// Multiplies what was measured.
  template <class F>
  void modulate(const F& factor) {
    for (Eigen::Index i = 0; i < seen_.value.size(); ++i)
      seen_.value[i] += (factor(i) - 1) * bell(place(i), 1, 1);
  }

  const Observations& observations() const override { return seen_; }
  const std::vector<Parameter>& base() const override { return height_and_width_; }
  const std::vector<Effect>& effects() const override { return effects_; }
  void predict(const Explanation& e, Eigen::VectorXd& mean, Eigen::MatrixXd* jacobian,
               const std::vector<bool>&) const override {
    double alpha[2] = {0, 0};
    for (std::size_t k = 0; k < e.effects.size(); ++k) alpha[e.effects[k]] = e.alpha[k][0];
    mean.resize(seen_.value.size());
    if (jacobian != nullptr)
      jacobian->resize(mean.size(), 2 + static_cast<Eigen::Index>(e.effects.size()));
    for (Eigen::Index i = 0; i < mean.size(); ++i) {
      const double x = place(i) - alpha[0], w = e.base[1];
      const double shape = bell(x, 1, w);
      mean[i] = e.base[0] * shape + alpha[1];
      if (jacobian == nullptr) continue;
      (*jacobian)(i, 0) = shape;
      (*jacobian)(i, 1) = e.base[0] * shape * x * x / (w * w * w);
      for (std::size_t k = 0; k < e.effects.size(); ++k)
        (*jacobian)(i, 2 + static_cast<Eigen::Index>(k)) =
            e.effects[k] == 0 ? e.base[0] * shape * x / (w * w) : 1.0;
    }
  }
  NoiseShape noise(const Eigen::VectorXd& mean) const override {
    NoiseShape shape{Eigen::VectorXd::Constant(mean.size(), sigma), mean, {}};
    for (Eigen::Index i = 0; i < mean.size(); ++i) shape.order.push_back(i);
    return shape;
  }

  static constexpr double sigma = 0.003;

 private:
  static double bell(double x, double height, double width) {
    return height * std::exp(-0.5 * x * x / (width * width));
  }
  double place(Eigen::Index i) const {
    return seen_.circumstances[2].axis.value[static_cast<std::size_t>(i)];
  }

  Observations seen_;
  std::vector<Parameter> height_and_width_;
  std::vector<Effect> effects_;
  std::vector<double> noise_;
};

}  // namespace umov::gap
