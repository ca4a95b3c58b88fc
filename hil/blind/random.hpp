// Draws for the generator, the same on every machine.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "hil/plant/noise.hpp"

namespace umov::blind {

class Random {
 public:
  explicit Random(std::uint64_t key) : key_(key) {}

  /// Uniform in (0, 1).
  double uniform() { return plant::uniform(plant::random_bits(key_, counter_++)); }
  double between(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform in the logarithm; both limits > 0.
  double log_between(double low, double high) {
    return std::exp(between(std::log(low), std::log(high)));
  }
  double normal() { return plant::gaussian_of(key_, counter_++); }
  std::size_t below(std::size_t count) {
    return static_cast<std::size_t>(uniform() * static_cast<double>(count));
  }
  bool chance(double probability) { return uniform() < probability; }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }
  template <class T>
  void shuffle(std::span<T> items) {
    for (std::size_t left = items.size(); left > 1; --left) {
      std::swap(items[left - 1], items[below(left)]);
    }
  }

 private:
  std::uint64_t key_;
  std::uint64_t counter_ = 0;
};

}  // namespace umov::blind
