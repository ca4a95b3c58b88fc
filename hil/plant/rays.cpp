#include "hil/plant/rays.hpp"

#include <cmath>
#include <cstddef>

#include "hil/plant/quadrature.hpp"

namespace umov::plant {

Beam tilted(const Beam& beam, double angle, double turn) {
  const Vec3 k = std::cos(angle) * beam.k +
                 std::sin(angle) * (std::cos(turn) * beam.s + std::sin(turn) * beam.p);
  Vec3 s = beam.s - optics::dot(beam.s, k) * k;
  s *= 1.0 / std::sqrt(optics::dot(s, s));
  return {s, optics::cross(k, s), k};
}

namespace {

void add_ring(std::vector<Ray>& rays, const Beam& beam, double angle, double weight, int count,
              double first_turn) {
  for (int i = 0; i < count; ++i) {
    const double turn = first_turn + 2.0 * optics::pi * i / count;
    rays.push_back({tilted(beam, angle, turn), weight / count});
  }
}

}  // namespace

std::vector<Ray> disc_rays(const Beam& beam, double half_angle) {
  if (half_angle <= 0.0) return {{beam, 1.0}};
  const bool wide = half_angle > 0.01;
  const QuadratureRule& rule = gauss_legendre(wide ? 4 : 2);
  const int per_ring = wide ? 10 : 6;
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    const double cosine = 1.0 - (1.0 - std::cos(half_angle)) * rule.node[i];
    const double turn = optics::pi * static_cast<double>(i % 2) / per_ring;
    add_ring(rays, beam, std::acos(cosine), rule.weight[i], per_ring, turn);
  }
  return rays;
}

std::vector<Ray> gaussian_rays(const Beam& beam, double rms) {
  if (rms <= 0.0) return {{beam, 1.0}};
  std::vector<Ray> rays;
  if (rms <= 0.002) {
    add_ring(rays, beam, std::sqrt(2.0) * rms, 1.0, 4, 0.25 * optics::pi);
    return rays;
  }
  // Gauss–Laguerre of order 2 in r²/2rms².
  const double root = std::sqrt(2.0);
  add_ring(rays, beam, rms * std::sqrt(2.0 * (2.0 - root)), (2.0 + root) / 4.0, 6, 0.0);
  add_ring(rays, beam, rms * std::sqrt(2.0 * (2.0 + root)), (2.0 - root) / 4.0, 6,
           optics::pi / 6.0);
  return rays;
}

}  // namespace umov::plant
