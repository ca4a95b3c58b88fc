#include "host/brdf/li_torrance.hpp"

#include <algorithm>
#include <numbers>

#include "host/brdf/gauss_legendre.hpp"
#include "host/brdf/gradient.hpp"

namespace umov::brdf {
namespace {

/// The last few results, by exact argument.
class Recent {
 public:
  template <class Compute>
  Normalisation get(double x, double y, Compute compute) {
    for (const Entry& entry : entries_) {
      if (entry.used && entry.x == x && entry.y == y) return entry.result;
    }
    Entry& entry = entries_[next_];
    next_ = (next_ + 1) % entries_.size();
    entry = {true, x, y, compute()};
    return entry.result;
  }

 private:
  struct Entry {
    bool used = false;
    double x = 0.0, y = 0.0;
    Normalisation result{};
  };
  std::array<Entry, 8> entries_{};
  std::size_t next_ = 0;
};

Normalisation integrate_transmittance(double n, double kappa) {
  using Scalar = Gradient<2>;
  const auto& nodes = GaussLegendre<40>::instance();
  const Scalar index(n, 0), absorption(kappa, 1);
  Scalar sum(0.0);
  // In μ = cos θ. q = √(n² - 1 + μ²) bends like a square root where μ² passes |n² - 1| (for n < 1
  // total reflection ends there): substituting t² for the distance from there makes both sides
  // smooth.
  const double bend = std::clamp(std::sqrt(std::abs(n * n - 1.0)), 0.0, 1.0);
  for (const double end : {0.0, 1.0}) {
    const double length = end - bend;
    for (std::size_t i = 0; i < nodes.node.size(); ++i) {
      const double t = nodes.node[i];
      const double mu = bend + length * t * t;
      const double measure = 2.0 * t * std::abs(length) * nodes.weight[i];
      sum = sum + 2.0 * mu * measure * optics::transmittance(index, absorption, Scalar(mu));
    }
  }
  return {sum.a, {sum.v[0], sum.v[1]}};
}

Normalisation integrate_forward_lobe(double width) {
  const auto& nodes = GaussLegendre<64>::instance();
  const double end = std::min(0.5 * optics::pi, 9.0 * width);
  double value = 0.0, by_width = 0.0;
  for (std::size_t i = 0; i < nodes.node.size(); ++i) {
    const double theta = end * nodes.node[i];
    const double ratio = theta / width;
    const double term =
        end * nodes.weight[i] * std::exp(-0.5 * ratio * ratio) * std::sin(2.0 * theta);
    value += term;
    by_width += term * ratio * ratio / width;
  }
  return {optics::pi * value, {optics::pi * by_width, 0.0}};
}

}  // namespace

Normalisation diffuse_transmittance(double n, double kappa) {
  thread_local Recent recent;
  return recent.get(n, kappa, [&] { return integrate_transmittance(n, kappa); });
}

Normalisation forward_lobe_norm(double width) {
  thread_local Recent recent;
  return recent.get(width, 0.0, [&] { return integrate_forward_lobe(width); });
}

}  // namespace umov::brdf
