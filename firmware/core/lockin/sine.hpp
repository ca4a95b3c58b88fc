// Sine of a 32-bit phase in integers: the same bits on every machine.
#pragma once

#include <array>
#include <cstdint>

namespace umov::firmware {

/// Peak of the sine in which records are reported.
inline constexpr std::int32_t sine_amplitude = 32767;
/// Peak of sine_of(): finer, because sixteen bits would leave in-phase and quadrature sums of short
/// periods unequal by up to 1e-5, a phase error of as much.
inline constexpr unsigned fine_bits = 26;
inline constexpr std::int32_t fine_amplitude = 1 << fine_bits;
/// A quarter of a turn of phase.
inline constexpr std::uint32_t quarter_turn = 1u << 30;

namespace sine_detail {

inline constexpr unsigned index_bits = 10;
inline constexpr unsigned part_bits = 30 - index_bits;

/// 2^30 sin over the first quarter, 1025 knots; compile time only.
constexpr std::array<std::int32_t, (1u << index_bits) + 1> quarter_wave() {
  std::array<std::int32_t, (1u << index_bits) + 1> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double x = 1.57079632679489661923 * static_cast<double>(i) / (1u << index_bits);
    double term = x, sum = x;
    for (int k = 1; k < 14; ++k) {
      term *= -x * x / ((2.0 * k) * (2.0 * k + 1.0));
      sum += term;
    }
    table[i] = static_cast<std::int32_t>(sum * (1 << 30) + 0.5);
  }
  return table;
}

inline constexpr auto table = quarter_wave();

}  // namespace sine_detail

/// fine_amplitude sin(2 pi phase / 2^32). Linear between knots: wrong by at most 3e-7 of the peak.
/// Exactly odd and exactly symmetric about the quarter turns.
constexpr std::int32_t sine_of(std::uint32_t phase) {
  using namespace sine_detail;
  const std::uint32_t within = phase & (quarter_turn - 1u);
  const std::uint32_t x = (phase & quarter_turn) != 0 ? quarter_turn - within : within;
  const std::uint32_t i = x >> part_bits;
  const std::uint32_t part = x & ((1u << part_bits) - 1u);
  std::int64_t value = table[i];
  if (part != 0) value += (std::int64_t{table[i + 1] - table[i]} * part) >> part_bits;
  constexpr unsigned surplus = 30 - fine_bits;
  const auto scaled = static_cast<std::int32_t>((value + (1 << (surplus - 1))) >> surplus);
  return (phase >> 31) != 0 ? -scaled : scaled;
}

/// A sum of codes x fine sine in codes x sine, to the nearest.
constexpr std::int64_t from_fine(std::int64_t sum) {
  const std::int64_t whole = sum >> fine_bits;
  const std::int64_t part = sum & (fine_amplitude - 1);
  return whole * sine_amplitude + ((part * sine_amplitude + fine_amplitude / 2) >> fine_bits);
}

}  // namespace umov::firmware
