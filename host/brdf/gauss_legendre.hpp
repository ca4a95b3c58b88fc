// Gauss-Legendre nodes, computed once for each order.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "host/optics/angles.hpp"

namespace umov::brdf {

template <std::size_t order>
struct GaussLegendre {
  std::array<double, order> node, weight;  ///< on [0, 1]

  GaussLegendre() {
    constexpr auto count = static_cast<double>(order);
    for (std::size_t i = 0; i < order; ++i) {
      double x = std::cos(optics::pi * (static_cast<double>(i) + 0.75) / (count + 0.5));
      double derivative = 0.0;
      for (int step = 0; step < 100; ++step) {  // Newton on the Legendre polynomial
        double previous = 1.0, value = x;
        for (std::size_t k = 2; k <= order; ++k) {
          const auto n = static_cast<double>(k);
          const double next = ((2.0 * n - 1.0) * x * value - (n - 1.0) * previous) / n;
          previous = value;
          value = next;
        }
        derivative = count * (x * value - previous) / (x * x - 1.0);
        const double change = value / derivative;
        x -= change;
        if (std::abs(change) < 1e-16) break;
      }
      node[i] = 0.5 * (1.0 - x);
      weight[i] = 1.0 / ((1.0 - x * x) * derivative * derivative);
    }
  }

  static const GaussLegendre& instance() {
    static const GaussLegendre nodes;
    return nodes;
  }
};

}  // namespace umov::brdf
