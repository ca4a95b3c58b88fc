// Random numbers that depend on nothing but (key, counter): the noise of an ADC sample is the same
// however the samples are asked for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace umov::plant {

/// A bijection of 64 bits with full avalanche (the finalizer of SplitMix64, Steele, Lea & Flood
/// 2014).
constexpr std::uint64_t mix(std::uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9u;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// 64 random bits of a counter under a key.
constexpr std::uint64_t random_bits(std::uint64_t key, std::uint64_t counter) {
  return mix(key + 0x9e3779b97f4a7c15u * (counter + 1));
}

/// A key for one purpose out of a seed and what distinguishes the purpose.
constexpr std::uint64_t derive_key(std::uint64_t seed, std::uint64_t purpose) {
  return mix(mix(seed ^ 0x6a09e667f3bcc909u) + 0xd1342543de82ef95u * (purpose + 1));
}

/// Uniform in (0, 1) from the upper 53 bits.
constexpr double uniform(std::uint64_t bits) {
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

/// Standard normal deviates from 32 random bits by the inverse distribution: 4096 linear pieces of
/// |z|, the last one (|z| > 3.67) exact to |z| = 6.2. Mean exact by symmetry; variance 1 within
/// 1e-4.
class GaussianTable {
 public:
  static const GaussianTable& instance();

  double operator()(std::uint32_t bits) const {
    const std::uint32_t magnitude = bits & 0x7fffffffu;
    const std::uint32_t cell = magnitude >> 19;
    double z;
    if (cell == cells - 1) [[unlikely]] {
      z = tail(magnitude);
    } else {
      const auto fraction = static_cast<double>(magnitude & 0x7ffffu) * 0x1p-19;
      z = edge_[cell] + (edge_[cell + 1] - edge_[cell]) * fraction;
    }
    return (bits >> 31) != 0 ? -z : z;
  }

 private:
  static constexpr std::uint32_t cells = 4096;
  GaussianTable();
  static double tail(std::uint32_t magnitude);

  std::array<double, cells> edge_{};
};

/// One standard normal deviate of (key, counter).
double gaussian_of(std::uint64_t key, std::uint64_t counter);

}  // namespace umov::plant
