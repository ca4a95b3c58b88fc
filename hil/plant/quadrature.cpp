#include "hil/plant/quadrature.hpp"

#include <cmath>
#include <cstddef>
#include <map>
#include <mutex>

#include "host/optics/angles.hpp"

namespace umov::plant {
namespace {

QuadratureRule make_rule(int order) {
  QuadratureRule rule;
  rule.node.resize(static_cast<std::size_t>(order));
  rule.weight.resize(static_cast<std::size_t>(order));
  for (int i = 0; i < order; ++i) {
    double x = std::cos(optics::pi * (i + 0.75) / (order + 0.5));
    double slope = 1.0;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double previous = 1.0;
      double value = x;
      for (int k = 2; k <= order; ++k) {
        const double next = ((2 * k - 1) * x * value - (k - 1) * previous) / k;
        previous = value;
        value = next;
      }
      if (order == 1) previous = 1.0;
      slope = order * (x * value - previous) / (x * x - 1.0);
      const double dx = value / slope;
      x -= dx;
      if (std::abs(dx) < 1e-15) break;
    }
    const auto at = static_cast<std::size_t>(order - 1 - i);
    rule.node[at] = 0.5 * (1.0 + x);
    rule.weight[at] = 1.0 / ((1.0 - x * x) * slope * slope);
  }
  return rule;
}

}  // namespace

const QuadratureRule& gauss_legendre(int order) {
  static std::mutex mutex;
  static std::map<int, QuadratureRule> rules;
  const std::scoped_lock lock(mutex);
  auto found = rules.find(order);
  if (found == rules.end()) found = rules.emplace(order, make_rule(order)).first;
  return found->second;
}

}  // namespace umov::plant
