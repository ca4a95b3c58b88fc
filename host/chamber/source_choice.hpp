// Which source a path asks for light.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "host/chamber/emitter.hpp"

namespace umov::chamber {

/// One of few sources is chosen roughly in proportion to the irradiance that it would cause if
/// nothing were in between; never so rarely that a wrong guess costs much. One of many is chosen by
/// its flux alone.
class SourceChoice {
 public:
  explicit SourceChoice(const std::vector<Emitter>& emitters);

  struct Choice {
    std::size_t emitter;
    double probability;
  };
  /// For a place of a face, its unit normal, and u in [0, 1).
  Choice choose(const Vec3& position, const Vec3& normal, double u) const;
  /// Of choosing this one.
  double probability(const Vec3& position, const Vec3& normal, std::size_t emitter) const;
  /// By flux: the sources one after the other share [0, 1).
  std::size_t by_flux(double share) const;

 private:
  static constexpr std::size_t most_weighed = 16;
  using Row = std::array<float, most_weighed>;
  float weigh(const Vec3& position, const Vec3& normal, Row& weights) const;

  std::vector<double> flux_up_to_;  ///< as a share of all
  // Single precision, side by side: processors take several at once.
  Row x_{}, y_{}, z_{}, normal_x_{}, normal_y_{}, normal_z_{}, flux_{};
  std::size_t rows_ = 0;  ///< of four sources; beyond the last they have no flux
};

}  // namespace umov::chamber
