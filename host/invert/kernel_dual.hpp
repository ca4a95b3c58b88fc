// Definition of dual_pass for the source files that instantiate it.
#pragma once

#include <ceres/jet.h>

#include <array>
#include <vector>

#include "host/brdf/evaluate.hpp"
#include "host/invert/kernel_pass.hpp"
#include "host/optics/mueller.hpp"

namespace umov::invert {

template <int Size>
void dual_pass(const brdf::Model& model, std::span<const double> parameters,
               std::span<const int> active, double wavelength_um, const View& view,
               std::span<const Channel> channels, std::span<double> f, double* derivatives,
               std::size_t stride) {
  using Dual = ceres::Jet<double, Size>;
  std::vector<Dual> dual(parameters.begin(), parameters.end());
  for (std::size_t a = 0; a < active.size(); ++a) {
    dual[static_cast<std::size_t>(active[a])].v[static_cast<Eigen::Index>(a)] = 1;
  }
  const std::span<const Dual> values(dual);
  optics::Mueller<Dual> mueller = brdf::evaluate(model, values, wavelength_um, view.geometry);
  if (view.mirror_per_sr > 0) {
    mueller += brdf::mirror_reflectance(model, values, wavelength_um, view.geometry.theta_i) *
               Dual(view.mirror_per_sr);
  }
  for (std::size_t c = 0; c < channels.size(); ++c) {
    Dual sum(0.0);
    for (std::size_t i = 0; i < 16; ++i) {
      const double weight = channels[c].weight[i];
      if (weight == 0) continue;
      sum += optics::element(mueller, static_cast<int>(i / 4), static_cast<int>(i % 4)) * weight;
    }
    f[c] = sum.a;
    for (std::size_t a = 0; a < active.size(); ++a) {
      derivatives[c * stride + a] = sum.v[static_cast<Eigen::Index>(a)];
    }
  }
}

}  // namespace umov::invert
