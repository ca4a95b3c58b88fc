// What a path carries: one number, or one a band.
//
// From the eye, `throughput` is what of a luminance at the path's end reaches the eye, and
// luminances that were met are added to what is seen. With the light, it is the flux itself.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "host/chamber/bands.hpp"
#include "host/chamber/emitter.hpp"
#include "host/chamber/surface.hpp"

namespace umov::chamber {

/// Lumens or cd/m² alone.
class PlainLight {
 public:
  double seen() const { return seen_; }

  /// The path has met an emitter of this luminance.
  void meet(const Emitter& /*emitter*/, double luminance) { seen_ += throughput_ * luminance; }
  /// Asks what a face makes of light from `other`; false: nothing, in any band.
  template <class Facing>
  bool ask(const Surface& /*surface*/, const Facing& facing, const Vec3& /*known*/,
           const Vec3& other) {
    value_ = facing.value(other);
    return value_ > 0.0;
  }
  /// The emitter's light, by way of the value last asked for.
  void receive(const Emitter& /*emitter*/, double scale) { seen_ += throughput_ * value_ * scale; }
  void scatter(const Surface& /*surface*/, const Drawn& drawn, const Vec3& /*known*/,
               Sense /*sense*/) {
    throughput_ *= drawn.weight;
  }
  void launch(const Emitter& /*emitter*/, double flux_lm) { throughput_ = flux_lm; }
  void scale(double factor) { throughput_ *= factor; }

  /// The largest number carried, for roulette from the eye.
  double strength() const { return throughput_; }
  double lumens() const { return throughput_; }
  void leave(std::span<double> /*spectrum_out*/) const {}

 private:
  double throughput_ = 1.0, seen_ = 0.0, value_ = 0.0;
};

/// Spectral radiance or W/nm, side by side.
class BandedLight {
 public:
  /// What is seen is added to `seen`, which lumens() does not need.
  BandedLight(const Bands& bands, std::span<double> seen)
      : bands_(bands), count_(bands.size()), seen_(seen) {
    std::fill_n(throughput_.begin(), count_, 1.0);
  }

  void meet(const Emitter& emitter, double luminance) {
    for (std::size_t b = 0; b < count_; ++b)
      seen_[b] += throughput_[b] * luminance * emitter.spectrum[b];
  }
  template <class Facing>
  bool ask(const Surface& surface, const Facing& /*facing*/, const Vec3& known, const Vec3& other) {
    surface.values(other, known, {values_.data(), count_});
    return std::any_of(values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(count_),
                       [](double f) { return f > 0.0; });
  }
  void receive(const Emitter& emitter, double scale) {
    for (std::size_t b = 0; b < count_; ++b)
      seen_[b] += throughput_[b] * values_[b] * scale * emitter.spectrum[b];
  }
  void scatter(const Surface& surface, const Drawn& drawn, const Vec3& known, Sense sense) {
    surface.weigh(drawn, known, sense, {throughput_.data(), count_});
  }
  void launch(const Emitter& emitter, double flux_lm) {
    for (std::size_t b = 0; b < count_; ++b) throughput_[b] = flux_lm * emitter.spectrum[b];
  }
  void scale(double factor) {
    for (std::size_t b = 0; b < count_; ++b) throughput_[b] *= factor;
  }

  double strength() const {
    return *std::max_element(throughput_.begin(),
                             throughput_.begin() + static_cast<std::ptrdiff_t>(count_));
  }
  double lumens() const { return bands_.luminous({throughput_.data(), count_}); }
  void leave(std::span<double> spectrum_out) const {
    for (std::size_t b = 0; b < count_; ++b) spectrum_out[b] += throughput_[b];
  }

 private:
  const Bands& bands_;
  std::size_t count_;
  std::span<double> seen_;
  std::array<double, Bands::most> throughput_, values_;
};

}  // namespace umov::chamber
