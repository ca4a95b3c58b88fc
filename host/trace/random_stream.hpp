// Random numbers of a path: a function of seed, sample and event alone (Philox, Salmon et al.
// 2011), so that no order of work and no number of threads can change them.
#pragma once

#include <Random123/philox.h>

#include <array>
#include <cstdint>

namespace umov::trace {

/// Four uniform numbers in [0, 1), multiples of 2⁻³² shifted by half of one (never 0, never 1).
/// Event 0 is the launch of the path, event n its nth meeting with matter.
inline std::array<double, 4> uniforms(std::uint64_t seed, std::uint64_t sample,
                                      std::uint32_t event) {
  const auto bits = r123::Philox4x32()(
      {{static_cast<std::uint32_t>(sample), static_cast<std::uint32_t>(sample >> 32), event, 0}},
      {{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}});
  constexpr double step = 1.0 / 4294967296.0;
  const auto unit = [&](std::uint32_t b) { return (static_cast<double>(b) + 0.5) * step; };
  return {unit(bits[0]), unit(bits[1]), unit(bits[2]), unit(bits[3])};
}

/// Eight of them at once, of a generator twice as wide and hardly slower. Numbers of their own:
/// independent of uniforms() of the same path.
inline std::array<double, 8> eight_uniforms(std::uint64_t seed, std::uint64_t sample,
                                            std::uint32_t event) {
  const auto bits = r123::Philox4x64()({{sample, event, 0, 0}}, {{seed, 0}});
  constexpr double step = 1.0 / 4294967296.0;
  std::array<double, 8> numbers;
  for (std::size_t i = 0; i < 4; ++i) {
    numbers[2 * i] = (static_cast<double>(static_cast<std::uint32_t>(bits[i])) + 0.5) * step;
    numbers[2 * i + 1] = (static_cast<double>(bits[i] >> 32) + 0.5) * step;
  }
  return numbers;
}

}  // namespace umov::trace
