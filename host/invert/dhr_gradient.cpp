#include "host/invert/dhr_gradient.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "host/invert/kernel.hpp"
#include "host/optics/angles.hpp"

namespace umov::invert {
namespace {

struct Node {
  double position, weight;
};
/// Gauss-Legendre on (−1, 1).
constexpr std::array<Node, 5> nodes{{{-0.906179845938664, 0.236926885056189},
                                     {-0.538469310105683, 0.478628670499366},
                                     {0.0, 0.568888888888889},
                                     {0.538469310105683, 0.478628670499366},
                                     {0.906179845938664, 0.236926885056189}}};
/// Rings about the mirror direction, radians: the narrowest lobe of the library is 0.004 wide.
constexpr std::array<double, 12> rings{0,   5e-4, 2e-3, 6e-3, 0.02, 0.05,
                                       0.1, 0.2,  0.4,  0.8,  1.6,  optics::pi};
constexpr int sectors = 10;  // of the half turn; the other half is its mirror image

}  // namespace

Eigen::VectorXd dhr_gradient(const Layout& layout, std::span<const double> x,
                             std::size_t wavelength, double theta_i, double* value) {
  const std::vector<double> parameters = layout.values(wavelength, x);
  const auto& active = layout.active(wavelength);
  const std::array<Channel, 1> open{channel_unpolarized()};
  std::vector<double> sum(active.size(), 0.0), derivative(active.size());
  std::array<double, 1> f{};
  double total = 0;
  const auto add = [&](const View& view, double weight) {
    evaluate_channels(layout.model(), parameters, active, layout.wavelength_um(wavelength), view,
                      open, f, derivative);
    total += weight * f[0];
    for (std::size_t a = 0; a < active.size(); ++a) sum[a] += weight * derivative[a];
  };
  const double cos_i = std::cos(theta_i), sin_i = std::sin(theta_i);
  for (std::size_t ring = 0; ring + 1 < rings.size(); ++ring) {
    const double middle = 0.5 * (rings[ring] + rings[ring + 1]);
    const double half = 0.5 * (rings[ring + 1] - rings[ring]);
    for (const Node& node : nodes) {
      const double alpha = middle + half * node.position;
      for (int sector = 0; sector < sectors; ++sector) {
        const double psi = optics::pi * (sector + 0.5) / sectors;
        // The mirror direction turned by alpha towards psi: 0 is farther from the normal.
        const double forward = std::sin(alpha) * std::cos(psi);
        const double exit_x = sin_i * std::cos(alpha) + cos_i * forward;
        const double exit_y = std::sin(alpha) * std::sin(psi);
        const double exit_z = cos_i * std::cos(alpha) - sin_i * forward;
        if (exit_z <= 1e-6) continue;
        const View view{
            {theta_i, std::atan2(std::hypot(exit_x, exit_y), exit_z), std::atan2(exit_y, exit_x)}};
        add(view, 2 * exit_z * std::sin(alpha) * node.weight * half * optics::pi / sectors);
      }
    }
  }
  // The mirror part alone: a view that has it minus one that has not.
  const View at_mirror{{theta_i, theta_i, 0.0}};
  View with_mirror = at_mirror;
  with_mirror.mirror_per_sr = 1;
  add(with_mirror, 1);
  add(at_mirror, -1);

  if (value != nullptr) *value = total;
  Eigen::VectorXd by_x = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(layout.size()));
  for (std::size_t a = 0; a < active.size(); ++a) {
    const std::size_t free = *layout.slot(wavelength, static_cast<std::size_t>(active[a]));
    by_x[static_cast<Eigen::Index>(free)] = sum[a] * layout.free()[free].coordinate.slope(x[free]);
  }
  return by_x;
}

}  // namespace umov::invert
