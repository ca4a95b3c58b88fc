#include "host/chamber/source_choice.hpp"

#include <algorithm>
#include <cmath>

namespace umov::chamber {

SourceChoice::SourceChoice(const std::vector<Emitter>& emitters) {
  double flux = 0.0;
  for (const Emitter& emitter : emitters) flux += emitter.flux_lm;
  double sum = 0.0;
  for (const Emitter& emitter : emitters) {
    sum += emitter.flux_lm;
    flux_up_to_.push_back(flux > 0.0 ? sum / flux : 1.0);
  }
  if (emitters.size() > most_weighed) return;
  for (std::size_t i = 0; i < emitters.size(); ++i) {
    const Emitter& e = emitters[i];
    x_[i] = static_cast<float>(e.centre.x);
    y_[i] = static_cast<float>(e.centre.y);
    z_[i] = static_cast<float>(e.centre.z);
    normal_x_[i] = static_cast<float>(e.normal.x);
    normal_y_[i] = static_cast<float>(e.normal.y);
    normal_z_[i] = static_cast<float>(e.normal.z);
    flux_[i] = static_cast<float>(e.flux_lm);
  }
  rows_ = (emitters.size() + 3) / 4;
}

float SourceChoice::weigh(const Vec3& position, const Vec3& normal, Row& weights) const {
  constexpr float least = 0.1F;
  const auto px = static_cast<float>(position.x);
  const auto py = static_cast<float>(position.y);
  const auto pz = static_cast<float>(position.z);
  const auto nx = static_cast<float>(normal.x);
  const auto ny = static_cast<float>(normal.y);
  const auto nz = static_cast<float>(normal.z);
  float sum = 0.0F;
  for (std::size_t row = 0; row < rows_; ++row) {
    for (std::size_t i = 4 * row; i < 4 * row + 4; ++i) {
      const float x = x_[i] - px;
      const float y = y_[i] - py;
      const float z = z_[i] - pz;
      const float distance2 = x * x + y * y + z * z + 1e-12F;
      const float distance = std::sqrt(distance2);
      const float here = x * nx + y * ny + z * nz;
      const float there = -(x * normal_x_[i] + y * normal_y_[i] + z * normal_z_[i]);
      const float floor = least * distance;
      const float cosines = (here > floor ? here : floor) * (there > floor ? there : floor);
      weights[i] = flux_[i] * cosines / (distance2 * distance2);
    }
    sum +=
        (weights[4 * row] + weights[4 * row + 1]) + (weights[4 * row + 2] + weights[4 * row + 3]);
  }
  return sum;
}

SourceChoice::Choice SourceChoice::choose(const Vec3& position, const Vec3& normal,
                                          double u) const {
  const std::size_t count = flux_up_to_.size();
  if (count == 1) return {0, 1.0};
  if (rows_ == 0) {
    const std::size_t chosen = by_flux(u);
    return {chosen, probability(position, normal, chosen)};
  }
  Row weights;
  const float sum = weigh(position, normal, weights);
  // Without a branch, for no processor can foresee the choice.
  const float wanted = static_cast<float>(u) * sum;
  float up_to = 0.0F;
  std::size_t chosen = 0;
  for (std::size_t i = 0; i + 1 < count; ++i) {
    up_to += weights[i];
    chosen += wanted >= up_to ? 1 : 0;
  }
  return {chosen, static_cast<double>(weights[chosen]) / static_cast<double>(sum)};
}

double SourceChoice::probability(const Vec3& position, const Vec3& normal,
                                 std::size_t emitter) const {
  if (flux_up_to_.size() == 1) return 1.0;
  if (rows_ == 0) return flux_up_to_[emitter] - (emitter == 0 ? 0.0 : flux_up_to_[emitter - 1]);
  Row weights;
  const float sum = weigh(position, normal, weights);
  return static_cast<double>(weights[emitter]) / static_cast<double>(sum);
}

std::size_t SourceChoice::by_flux(double share) const {
  const auto found = std::upper_bound(flux_up_to_.begin(), flux_up_to_.end(), share);
  return std::min(static_cast<std::size_t>(found - flux_up_to_.begin()), flux_up_to_.size() - 1);
}

}  // namespace umov::chamber
