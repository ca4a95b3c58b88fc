// The only place where the model library meets dual numbers: BRDF in given polarisation channels
// and its exact derivatives by the model's parameters.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "host/brdf/facet.hpp"
#include "host/brdf/model.hpp"

namespace umov::invert {

/// Weights of the sixteen Mueller elements, row by row: analyser (row) times source (column).
struct Channel {
  std::array<double, 16> weight{};
};
/// Unpolarised light, no analyser: m00 alone.
inline Channel channel_unpolarized() {
  Channel channel;
  channel.weight[0] = 1;
  return channel;
}

/// Directions, in radians, and what a mirror part of the model adds there: 1/(cos θr ΔΩ) where the
/// instrument's aperture takes in the mirror direction, else 0.
struct View {
  brdf::Geometry<double> geometry;
  double mirror_per_sr = 0;
};

/// f[c] of each channel in 1/sr, and, where `derivatives` is not empty,
/// derivatives[c * active.size() + a] = df[c]/dp[active[a]]. `parameters` in the model's order,
/// wavelength in micrometres.
void evaluate_channels(const brdf::Model& model, std::span<const double> parameters,
                       std::span<const int> active, double wavelength_um, const View& view,
                       std::span<const Channel> channels, std::span<double> f,
                       std::span<double> derivatives);

}  // namespace umov::invert
